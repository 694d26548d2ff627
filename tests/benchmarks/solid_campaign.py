"""Divide a rod into solids in random ways, and compare mass and safety factor with those of the whole rod.

    python -m tests.benchmarks.solid_campaign [--count 60] [--seed 1] [--solve] [--rod plain|shank]

Each way is one of `WAYS`, at random places and angles. A result is right if the mass is within 0.1 % of the
whole rod's and, with --solve, the safety factor within the error bars of both; a refusal must name a remedy.
Exit code 1: a result is wrong without a word, or fewer than three of four are right.
"""

import argparse
import json
import math
import random
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import gmsh

from geometry.cad.imported import import_cad
from geometry.errors import GeometryError
from geometry.imports import RodFile
from geometry.presets import PRESETS
from geometry.session import session
from geometry.solid import build
from geometry.surfaces import Mirror

LENGTH, BIG, SMALL = 120.0, 25.0, 11.0
_FAR = 1000.0
_REMEDIES = ("rod.solids", "CAD program", "rod.big_end_bore_mm")


def plain(occ):
    """Draw two rings and a bar."""
    rings = [(3, occ.addCylinder(x, 0, -10, 0, 0, 20, radius)) for x, radius in ((0, 34), (LENGTH, 18))]
    body, _ = occ.fuse(rings[:1], [*rings[1:], (3, occ.addBox(0, -9, -6, LENGTH, 18, 12))])
    bores = [(3, occ.addCylinder(x, 0, -20, 0, 0, 40, r)) for x, r in ((0, BIG), (LENGTH, SMALL))]
    return occ.cut(body, bores)[0]


def shank(occ):
    """Draw a rod with fillets and pockets from its dimensions."""
    solid = build(next(iter(PRESETS.values())), Mirror.NONE)
    return [(3, tag) for part in solid.parts for tag in part.volumes]


RODS = {"plain": plain, "shank": shank}


def _cut(occ, solids, planes):
    """Cut solids along planes, each given by a point and a normal."""
    tools = []
    for point, normal in planes:
        tools.append((2, occ.addDisk(*point, _FAR, _FAR, -1, list(normal), [])))
    made, parts = occ.fragment(solids, tools)
    occ.remove([piece for piece in made if piece[0] == 2], recursive=True)
    return [piece for of_one in parts[: len(solids)] for piece in of_one if piece[0] == 3]


def _level(occ, solids, heights):
    return _cut(occ, solids, [((0, 0, z), (0, 0, 1)) for z in heights])


def _through_bores(occ, solids, draw, length):
    planes = []
    for _ in range(draw.randint(1, 3)):
        angle, x = draw.uniform(0, math.pi), draw.choice((0.0, length))
        planes.append(
            ((x, 0, 0), (math.cos(angle), math.sin(angle), draw.choice((0, draw.uniform(-0.3, 0.3)))))
        )
    return _cut(occ, solids, planes)


def _layers(occ, solids, draw, _length):
    return _level(occ, solids, sorted(draw.uniform(-9, 9) for _ in range(draw.randint(1, 4))))


def _halves(occ, solids, draw, _length):
    normal = draw.choice(((0, 0, 1), (0, 1, 0), (0, 1, draw.uniform(-1, 1))))
    return _cut(occ, solids, [((0, 0, 0), normal)])


def _cap(occ, solids, draw, _length):
    half = math.radians(draw.choice((0, 0, draw.uniform(-50, 50))))
    pieces = _cut(occ, solids, [((draw.uniform(-4, 4), 0, 0), (math.cos(half), math.sin(half), 0))])
    return _level(occ, pieces, [0.0]) if draw.random() < 0.5 else pieces


def _across(occ, solids, draw, length):
    return _cut(occ, solids, [((draw.uniform(0.2, 0.8) * length, 0, 0), (1, draw.uniform(-0.5, 0.5), 0))])


def _mirrored(occ, solids, draw, _length):
    half = occ.intersect(solids, [(3, occ.addBox(-_FAR, -_FAR, 0, 2 * _FAR, 2 * _FAR, _FAR))])[0]
    image = occ.copy(half)
    occ.rotate(image, 0, 0, 0, 1, 0, 0, math.pi)  # occ.mirror makes splines of cylinders
    occ.translate(image, 0, 0, draw.choice((0, 0, -4e-3, 4e-3)))
    return [*half, *image]


def _twice(occ, solids, draw, length):
    pieces = draw.choice((_halves, _layers, _across, lambda _occ, same, *_: same))(occ, solids, draw, length)
    return [*pieces, *occ.copy(draw.sample(pieces, draw.randint(1, len(pieces))))]


def _overlapping(occ, solids, draw, _length):
    more, kept = draw.uniform(0.5, 3), []
    copy = occ.copy(solids)
    for body, low in ((solids, -more), (copy, more - _FAR)):
        kept += occ.intersect(body, [(3, occ.addBox(-_FAR, -_FAR, low, 2 * _FAR, 2 * _FAR, _FAR))])[0]
    return kept


def _unevenly(occ, solids, draw, length):
    below, *rest = _level(occ, solids, [draw.choice((0.0, draw.uniform(-4, 4)))])
    return [below, *_across(occ, rest, draw, length)]


WAYS = {
    way.__name__.strip("_"): way
    for way in (_through_bores, _layers, _halves, _cap, _across, _mirrored, _twice, _overlapping, _unevenly)
}


def written(path, rod, way=None, seed=0):
    """Write a rod divided in a way; return its number of solids and the volume of the whole rod, mm³."""
    with session():
        gmsh.model.add("drawn")
        occ = gmsh.model.occ
        solids = RODS[rod](occ)
        occ.synchronize()
        volume = sum(occ.getMass(*solid) for solid in solids)
        length = LENGTH if rod == "plain" else next(iter(PRESETS.values())).length
        if way is not None:
            solids = WAYS[way](occ, solids, random.Random(seed), length)  # noqa: S311 - nothing secret is drawn
        occ.synchronize()
        gmsh.write(str(path))
        return len(occ.getEntities(3)), volume


STUDY = """
[rod]
step = "{name}"
[material]
E_GPa = 207.0
nu = 0.3
density_kg_m3 = 7850.0
yield_MPa = 700.0
[forces]
pin_N = [20000.0, 0.0]
[mesh]
size_mm = 6.0
"""


def judged(path, volume):
    """Return ``right``, ``refused`` or ``WRONG`` for the mass of a file, and what is said."""
    try:
        with session():
            solid = import_cad(RodFile(path))
    except GeometryError as error:
        return "refused" if any(remedy in str(error) for remedy in _REMEDIES) else "NO REMEDY", str(error)
    change = solid.mass.mass / volume - 1
    said = "; ".join([*solid.imported.doubts, *solid.imported.assumed])
    if abs(change) < 1e-3:
        return "right", f"{len(solid.parts)} parts, {solid.mirror.value}"
    return "in doubt" if solid.imported.doubts else "WRONG", f"mass {100 * change:+.2f} %; {said}"


def _factor(path):
    study, out = path.with_suffix(".toml"), path.with_suffix(".out")
    study.write_text(STUDY.format(name=path.name))
    done = subprocess.run([sys.executable, "-m", "fea", "run", study, "--out", out, "--quiet"], check=False)
    if done.returncode not in (0, 1):
        return math.nan, 0.0
    summary = json.loads((out / "summary.json").read_text())
    case = next(iter(summary["results"].values()))
    return case["min_safety_factor"], case["error_percent"] or 0.0


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--solve", action="store_true")
    parser.add_argument("--rod", choices=RODS, default="plain")
    said = parser.parse_args()
    counts = Counter()
    with tempfile.TemporaryDirectory() as folder:
        whole = Path(folder, "whole.step")
        _, volume = written(whole, said.rod)
        right = _factor(whole) if said.solve else None
        for number in range(said.count):
            way = list(WAYS)[number % len(WAYS)]
            path = Path(folder, f"{number}.step")
            solids, _ = written(path, said.rod, way, said.seed * 1000 + number)
            verdict, text = judged(path, volume)
            if right is not None and verdict == "right":
                found, bar = _factor(path)
                text += f", factor {found:.3f} ± {bar:.1f} %, {right[0]:.3f} of the whole rod"
                verdict = verdict if abs(found / right[0] - 1) < (bar + right[1]) / 100 else "WRONG"
            counts[verdict] += 1
            print(f"{number:3} {way:14} {solids:2} solids: {verdict}: {text}", flush=True)
    print(dict(counts))
    bad = set(counts) - {"right", "refused"}
    return int(bool(bad) or counts["right"] < 0.75 * said.count)


if __name__ == "__main__":
    sys.exit(main())
