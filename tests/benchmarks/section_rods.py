"""Random rods of each section: drawn, weighed, meshed and solved, or refused by a rule that is named.

    python tests/benchmarks/section_rods.py --count 500 --resume rods.json --report results/section-rods.md

Each rod is solved at the peaks of a random engine at full speed on a coarse mesh, its bores under prescribed
pressure. Mass, centre of gravity and inertia by quadrature are compared with those of twice its order, and
with the CAD kernel's. Where these differ by more than 1e-6, the kernel integrates once more, over the solid
cut into slices: it has no tolerance to tighten, its rule has few points on each face, and its error falls
with the size of the faces, while that of the quadrature does not.
"""

import math
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import gmsh
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from rod_studies import random_engine, random_rod
from scripts import command, keep, kept_in, publish, reporting

from fea.apps.result import analyse
from geometry import section as quadrature
from geometry.dimensions import ShankSection
from geometry.errors import InvalidValue
from geometry.mass import joined
from geometry.section import HeightField
from geometry.session import session
from geometry.solid import build, whole_mass
from geometry.surfaces import Mirror

WITHIN = 1e-6
SLICES = 24
COARSE = 8  # elements along the rod
SPREAD = 0.15  # of the logarithm of a dimension: about half of the rods break no rule


def off(found, drawn):
    """Largest relative difference of mass, centre of gravity and moments of inertia."""
    pairs = [(found.mass, drawn.mass), (found.center[0], drawn.center[0])]
    pairs += [(found.inertia[i][i], drawn.inertia[i][i]) for i in range(3)]
    return max(abs(a / b - 1) for a, b in pairs)


def sliced(rod):
    """The kernel's mass properties as the sum over slices along x and y."""
    occ, far = gmsh.model.occ, 4 * rod.length
    reach = (rod.big_end_radius, rod.length + rod.small_end_radius)
    with session():
        solid = build(rod)
        planes = []
        for axis, (first, last) in enumerate(((-reach[0], reach[1]), (0.0, 1.5 * reach[0]))):
            for at in np.linspace(first, last, SLICES + 1)[1:-1]:
                plane = (2, occ.addRectangle(-far / 2, -far / 2, 0, far, far))
                occ.rotate([plane], 0, 0, 0, *((0, 1, 0) if axis == 0 else (1, 0, 0)), math.pi / 2)
                occ.translate([plane], *(at * np.eye(3)[axis]))
                planes.append(plane)
        pieces, _ = occ.fragment([(3, tag) for part in solid.parts for tag in part.volumes], planes)
        return joined([whole_mass(tag, Mirror.QUARTER) for dim, tag in pieces if dim == 3])


def of_twice_the_order(rod):
    """Mass properties by a quadrature of twice the order."""
    nodes, weights = np.polynomial.legendre.leggauss(2 * len(quadrature._ANGLES))
    turned = (nodes + 1) * math.pi / 2
    finer = {"_SHARES": (1 - np.cos(turned)) / 2, "_SHARE_WEIGHTS": weights * np.sin(turned) * math.pi / 4}
    with patch.multiple(quadrature, **finer):
        return HeightField(rod).mass()


def outcome(seed, section, ribbed):
    """Outcome of a rod."""
    rod = random_rod(seed, section, SPREAD, ribbed=ribbed)
    if isinstance(rod, InvalidValue):
        return {"outcome": "refused", "by": rod.name}
    own = HeightField(rod).mass()
    found = {"off_order": off(own, of_twice_the_order(rod))}
    try:
        with session():
            found["off"] = off(own, build(rod).mass)
        if found["off"] > WITHIN:
            found["off_sliced"] = off(own, sliced(rod))
        study = random_engine(seed, rod)
        mesh = replace(study.mesh, size_mm=rod.length / COARSE)
        coarse = replace(study, mesh=mesh, analysis=replace(study.analysis, pressure="cosine-180"))
        result = analyse(coarse)
        failed = [name for name, check in result.checks.items() if not check.passed]
        return found | {"outcome": "marked" if failed else "solved", "by": ", ".join(failed)}
    except InvalidValue as refusal:
        return found | {"outcome": "refused", "by": refusal.name}
    except Exception as error:
        return found | {"outcome": "failed", "by": f"{type(error).__name__}: {error}"[:300]}


def row(section, kept):
    """The counts of a section as a row of the table, and what failed or was marked."""
    counts = Counter(one["outcome"] for one in kept.values())
    drawn = [one for one in kept.values() if "off" in one]
    apart = [one for one in drawn if one["off"] > WITHIN]
    worst = max((one["off"] for one in drawn), default=0.0)
    cut = max((one["off_sliced"] for one in apart), default=0.0)
    order = max((one["off_order"] for one in drawn), default=0.0)
    figures = [counts[kind] for kind in ("solved", "marked", "refused", "failed")]
    cells = [section, *figures, len(apart), f"{worst:.1e}", f"{cut:.1e}", f"{order:.1e}"]
    told = [
        f"- {section}, {seed}: {one['outcome']}: {one['by']}"
        for seed, one in kept.items()
        if one["outcome"] in ("marked", "failed")
    ]
    return "| " + " | ".join(map(str, cells)) + " |", told


def refusals(kept):
    by = Counter(one["by"] for of in kept.values() for one in of.values() if one["outcome"] == "refused")
    return "Refused by: " + ", ".join(f"`{name}` {count}" for name, count in by.most_common()) + "."


def main():
    parser = reporting(__doc__)
    parser.add_argument("--count", type=int, default=500, help="rods to solve of each section")
    parser.add_argument("--sections", nargs="+", default=[str(one) for one in ShankSection])
    parser.add_argument("--resume", type=Path, help="a JSON file to keep outcomes in")
    parser.add_argument(
        "--ribs", action="store_true", help="with bolts, rounded bosses and ribs on every cap"
    )
    arguments = parser.parse_args()
    kept = kept_in(arguments.resume)
    seed = 0
    while open_ := [
        name
        for name in arguments.sections
        if Counter(one["outcome"] for one in kept.get(name, {}).values())["solved"] < arguments.count
    ]:
        for name in open_:
            own = kept.setdefault(name, {})
            if str(seed) not in own:
                own[str(seed)] = outcome(seed, ShankSection(name), arguments.ribs)
        keep(arguments.resume, kept)
        seed += 1
    rows, told = zip(*(row(name, kept[name]) for name in kept), strict=True)
    text = "\n".join(
        [
            "# Rods of each section, drawn at random",
            "",
            f"Made by `{command()}`:",
            "every dimension of a rod in usual proportions scaled at random, with options, drilled or not,",
            "solved at the peaks of a random engine at full speed on a coarse mesh. The last columns are",
            "mass properties by quadrature against the CAD kernel: rods off by more than 1e-6, the largest",
            "difference, the largest where the kernel integrates those over slices of the solid, and that",
            "of all rods against a quadrature of twice the order. The kernel's rule has few points on each",
            "face, and no tolerance that could be set; its error falls with the size of the faces.",
            "",
            "| section | solved | marked | refused | failed | > 1e-6 | largest | sliced | twice the order |",
            "| --- | " + "---: | " * 8,
            *rows,
            "",
            refusals(kept),
            *["", *(line for lines in told for line in lines)],
            "",
        ]
    )
    publish(text, arguments.report)


if __name__ == "__main__":
    main()
