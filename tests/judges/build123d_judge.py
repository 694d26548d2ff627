# requires: build123d==0.13.0 cadquery-ocp-novtk==8.0.1.1.0
"""Build123d: reads our STEP file; draws the rod, nests it, and writes it in each format."""

import build123d as b
from rows import BAR, BORES, LENGTH, MIDDLE_OF_BAR, RINGS, WIDTH, Item, judge, row


def drawn():
    rod = b.Pos(MIDDLE_OF_BAR, 0, 0) * b.Box(*BAR)
    for x, radius in zip((0, LENGTH), RINGS, strict=True):
        rod += b.Pos(x, 0, 0) * b.Cylinder(radius, WIDTH)
    for x, radius in zip((0, LENGTH), BORES, strict=True):
        rod -= b.Pos(x, 0, 0) * b.Cylinder(radius, 2 * WIDTH)
    return rod.solid()


def reads(folder, known):
    solid = b.import_step(folder / "rod.step")
    yield row("rod.step → build123d", "volume of the solid, mm³", solid.volume, known["step_mm3"], "unit", 1e-4)


def writes(folder, spoil):
    rod = drawn()
    expected = {"volume_mm3": rod.volume, "length_mm": LENGTH}
    rod = rod.scale(1.01) if spoil else rod
    half = b.Pos(-50, 0, 0) * b.Box(100, 200, 100)
    body, cap = (rod - half).solid(), (rod & half).solid()
    body.label, cap.label = "body", "cap"
    inner = b.Compound(label="rod", children=[body, cap])
    inner.location = b.Location((-7, 0, 11), (10, 20, 30))
    outer = b.Compound(label="crank drive", children=[inner])
    outer.location = b.Location((1, 2, 3), (40, -10, 5))
    shapes = {"part": rod, "mirrored": rod.mirror(b.Plane.YZ), "nested": outer}
    for name, shape in shapes.items():
        b.export_step(shape, folder / f"{name}.step")
        yield Item(f"{name}.step", f"{name}, mm", "scaled", expected)
        b.export_brep(shape, folder / f"{name}.brep")
        yield Item(f"{name}.brep", f"{name}, mm", "scaled", expected)
    # What it writes with a unit is in millimetres all the same, multiplied (findings/build123d-step-unit.sh).
    b.export_step(rod.scale(1e-3), folder / "metre.step", unit=b.Unit.M)
    yield Item("metre.step", "part in metres, written with unit=M", "scaled", expected)


judge(b.__version__, reads, writes)
