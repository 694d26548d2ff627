"""Mesh of the León rod against element size: time, quality, and mass properties against the CAD kernel's.

python tests/benchmarks/meshing.py --report results/meshing.md
"""

import time

import numpy as np
from scripts import reporting

from fea.solid.inertia import inertia
from geometry.mass import MassProperties
from geometry.presets import PRESETS
from geometry.session import session
from geometry.solid import build
from mesh.generate import tetrahedralise
from mesh.sizing import Sizing, default_size, refinements
from mesh.tetmesh import reflect, unmirrored

LEON_2001 = PRESETS["leon-2001"]
SIZES = (16.0, 12.0, 8.0, 6.0, default_size(LEON_2001.length), 4.0, 3.0)
HEAD = (
    "size mm", "nodes, whole rod", "elements", "mesh s", "least shape", "median shape",
    "least scaled Jacobian", "straightened", "mass", "centre", "inertia",
)  # fmt: skip

TEXT = """# Meshing the León rod

Made by `python tests/benchmarks/meshing.py --report results/meshing.md`. A quarter is meshed and reflected;
the last three columns are relative differences of mass, centre of gravity and inertia (largest tensor entry)
from the CAD kernel's. Refinements follow the size in proportion. Seconds are of one run on a shared two-core

LEON_2001 = PRESETS["leon-2001"]
machine.

{table}

The mass converges like size^{slope:.1f}.
"""


def row(size: float) -> tuple[object, ...]:
    """One mesh, and how far its mass properties are from the kernel's."""
    with session():
        solid = build(LEON_2001)
        start = time.perf_counter()
        refined = refinements(solid.features, size, LEON_2001.length)
        mesh, quality = tetrahedralise(solid.faces, refined, Sizing(size))
        seconds = time.perf_counter() - start
    whole = unmirrored(mesh)
    for plane in solid.mirror.planes:
        whole = reflect(whole, plane)
    errors = misfits(inertia(mesh, 1.0).properties, solid.mass)
    return (
        size, len(whole.mesh.points), len(whole.mesh.tets), seconds,
        quality.least_shape, quality.median_shape, quality.least_scaled_jacobian, quality.straightened,
        *errors,
    )  # fmt: skip


def misfits(mesh: MassProperties, kernel: MassProperties) -> tuple[float, float, float]:
    """Relative differences of mass, centre and the inertia tensor's largest entry."""
    tensor = np.array(mesh.inertia) - np.array(kernel.inertia)
    return (
        abs(mesh.mass / kernel.mass - 1),
        abs(mesh.center[0] / kernel.center[0] - 1),
        float(np.abs(tensor).max() / np.abs(kernel.inertia).max()),
    )


def main() -> None:
    """Print the table, and write it where asked."""
    parser = reporting(__doc__)
    report = parser.parse_args().report
    rows = [row(size) for size in SIZES]
    lines = [f"| {' | '.join(HEAD)} |", "|" + " --- |" * len(HEAD)]
    for size, *others in rows:
        cells = (f"{value:.2g}" if isinstance(value, float) else str(value) for value in others)
        lines.append(f"| {size:.4g} | {' | '.join(cells)} |")
    slope = np.polyfit(np.log([r[0] for r in rows]), np.log([r[8] for r in rows]), 1)[0]
    text = "\n".join(lines)
    print(text)
    if report:
        report.write_text(TEXT.format(table=text, slope=slope), encoding="utf-8")


if __name__ == "__main__":
    main()
