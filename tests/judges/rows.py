"""What judges share: rows of the report, files for `fea` to read, exact volumes of tetrahedra.

A judge has a function `reads(folder, known)`, which yields a `Row` for each thing that the program finds in
our files, and `writes(folder, size)`, which writes files and yields an `Item` for each. Each names the
fault that turns it wrong: `python judge.py FOLDER --break` reads the files of FOLDER/spoiled/FAULT, and
writes with a size of 1.01.
"""

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

# What our spoiled files have: see `our_files.spoiled`.
FAULTS = ("turned", "middles", "scaled", "lost", "tensor", "names", "times", "unit")
EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))  # VTK's order of the mid-side nodes
# From the turned order of nodes of MED and SMESH to VTK's, and back.
TURN = {4: [0, 2, 1, 3], 10: [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]}
# Relative: what files of seven digits leave of a volume, single precision and rounding of a stress, flat
# triangles of a volume, and six digits of `fea rod --json` and five of Nastran's fields of one.
CLOSE, STRESS, FLAT, MESH = 2e-6, 5e-4, 2e-3, 1e-4
# The rod that every CAD program draws, mm: two rings with their bores, 24 thick, and a bar between them.
LENGTH, WIDTH, RINGS, BORES, BAR, MIDDLE = 150.0, 24.0, (38.0, 20.0), (26.0, 12.0), (120.0, 18.0, 16.0), 80.0
ENDS = tuple(zip((0.0, LENGTH), RINGS, BORES, strict=True))
# Its volume, mm³, as Open CASCADE measures it; `fea` measures within this of it.
VOLUME, SOLID = 104007.755, 1e-3


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
    expected: dict[str, float]  #: figure of `fea rod --json`, or of a pressure trace, and its value
    allowed: float  #: relative difference
    options: tuple[str, ...] = ()
    fault: str = "scaled"


def solid(file: str, tried: str, *options: str, fault: str = "scaled") -> Item:
    """Return a file of the rod that CAD programs draw."""
    return Item(file, tried, {"volume_mm3": VOLUME, "length_mm": LENGTH}, SOLID, options, fault)


def mesh(file: str, tried: str, volume: float, length: float = 141.0) -> Item:
    """Return a file of a mesh, of the run's rod or of one that is `length` long."""
    return Item(file, tried, {"volume_mm3": float(volume), "length_mm": length}, MESH)


def row(crossing: str, tried: str, found: Any, expected: Any, fault: str, *, allowed: float = 0.0) -> Row:
    """Compare numbers within a relative difference, or anything exactly."""
    if isinstance(expected, float):
        right = bool(abs(found - expected) <= allowed * abs(expected))
        return Row(crossing, tried, f"{found:.7g}", f"{expected:.7g} ± {allowed:g}", right, fault)
    return Row(crossing, tried, str(found), str(expected), bool(found == expected), fault)


def volumes(points: Any, tets: Any) -> Any:
    """Return the exact signed volumes of four- or ten-node tetrahedra: a rule for cubics (Keast 1986)."""
    corners = np.asarray(points, dtype=float)[np.asarray(tets)]
    middles = corners[:, 4:] if corners.shape[1] == 10 else corners[:, EDGES].mean(axis=2)
    total = np.zeros(len(corners))
    rule = [(-4 / 5, np.full(4, 0.25)), *((9 / 20, (1 + 2 * corner) / 6) for corner in np.eye(4))]
    for weight, place in rule:
        slopes = (4 * place - 1)[:, None] * corners[:, :4]
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
    yield row(crossing, "volume, mm³", each.sum(), known["volume_mm3"], "scaled", allowed=CLOSE)
    yield row(crossing, "elements inside out", int((each <= 0).sum()), 0, "turned")
    ends = points[tets[:, :4]][:, EDGES]
    away = np.linalg.norm(points[tets[:, 4:]] - ends.mean(axis=2), axis=2)
    share = float((away / np.linalg.norm(ends[:, :, 0] - ends[:, :, 1], axis=2)).max())
    said = "mid-side nodes off the middle, of the edge"
    yield Row(crossing, said, f"{share:.3f}", "below 0.3", share < 0.3, "middles")


def of_stress(crossing: str, known: dict[str, Any], points: Any, stress: Any) -> Row:
    """Return the stress tensor at the most stressed node; `stress` (n, 6) is XX YY ZZ XY YZ XZ, MPa."""
    node = np.linalg.norm(np.asarray(points) - known["at_mm"], axis=1).argmin()
    found, expected = np.asarray(stress)[node], np.array(known["stress_MPa"])
    said, asked = (" ".join(f"{value:.2f}" for value in values) for values in (found, expected))
    right = bool(np.abs(found - expected).max() < STRESS * np.abs(expected).max())
    return Row(crossing, "stress XX YY ZZ XY YZ XZ, MPa", said, asked, right, "tensor")


def of_names(crossing: str, known: dict[str, Any], found: dict[str, int]) -> Row:
    """Return the named surfaces with their numbers of triangles."""
    said, expected = (
        ", ".join(f"{name} {count}" for name, count in sorted(each.items()))
        for each in (found, known["surfaces"])
    )
    return row(crossing, "surfaces and their triangles", said, expected, "names")


Reads = Callable[[Path, dict[str, Any]], Iterable[Row]]
Writes = Callable[[Path, float], Iterable[Item]]


def judge(
    version: str, reads: Reads | None = None, writes: Writes | None = None, faults: Sequence[str] = FAULTS
) -> None:
    """Print version, rows and items as JSON, one a line: what each judge ends with."""
    folder, breaking = Path(sys.argv[1]), "--break" in sys.argv
    known = json.loads((folder / "known.json").read_text(encoding="utf-8"))
    print(json.dumps({"version": version}))
    for fault in (faults if breaking else ("",)) if reads else ():
        lines = iter(reads(folder / "spoiled" / fault if fault else folder, known))
        try:
            first = [next(lines)]
        except Exception as error:  # a program may refuse a spoiled file in any way
            if not fault:
                raise
            print(json.dumps({"refused": {fault: " ".join(str(error).split())[:60]}}), flush=True)
            continue
        for line in chain(first, lines):
            if fault in {"", line.fault}:
                print(json.dumps({"row": asdict(line)}), flush=True)
    if writes is not None:
        out = folder / ("written-spoiled" if breaking else "written") / Path(sys.argv[0]).stem
        out.mkdir(parents=True, exist_ok=True)
        for item in writes(out, 1.01 if breaking else 1.0):
            print(json.dumps({"item": asdict(item) | {"folder": str(out)}}), flush=True)
