# requires: build123d==0.13.0 cadquery-ocp-novtk==8.0.1.1.0
"""Build123d reads our STEP file, draws the rod, nests it, and writes it."""

import build123d as b
from rows import BAR, ENDS, MIDDLE, WIDTH, judge, row, solid


def drawn():
    rod = b.Pos(MIDDLE, 0, 0) * b.Box(*BAR)
    for x, ring, _ in ENDS:
        rod += b.Pos(x, 0, 0) * b.Cylinder(ring, WIDTH)
    for x, _, bore in ENDS:
        rod -= b.Pos(x, 0, 0) * b.Cylinder(bore, 2 * WIDTH)
    return rod.solid()


def reads(folder, known):
    found = b.import_step(folder / "rod.step").volume
    yield row("rod.step → build123d", "volume, mm³", found, known["step_mm3"], "unit", allowed=1e-4)


def writes(folder, size):
    rod = drawn().scale(size)
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
        b.export_brep(shape, folder / f"{name}.brep")
        yield solid(f"{name}.step", f"{name}, mm")
        yield solid(f"{name}.brep", f"{name}, mm")
    # Its files are in millimetres, multiplied by the unit: findings/build123d-step-unit.sh.
    for unit, scale in ((b.Unit.M, 1e-3), (b.Unit.IN, 1 / 25.4)):
        b.export_step(rod.scale(scale), folder / f"{unit.name}.step", unit=unit)
        yield solid(f"{unit.name}.step", f"part in {unit.name}, written with that unit")


judge(b.__version__, reads, writes)
