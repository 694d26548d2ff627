# requires: cadquery==2.8.0
"""One rod as CadQuery writes it is one rod to `fea`: rational splines, IGES of surfaces, pairs of units.

The rod is of two rings and a bar; its volume is Open CASCADE's own, of the faces before they are converted.
"""

import os
import re
import subprocess
import sys
import tempfile
from itertools import product
from pathlib import Path

import cadquery as cq
from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert
from OCP.IGESControl import IGESControl_Writer

LENGTH, WIDTH, BORES = 150.0, 24.0, (52.0, 24.0)
DENSITY = 7.7e-6  # kg/mm³, of the material that `fea rod` assumes
# Relative; `fea rod` prints four digits, and sewn surfaces miss the volume by less than this.
CLOSE = 1e-3
INCH = 1 / 25.4


def drawn() -> cq.Workplane:
    """Draw the rod, mm."""
    ring, pin = cq.Workplane().cylinder(WIDTH, 38), cq.Workplane().cylinder(WIDTH, 20)
    bar = cq.Workplane().box(120, 18, 16).translate((80, 0, 0))
    rod = ring.union(pin.translate((LENGTH, 0, 0))).union(bar)
    for radius, x in zip(BORES, (0.0, LENGTH), strict=True):
        rod = rod.cut(cq.Workplane().cylinder(40, radius / 2).translate((x, 0, 0)))
    return rod


def splines(solid: cq.Shape) -> cq.Shape:
    """Convert every face to rational splines."""
    return cq.Shape.cast(BRepBuilderAPI_NurbsConvert(solid.wrapped, True).Shape())  # noqa: FBT003 - a copy


def iges(solid: cq.Shape, path: Path, mode: int, unit: str = "MM") -> None:
    """Write surfaces (mode 0) or a solid (1), in a unit that the file declares."""
    writer = IGESControl_Writer(unit, mode)
    writer.AddShape(solid.wrapped)
    writer.ComputeModel()
    writer.Write(str(path))


def step(solid: cq.Shape, path: Path) -> None:
    """Write a STEP file that declares mm."""
    cq.exporters.export(cq.Workplane(solid), str(path))


def cases(folder: Path) -> list[list[str]]:
    """Write the files; return the arguments of `fea rod` that give the rod."""
    whole = drawn()
    solid = whole.val().Solids()[0]
    step(splines(solid), folder / "splines.step")
    step(splines(solid.rotate(cq.Vector(), cq.Vector(1, 2, 3), 37)), folder / "turned.step")
    iges(splines(solid), folder / "splines.igs", 0)
    half = cq.Workplane().box(100, 200, 100).translate((-50, 0, 0))
    pieces = {"body": whole.cut(half).val().Solids()[0], "cap": whole.intersect(half).val().Solids()[0]}
    for (name, piece), (unit, scale) in product(pieces.items(), (("mm", 1.0), ("m", 1e-3), ("in", INCH))):
        scaled = piece.scale(scale)
        step(scaled, folder / f"{name}_{unit}.step")
        iges(scaled, folder / f"{name}_{unit}1.igs", 1)
        scaled.exportBrep(str(folder / f"{name}_{unit}.brep"))
    for name, piece in pieces.items():
        iges(piece, folder / f"{name}_surfaces.igs", 0)
        iges(piece, folder / f"{name}_inches.igs", 0, "INCH")
    kinds = ("mm.step", "mm1.igs", "mm.brep", "surfaces.igs")
    pairs = [(f"body_{one}", f"cap_{other}") for one, other in product(kinds, kinds)]
    pairs += [("body_mm.step", "cap_inches.igs"), ("body_inches.igs", "cap_mm.step")]
    named = [
        [f"body_{unit}{one}", "--cap", f"cap_{unit}{other}", "--unit", unit]
        for unit, one, other in product(("m", "in"), (".step", "1.igs"), (".step", "1.igs", ".brep"))
    ]
    alone = [["splines.step"], ["turned.step"], ["splines.igs"]]
    return [*alone, *([body, "--cap", cap] for body, cap in pairs), *named]


def main() -> int:
    """Judge the rods; return the exit code."""
    known = drawn().val().Solids()[0].Volume() * DENSITY
    # This environment has no `fea`: it runs in that of run.py.
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    fea, wrong = [os.environ["FEA_PYTHON"], "-m", "fea", "rod"], 0
    with tempfile.TemporaryDirectory() as scratch:
        for arguments in cases(Path(scratch)):
            run = subprocess.run(
                [*fea, *arguments], cwd=scratch, env=environment, capture_output=True, text=True, check=False
            )
            told = re.search(r": ([\d.]+) kg, ([\d.]+) mm between", run.stdout)
            long = [float(length) for length in re.findall(r"mm, ([\d.]+) mm long", run.stdout)]
            found = (*map(float, told.groups()), *long) if told else ()
            expected = (known, LENGTH, WIDTH, WIDTH)
            right = len(found) == len(expected) and all(
                abs(one - other) <= CLOSE * other for one, other in zip(found, expected, strict=True)
            )
            wrong += not right
            shown = found or run.stderr.strip()[:120]
            print(
                *(" ".join(arguments), "kg, mm", shown, expected, "yes" if right else "NO"),
                sep=" | ",
                flush=True,
            )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
