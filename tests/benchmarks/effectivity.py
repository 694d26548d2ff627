"""Estimated over true error in the energy norm: on exact solutions, and on the rod against a finer mesh.

    python tests/benchmarks/effectivity.py

Between 0.9 and 2 is the goal (Zienkiewicz & Zhu 1987 call the ratio effectivity). On the rod the truth is
known between two bounds.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from energy_errors import effectivity, manufactured_effectivity, rod_effectivity
from exact_bodies import MATERIAL, PROBLEMS, solved

SIZES = (0.5, 0.3, 0.2)
ROD_SIZES, FINER = (12.0, 9.0, 6.0), 3.6


def main() -> None:
    """Print a line a body, element order and size."""
    for order in (1, 2):
        for name, problem in PROBLEMS.items():
            for size in SIZES:
                found = solved(name, size, order=order)
                stress = found.stress[:, :, None]
                ratio = effectivity(found.mesh, found.displacement, stress, problem.stress, MATERIAL)
                print(f"| {name} | P{order} | {size} | {ratio:.2f} |", flush=True)
        print(f"| manufactured | P{order} | 0.25 | {manufactured_effectivity(0.25, order):.2f} |", flush=True)
    for size in ROD_SIZES:
        least, most = rod_effectivity(size, FINER)
        print(f"| rod, tension | P2 | {size} mm | {least:.2f} … {most:.2f} |", flush=True)


if __name__ == "__main__":
    main()
