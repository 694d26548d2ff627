# requires: cadquery==2.8.0
"""CadQuery reads our STEP file; draws the rod as solid, splines and surfaces, in each format and unit."""

import cadquery as cq
from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert
from OCP.IGESControl import IGESControl_Writer
from rows import BAR, ENDS, MIDDLE, WIDTH, judge, row, solid

UNITS = {"mm": 1.0, "m": 1e-3, "in": 1 / 25.4}


def drawn() -> cq.Workplane:
    rod = cq.Workplane().box(*BAR).translate((MIDDLE, 0, 0))
    for x, ring, _ in ENDS:
        rod = rod.union(cq.Workplane().cylinder(WIDTH, ring).translate((x, 0, 0)))
    for x, _, bore in ENDS:
        rod = rod.cut(cq.Workplane().cylinder(2 * WIDTH, bore).translate((x, 0, 0)))
    return rod


def splines(shape):
    """Convert every face to rational splines."""
    return cq.Shape.cast(BRepBuilderAPI_NurbsConvert(shape.wrapped, True).Shape())  # noqa: FBT003 - a copy


def iges(shape, path, *, surfaces=False, unit="MM"):
    """Write a solid or its surfaces, in a unit that the file declares."""
    writer = IGESControl_Writer(unit, 0 if surfaces else 1)
    writer.AddShape(shape.wrapped)
    writer.ComputeModel()
    writer.Write(str(path))


def nested(pieces):
    """An assembly in an assembly; each is turned and moved."""
    inner, outer, top = (cq.Assembly(name=name) for name in ("rod", "crank_drive", "engine"))
    for name, piece in pieces.items():
        inner.add(cq.Workplane(piece), name=name)
    outer.add(inner, loc=cq.Location(cq.Vector(-7, 0, 11), cq.Vector(3, 1, 0), 65))
    top.add(outer, loc=cq.Location(cq.Vector(1, 2, 3), cq.Vector(1, 2, 3), 40))
    return top


def reads(folder, known):
    shape = cq.importers.importStep(str(folder / "rod.step")).val()
    found = shape.Volume() if shape.isValid() else 0.0
    yield row("rod.step → CadQuery", "volume, mm³", found, known["step_mm3"], "unit", allowed=1e-4)


def writes(folder, size):
    whole = drawn()
    part = whole.val().Solids()[0].scale(size)
    right = cq.Workplane().box(400, 100, 100, centered=(True, False, True))
    alone = {
        "part": part,
        "mirrored": part.mirror("YZ"),
        "split": whole.cut(right).val().fuse(whole.intersect(right).val()).scale(size),
        "splines": splines(part),
        "turned": splines(part.rotate(cq.Vector(), cq.Vector(1, 2, 3), 37)),
    }
    for name, shape in alone.items():
        cq.exporters.export(cq.Workplane(shape), str(folder / f"{name}.step"))
        iges(shape, folder / f"{name}.igs", surfaces=name == "splines")
        yield solid(f"{name}.step", f"{name}, mm")
        yield solid(f"{name}.igs", f"{name}, mm")
    half = cq.Workplane().box(100, 200, 100).translate((-50, 0, 0))
    pieces = {"body": whole.cut(half).val().scale(size), "cap": whole.intersect(half).val()}
    nested(pieces).export(str(folder / "nested.step"))
    yield solid("nested.step", "rod and cap, in an assembly of an assembly")
    for name, piece in pieces.items():
        for unit, scale in UNITS.items():
            scaled = piece.scale(scale)
            cq.exporters.export(cq.Workplane(scaled), str(folder / f"{name}_{unit}.step"))
            iges(scaled, folder / f"{name}_{unit}.igs")
            scaled.exportBrep(str(folder / f"{name}_{unit}.brep"))
        iges(piece, folder / f"{name}_surfaces.igs", surfaces=True)
        iges(piece, folder / f"{name}_inches.igs", surfaces=True, unit="INCH")
    kinds = ("mm.step", "mm.igs", "mm.brep", "surfaces.igs", "inches.igs")
    for body, cap in zip(kinds, kinds[1:] + kinds[:1], strict=True):
        yield solid(f"body_{body}", f"with cap_{cap}", "--cap", f"FOLDER/cap_{cap}")
    for unit in ("m", "in"):
        for ending in ("igs", "brep"):
            cap = f"cap_{unit}.{ending}"
            yield solid(f"body_{unit}.step", f"with {cap}", "--cap", f"FOLDER/{cap}", "--unit", unit)


judge(cq.__version__, reads, writes)
