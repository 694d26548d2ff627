"""Rods whose length, bores and mass are known, against rods of the same kind, length and bores.

    python tests/benchmarks/known_rods.py [--answers] [--limits] [--report FILE.md]

The computed mass is that of the solid with a bronze bushing and both bolts: a shank as long as the boss and a
head of 1.5 d and 0.9 d high each. `--answers` runs `fea run` on each rod whose engine is known, and on the
H-beam of an engine's bores; `--limits` takes the answer of `fea limits --size 10`,
without its map.
"""

import argparse
import contextlib
import io
import math
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from fea.analysis.engine_study import engine_study
from fea.analysis.pipeline import refined_rod
from fea.apps.limits.explore import explore
from fea.apps.limits.figures import words
from fea.apps.result import analyse
from fea.machine.clock import Clock
from fea.study.rod_table import rod_of_kind
from fea.study.study import load_study
from geometry.section import HeightField

INCH = 25.4
STEEL, BRONZE = 7.85e-6, 8.8e-6  # kg/mm³
SIZE = 10.0  # of elements, mm, for the limits
SOURCES = {
    "list": "post of 2010 at forum.grumpysperformance.com, topic 3540, which quotes Eagle's list of rods for "
    "the small block: length, crank pin (2.100 or 2.000 in), piston pin, mass. Housings of 2.225 and 2.125 "
    "in are usual for them",
    "weighed": "the same topic: make unknown, 715 g with bolts of 1.75 in and 645 g without; bores as above",
    "mopar": "Mopar Performance, Jeep Engines; the piston pin's bore is not checked",
    "subaru": "mass of engine-sim, bores of Tomei's instructions",
    "engine-sim": "engine-sim; the bores are not checked, and the Hayabusa's mass is hardly a weighed one",
    "columba": "Columba 2022; the bores are assumed",
}


class Known(NamedTuple):
    """A rod as it is sold or was measured; lengths in mm, mass in g."""

    name: str
    kind: str
    length: float
    big: float
    small: float
    mass: float
    source: str
    engine: str = ""
    thread: str | None = None


SMALL_BLOCK = (2.225 * INCH, 0.927 * INCH)
OLDER = (2.125 * INCH, 0.927 * INCH)
RODS = (
    Known("H-beam, 7/16 bolts", "h-beam", 6.0 * INCH, *SMALL_BLOCK, 715, "weighed", thread="7/16-20 UNF"),
    Known("Eagle SIR5700BBLW", "i-beam", 5.7 * INCH, *SMALL_BLOCK, 560, "list"),
    Known("Eagle SIR5700BPLW", "i-beam", 5.7 * INCH, *SMALL_BLOCK, 565, "list"),
    Known("Eagle SIR5700SPLW", "i-beam", 5.7 * INCH, *OLDER, 590, "list"),
    Known("Eagle SIR5700SBLW", "i-beam", 5.7 * INCH, *OLDER, 590, "list"),
    Known("Eagle SIR5850BBLW", "i-beam", 5.85 * INCH, *SMALL_BLOCK, 590, "list"),
    Known("Eagle SIR6000BPLW", "i-beam", 6.0 * INCH, *SMALL_BLOCK, 595, "list"),
    Known("Jeep 4.0", "i-beam", 155.57, 56.09, 23.6, 661, "mopar", "jeep-4.0"),
    Known("Subaru EJ25", "i-beam", 130.5, 55.0, 23.0, 535, "subaru", "subaru-ej25"),
    Known("Chevrolet 454", "i-beam", 155.83, 59.06, 25.15, 785, "engine-sim", "chevrolet-454"),
    Known("Suzuki G10", "i-beam", 120.0, 45.0, 18.0, 384, "columba", "suzuki-g10"),
    Known("Suzuki Hayabusa", "i-beam", 119.5, 41.0, 20.01, 396, "engine-sim", "suzuki-hayabusa"),
)


def mass(made):
    """Mass of a rod of a kind with its bushing and bolts, g."""
    field, d = HeightField(made.rod), made.thread.diameter
    bolt = math.pi / 4 * (d**2 * made.rod.cap_boss_length + (1.5 * d) ** 2 * 0.9 * d)
    bushing = field.bushing().mass
    return 1e3 * (STEEL * (field.mass().mass + 2 * bolt) + (BRONZE - STEEL) * bushing)


def table():
    lines, within = [], 0
    for one in RODS:
        made = rod_of_kind(one.kind, one.length, one.big, one.small, one.thread)
        found = mass(made)
        off = 100 * (found / one.mass - 1)
        within += abs(off) <= 10
        bores = f"{one.length:.2f} | {one.big:.2f} | {one.small:.2f}"
        lines.append(
            f"| {one.name} | {one.kind} | {bores} | {made.thread.name} | {one.mass:.0f} | {found:.0f} | "
            f"{off:+.1f} | {one.source} |"
        )
    return lines, within


def studies():
    """Yield each engine whose rod is known, with a rod of either kind, and its study."""
    with tempfile.TemporaryDirectory() as folder:
        for engine in sorted({one.engine for one in RODS if one.engine}):
            for kind in ("i-beam", "h-beam"):
                path = Path(folder) / f"{engine}-{kind}.toml"
                path.write_text(engine_study(engine, kind))
                yield engine, kind, load_study(str(path))


def answers():
    """Default runs of the rods of engines, and of H-beams in their place."""
    yield "| engine | rod | rpm | mass g | smallest factor | answer |"
    yield "| --- | --- | ---: | ---: | ---: | --- |"
    for engine, kind, study in studies():
        with contextlib.redirect_stderr(io.StringIO()):
            summary = analyse(study).summary
        said = summary.survival.text
        least = min(case.min_safety_factor for case in summary.results.values())
        grams = 1e3 * summary.rod.mass_kg
        row = f"| {engine} | {kind} | {summary.rpm:.0f} | {grams:.0f} | {least:.2f} | {said} |"
        print(row, file=sys.stderr, flush=True)
        yield row


def answer(study):
    """Output of `fea limits`, without its map."""
    analysis = replace(study.analysis, cycle=True, tolerance_percent=0.0)
    study = replace(study, analysis=analysis, mesh=replace(study.mesh, size_mm=SIZE))
    rpm = max(study.speeds())
    with contextlib.redirect_stderr(io.StringIO()):
        return rpm, words(explore(refined_rod(study, [rpm], Clock()), rpm, mapped=False))


def limits():
    """Limits of the same rods, in words."""
    yield "| engine | rod | redline rpm | answer |"
    yield "| --- | --- | ---: | --- |"
    for engine, kind, study in studies():
        rpm, said = answer(study)
        row = f"| {engine} | {kind} | {rpm:.0f} | {said} |"
        print(row, file=sys.stderr, flush=True)
        yield row


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--answers", action="store_true")
    parser.add_argument("--limits", action="store_true")
    parser.add_argument("--report", type=Path)
    arguments = parser.parse_args()
    lines, within = table()
    command = " ".join(["python tests/benchmarks/known_rods.py", *sys.argv[1:]])
    text = [
        "# Rods whose mass is known",
        "",
        f"Made by `{command}`: rods in the proportions of their kind",
        "(`fea init --kind`), from length and bores alone, with bushing and bolts.",
        f"{within} of {len(RODS)} are within 10 %. The proportions were chosen with these masses in view,",
        "so that this is no independent check. More rods whose makers publish length, both bores and mass",
        "could not be had.",
        "",
        "| rod | kind | length | big end | small end, mm | bolts | mass g | computed g | off % | source |",
        "| --- | --- | " + "---: | " * 3 + "--- | " + "---: | " * 3 + "--- |",
        *lines,
        "",
        *(f"- {name}: {said}." for name, said in SOURCES.items()),
        "",
    ]
    if arguments.answers:
        text += ["## First answers", "", *answers(), ""]
    if arguments.limits:
        text += ["## How much they can take", "", *limits(), ""]
    print("\n".join(text))
    if arguments.report:
        arguments.report.write_text("\n".join(text), encoding="utf-8")


if __name__ == "__main__":
    main()
