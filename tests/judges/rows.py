"""What judges share: rows of the report, files for `fea` to read, exact volumes of tetrahedra.

A judge has functions `reads(folder)`, which yields a `Row` for each thing that the program finds in our files, and
`writes(folder, spoil)`, which writes files and yields an `Item` for each. Each row and item names the fault that turns
it wrong: `python judge.py FOLDER --break` reads files that have it (in FOLDER/spoiled/FAULT), and writes files with
it. Needs numpy alone, of any version.
"""

import json
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

# Faults of written files: two vertices exchanged, two mid-side nodes exchanged, 1 % too large, an element lost, two
# components of the stress exchanged, the names of two surfaces exchanged, another crank angle, another unit declared.
FAULTS = ("turned", "middles", "scaled", "lost", "tensor", "names", "times", "unit")
EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))  # VTK's order of the mid-side nodes
# Relative. What files of seven digits leave of a volume; what single precision and rounding leave of a stress.
CLOSE, STRESS = 2e-6, 5e-4
# The rod that every CAD program draws, mm: rings of radii 38 and 20, both 24 thick, bores, a bar of 120 × 18 × 16.
LENGTH, WIDTH, RINGS, BORES, BAR = 150.0, 24.0, (38.0, 20.0), (26.0, 12.0), (120.0, 18.0, 16.0)
MIDDLE_OF_BAR = 80.0
# The bound of the volume of a CAD file, relative: what `fea` measures on its mesh of curved tetrahedra.
SOLID = 1e-3
INCH = 25.4


@dataclass
class Row:
    """One figure of one crossing."""

    crossing: str
    tried: str
    found: str
    expected: str
    right: bool
    fault: str


@dataclass
class Item:
    """A file for `fea` to read, with the options of `fea rod` and what it must find there."""

    file: str
    tried: str
    fault: str
    expected: dict[str, float]  #: figure of `fea rod --json`, or of a pressure trace, and its value
    allowed: float = SOLID  #: relative difference
    options: Sequence[str] = field(default=())


def row(crossing: str, tried: str, found: Any, expected: Any, fault: str, allowed: float = 0.0) -> Row:
    """Compare numbers within a relative difference, or anything exactly."""
    if isinstance(expected, float | int) and not isinstance(expected, bool):
        right = bool(abs(found - expected) <= allowed * abs(expected))
        bar = f" ± {allowed:g}" if allowed else ""
        return Row(crossing, tried, f"{found:.7g}", f"{expected:.7g}{bar}", right, fault)
    return Row(crossing, tried, str(found), str(expected), found == expected, fault)


def corner_weights() -> Iterator[tuple[float, Sequence[float]]]:
    """Yield weights and barycentric coordinates of a rule that is exact for cubic polynomials (Keast 1986)."""
    yield -4 / 5, (0.25,) * 4
    for corner in range(4):
        yield 9 / 20, [1 / 2 if k == corner else 1 / 6 for k in range(4)]


def volumes(points: Any, tets: Any) -> Any:
    """Return the exact signed volumes of four- or ten-node tetrahedra, their nodes in VTK's order."""
    corners = np.asarray(points, dtype=float)[np.asarray(tets)]
    middles = corners[:, 4:] if corners.shape[1] == 10 else corners[:, EDGES].mean(axis=2)
    total = np.zeros(len(corners))
    for weight, place in corner_weights():
        slopes = (4 * np.array(place) - 1)[:, None] * corners[:, :4]
        for middle, (i, j) in enumerate(EDGES):
            slopes[:, i] += 4 * place[j] * middles[:, middle]
            slopes[:, j] += 4 * place[i] * middles[:, middle]
        total += weight * np.linalg.det(slopes[:, 1:] - slopes[:, :1]) / 6
    return total


def of_mesh(crossing: str, known: dict[str, Any], points: Any, tets: Any) -> Iterator[Row]:
    """Yield what a reader says about nodes and elements; `tets` in VTK's order."""
    points, tets = np.asarray(points, dtype=float), np.asarray(tets)
    each = volumes(points, tets)
    yield row(crossing, "nodes", len(np.unique(tets)), known["nodes"], "lost")
    yield row(crossing, "ten-node tetrahedra", len(tets) * (tets.shape[1] == 10), known["elements"], "lost")
    yield row(crossing, "volume, with its sign, mm³", each.sum(), known["volume_mm3"], "scaled", CLOSE)
    yield row(crossing, "elements inside out", int((each <= 0).sum()), 0, "turned")
    ends = points[tets[:, :4]][:, EDGES]
    away = np.linalg.norm(points[tets[:, 4:]] - ends.mean(axis=2), axis=2)
    share = float((away / np.linalg.norm(ends[:, :, 0] - ends[:, :, 1], axis=2)).max())
    yield Row(crossing, "mid-side node off the middle, of the edge", f"{share:.3f}", "< 0.3", share < 0.3, "middles")


def of_stress(crossing: str, known: dict[str, Any], points: Any, stress: Any) -> Iterator[Row]:
    """Yield the stress tensor at the most stressed node; `stress` (n, 6) is XX YY ZZ XY YZ XZ, MPa."""
    node = np.linalg.norm(np.asarray(points) - known["at_mm"], axis=1).argmin()
    off = np.abs(np.asarray(stress)[node] - known["stress_MPa"]).max() / known["von_mises_MPa"]
    said = " ".join(f"{value:.2f}" for value in np.asarray(stress)[node])
    expected = " ".join(f"{value:.2f}" for value in known["stress_MPa"])
    yield Row(crossing, "stress XX YY ZZ XY YZ XZ, MPa", said, expected, bool(off < STRESS), "tensor")


def of_names(crossing: str, known: dict[str, Any], found: dict[str, int]) -> Iterator[Row]:
    """Yield the named surfaces with their numbers of triangles."""
    expected = known["surfaces"]
    yield row(crossing, "surfaces", dict(sorted(found.items())), dict(sorted(expected.items())), "names")


Reads = Callable[[Path, dict[str, Any]], Iterable[Row]]
Writes = Callable[[Path, bool], Iterable[Item]]


def judge(version: str, reads: Reads | None = None, writes: Writes | None = None) -> None:
    """Print version, rows and items as JSON, one a line: what each judge ends with."""
    folder, breaking = Path(sys.argv[1]), "--break" in sys.argv
    known = json.loads((folder / "known.json").read_text(encoding="utf-8"))
    print(json.dumps({"version": version}))
    for fault in FAULTS if breaking else ("",):
        place = folder / "spoiled" / fault if fault else folder
        if reads is None or not place.is_dir():
            continue
        try:
            for line in reads(place, known):
                if fault in {"", line.fault}:
                    print(json.dumps({"row": asdict(line)}), flush=True)
        except Exception:  # a program may refuse a spoiled file in any way
            if not fault:
                traceback.print_exc()
                sys.exit(1)
    if writes is not None:
        out = folder / ("written-spoiled" if breaking else "written") / Path(sys.argv[0]).stem
        out.mkdir(parents=True, exist_ok=True)
        for item in writes(out, breaking):
            print(json.dumps({"item": asdict(item) | {"folder": str(out)}}), flush=True)
