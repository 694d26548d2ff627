# requires: cadquery==2.8.0
"""CadQuery: reads our STEP file; draws the rod, nests it, makes splines and surfaces of it, in each format and unit."""

from itertools import product

import cadquery as cq
from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert
from OCP.IGESControl import IGESControl_Writer
from rows import BAR, BORES, INCH, LENGTH, MIDDLE_OF_BAR, RINGS, WIDTH, Item, judge, row


def drawn() -> cq.Workplane:
    """Draw the rod, mm."""
    ring, pin = (cq.Workplane().cylinder(WIDTH, radius) for radius in RINGS)
    bar = cq.Workplane().box(*BAR).translate((MIDDLE_OF_BAR, 0, 0))
    rod = ring.union(pin.translate((LENGTH, 0, 0))).union(bar)
    for radius, x in zip(BORES, (0.0, LENGTH), strict=True):
        rod = rod.cut(cq.Workplane().cylinder(40, radius).translate((x, 0, 0)))
    return rod


def splines(solid: cq.Shape) -> cq.Shape:
    """Convert every face to rational splines."""
    return cq.Shape.cast(BRepBuilderAPI_NurbsConvert(solid.wrapped, True).Shape())  # noqa: FBT003 - a copy


def iges(solid, path, mode, unit="MM"):
    """Write surfaces (mode 0) or a solid (1), in a unit that the file declares."""
    writer = IGESControl_Writer(unit, mode)
    writer.AddShape(solid.wrapped)
    writer.ComputeModel()
    writer.Write(str(path))


def step(solid, path):
    """Write a STEP file that declares mm."""
    cq.exporters.export(cq.Workplane(solid), str(path))


def nested(solids):
    """An assembly in an assembly; each is turned and moved."""
    outer, inner = cq.Assembly(name="crank_drive"), cq.Assembly(name="rod")
    for name, solid in solids.items():
        inner.add(cq.Workplane(solid), name=name, loc=cq.Location(cq.Vector(0, 0, 0)))
    turned = cq.Location(cq.Vector(-7, 0, 11), cq.Vector(3, 1, 0), 65)
    outer.add(inner, loc=turned)
    top = cq.Assembly(name="engine")
    top.add(outer, loc=cq.Location(cq.Vector(1, 2, 3), cq.Vector(1, 2, 3), 40))
    return top


def reads(folder, known):
    solid = cq.importers.importStep(str(folder / "rod.step")).val()
    yield row("rod.step → CadQuery", "volume of the solid, mm³", solid.Volume(), known["step_mm3"], "unit", 1e-4)
    yield row("rod.step → CadQuery", "valid", solid.isValid(), True, "")


def writes(folder, spoil):
    whole = drawn()
    solid = whole.val().Solids()[0]
    expected = {"volume_mm3": solid.Volume(), "length_mm": LENGTH}
    solid = solid.scale(1.01 if spoil else 1.0)
    halves = cq.Workplane().box(400, 100, 100, centered=(True, False, True))
    alone = {
        "part": solid,
        "mirrored": solid.mirror("YZ"),
        "split": whole.cut(halves).val().fuse(whole.intersect(halves).val()).scale(1.01 if spoil else 1.0),
        "splines": splines(solid),
        "turned": splines(solid.rotate(cq.Vector(), cq.Vector(1, 2, 3), 37)),
    }
    for name, shape in alone.items():
        step(shape, folder / f"{name}.step")
        iges(shape, folder / f"{name}.igs", 0 if name == "splines" else 1)
        for ending in ("step", "igs"):
            yield Item(f"{name}.{ending}", f"{name}, mm", "scaled", expected)
    half = cq.Workplane().box(100, 200, 100).translate((-50, 0, 0))
    pieces = {"body": whole.cut(half).val().Solids()[0], "cap": whole.intersect(half).val().Solids()[0]}
    if spoil:
        pieces["body"] = pieces["body"].scale(1.01)
    nested(pieces).export(str(folder / "nested.step"))
    yield Item("nested.step", "rod and cap, in an assembly of an assembly", "scaled", expected)
    for (name, piece), (unit, scale) in product(pieces.items(), (("mm", 1.0), ("m", 1e-3), ("in", 1 / INCH))):
        scaled = piece.scale(scale)
        step(scaled, folder / f"{name}_{unit}.step")
        iges(scaled, folder / f"{name}_{unit}1.igs", 1)
        scaled.exportBrep(str(folder / f"{name}_{unit}.brep"))
    for name, piece in pieces.items():
        iges(piece, folder / f"{name}_surfaces.igs", 0)
        iges(piece, folder / f"{name}_inches.igs", 0, "INCH")
    kinds = ("mm.step", "mm1.igs", "mm.brep", "surfaces.igs")
    pairs = [*zip(kinds, kinds[1:] + kinds[:1]), ("mm.step", "inches.igs"), ("inches.igs", "mm.step")]
    named = [(f"{unit}.step", f"{unit}{other}", unit) for unit in ("m", "in") for other in ("1.igs", ".brep")]
    for one, other, *unit in [*pairs, *named]:
        options = ["--cap", f"FOLDER/cap_{other}", *(["--unit", *unit] if unit else [])]
        yield Item(f"body_{one}", f"with cap_{other}", "scaled", expected, options=options)


judge(cq.__version__, reads, writes)
