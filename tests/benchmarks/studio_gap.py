"""What `fea studio` shows while one drags against what is solved there, and what its answers cost.

    python tests/benchmarks/studio_gap.py gap [--rods 50] [--size 14] [--only STUDY ...] [--seed 40]
    python tests/benchmarks/studio_gap.py contact [--rods 50] [--size 14] [--only STUDY ...] [--seed 40]
    python tests/benchmarks/studio_gap.py cost [STUDY]

`gap`: up to seven dimensions of each study are touched, as on the page; then rods between
the sampled designs, in up to seven dimensions at once within ±10 %, are interpolated and solved on the same
moved mesh. The error is that of the smallest safety factor against yielding. The constants of the estimate
were fitted under a prescribed pressure: that of a line on the rods of seed 39 of all studies but the last,
that of two dimensions together on those of seed 40 of the first two. `contact`: the same rods with their
pins in contact, of which what is shown is corrected; the error is that of the smallest factors against
yielding and fatigue. `cost`: times, and the processor's in parentheses,
of the first picture, of an update while one drags, of the exact answer at rest; and the memory of the
process.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections import deque
from copy import copy
from dataclasses import replace
from functools import partial
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the program does

import numpy as np

from fea.analysis.engine_study import engine_study
from fea.apps.studio.live_rod import LiveRod
from fea.apps.studio.operating_point import fault
from fea.study.study import load_study, parse_study

STUDIES = ("leon-2001", "molina-2024", "columba-2022", "toyota-2jz")
TOUCHED = (
    "web_thickness_mm",
    "flange_thickness_mm",
    "shank_width_mm",
    "shank_depth_small_end_mm",
    "small_end_ring_mm",
    "big_end_ring_mm",
    "small_end_fillet_mm",
    "shank_depth_big_end_mm",
    "big_end_fillet_mm",
)
DIMENSIONS, WITHIN = 7, 0.10


def study(name, size=None, pressure="cosine-180"):
    """A shipped study, or that of an engine of the library; on a mesh of one size where one is given."""
    try:
        found = load_study(name)
    except ValueError:
        found = parse_study(engine_study(name), name, Path.cwd())
    found = replace(found, analysis=replace(found.analysis, pressure=pressure))
    return found if size is None else replace(found, mesh=replace(found.mesh, size_mm=size))


def held_out(name, count, size, seed):
    """Errors, percent, of rods between sampled designs; rows of (error, its estimate, bar, dimensions)."""
    rod, random = LiveRod(study(name, size)), np.random.default_rng(seed)
    operation, own = rod.operation, rod.base_design
    touched = [key for key in TOUCHED if key in own][:DIMENSIONS]
    for key in touched:
        for _ in rod.touch(key, {}, operation):
            pass
    ranges = rod.ranges({})
    touched = [key for key in touched if ranges[key].covered_low is not None]
    rows, grey, moved_not, alike = [], 0, 0, []
    samples = list(rod._samples.designs)
    while len(rows) < count:
        design = {}
        for key in random.choice(touched, random.integers(1, len(touched) + 1), replace=False):
            low = max(ranges[key].covered_low, (1 - WITHIN) * own[key])
            high = min(ranges[key].covered_high, (1 + WITHIN) * own[key])
            design[key] = float(random.uniform(low, high))
        if fault(rod.study, design):
            continue
        if rod._moved(rod.study_at(design, operation)) is None:
            moved_not += 1
            continue
        shown = rod.frame(design, operation).figures
        if shown is None:
            grey += 1
            continue
        solved = next(rod.exact(design, operation)).figures
        one, other = shown.yielding, solved.yielding
        error = 100 * abs(one.factor / other.factor - 1)
        rows.append((error, one.interpolation_percent, one.bar_percent, len(design)))
        alike.append((shown.governing == solved.governing, one.where == other.where))
        assert [each.name for each in shown.cases] == [each.name for each in solved.cases]
        assert rod._samples.designs == samples  # held out: what was solved is none of them
    error, gap, bar, _ = table = np.array(rows).T
    same_case, same_place = 100 * np.mean(np.array(alike), axis=0)
    print(
        f"{name}: {len(rod._mesh.cell.points)} nodes of the cell, {len(samples)} sampled designs "
        f"of {len(touched)} dimensions; {len(rows)} rods: error median {np.median(error):.3f} %, 99 % "
        f"{np.quantile(error, 0.99):.2f} %, largest {error.max():.2f} %; gap median {np.median(gap):.2f} %, "
        f"holds {100 * np.mean(error <= gap):.1f} %; shown bar median {np.median(bar):.1f} %, holds "
        f"{100 * np.mean(error <= bar):.1f} %; same case {same_case:.0f} %, same place {same_place:.0f} %; "
        f"grey {grey}, mesh cannot follow {moved_not}",
        flush=True,
    )
    return table


def gap(names, count, size, seed):
    """Print the errors of each study and of all."""
    tables = [held_out(name, count, size, seed) for name in names]
    error, shown, bar, _ = np.hstack(tables)
    print(
        f"all {len(error)}: error median {np.median(error):.3f} %, largest {error.max():.2f} %; gap median "
        f"{np.median(shown):.2f} %, holds {100 * np.mean(error <= shown):.1f} %; shown bar holds "
        f"{100 * np.mean(error <= bar):.1f} %"
    )


def contact(names, count, size, seed):
    """Print how far corrected factors are from those with the pins in contact, and whether gaps hold."""
    every = []
    for name in names:
        rod, random = LiveRod(study(name, size, "contact")), np.random.default_rng(seed)
        operation, own, rows = rod.operation, rod.base_design, []
        deque(rod.exact({}, operation), maxlen=0)
        for key in (touched := [key for key in TOUCHED if key in own][:DIMENSIONS]):
            deque(rod.touch(key, {}, operation), maxlen=0)
        samples, correction = copy(rod._samples), rod._correction
        while len(rows) < count:
            some = random.choice(touched, random.integers(1, len(touched) + 1), replace=False)
            design = {key: own[key] * random.uniform(1 - WITHIN, 1 + WITHIN) for key in some}
            if fault(rod.study, design) or (shown := rod.frame(design, operation).figures) is None:
                continue
            if rod._moved(rod.study_at(design, operation)) is None:
                continue
            *_, solved = rod.exact(design, operation)
            rod._samples, rod._correction = (
                copy(samples),
                correction,
            )  # held out, and that of the first design
            rod._samples._recent = {}
            for mode in ("yielding", "fatigue"):
                one, other = getattr(shown, mode), getattr(solved.figures, mode)
                if one is not None and other is not None:
                    error = 100 * abs(one.factor / other.factor - 1)
                    rows.append((error, one.interpolation_percent, error <= one.interpolation_percent))
        error, gaps, held = np.array(rows).T
        print(
            f"{name}: {len(rows)} factors, error median {np.median(error):.2f} %, largest "
            f"{error.max():.1f} %; gap median {np.median(gaps):.1f} %, holds {100 * held.mean():.0f} %",
            flush=True,
        )
        every += rows
    error, gaps, held = np.array(every).T
    print(
        f"all {len(every)}: error median {np.median(error):.2f} %, largest {error.max():.1f} %; gap median "
        f"{np.median(gaps):.1f} %, holds {100 * held.mean():.1f} %"
    )


def processor():
    """Processor time of this process and of those that it has waited for, s."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def timed(what, job, repeat=1):
    """Print the median wall and processor time of a job, ms, and return its last result."""
    wall, busy = [], []
    for _ in range(repeat):
        start, own = time.perf_counter(), processor()
        found = job()
        wall.append(time.perf_counter() - start)
        busy.append(processor() - own)
    print(f"{what}: {1e3 * np.median(wall):.1f} ms ({1e3 * np.median(busy):.1f})", flush=True)
    return found


FIRST = """
from fea.apps.studio.live_rod import LiveRod
rod = LiveRod(load_study({!r}))
rod.frame({{}}, rod.operation)
"""


def cost(name):
    """Print the cost of the answers of one study."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "fea", "run", name, "--tolerance", "5", "--out", f"{folder}/out"]
        timed("fea run --tolerance 5, a process", lambda: subprocess.run(command, check=True, stdout=-3))
    command = [sys.executable, "-c", FIRST.format(name)]
    timed("first picture, a process", lambda: subprocess.run(command, check=True))
    rod = LiveRod(study(name))
    operation, random = rod.operation, np.random.default_rng(1)
    print(f"{len(rod._mesh.cell.points)} nodes of the cell, {len(rod.surface.nodes)} of the surface")
    timed("ranges of all dimensions", lambda: rod.ranges({}), 3)
    touched = [key for key in TOUCHED if key in rod.base_design][:DIMENSIONS]
    for key in touched:
        timed(f"touch {key}", partial(deque, rod.touch(key, {}, operation), maxlen=0))

    def somewhere():
        return {key: float(rod.base_design[key] * random.uniform(0.96, 1.04)) for key in touched}

    print(f"{len(rod._samples.designs)} sampled designs")
    timed("the first update", lambda: rod.frame(somewhere(), operation))
    timed("an update while dragging", lambda: rod.frame(somewhere(), operation), 50)
    rpm = iter(np.linspace(0.9, 1.1, 20) * operation.rpm)
    timed("an update of the speed", lambda: rod.frame({}, operation.changed({"rpm": next(rpm)})), 20)
    for number in range(4):
        steps = rod.exact({touched[0]: rod.base_design[touched[0]] * (1 + 0.01 * number)}, operation)
        timed("exact at rest", partial(next, steps))
        timed("then the cycle", partial(next, steps))
    print(f"memory at most {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MiB")


def main():
    """Read the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("gap", "contact", "cost"))
    parser.add_argument("study", nargs="?", default="leon-2001")
    parser.add_argument("--rods", type=int, default=50)
    parser.add_argument("--size", type=float)
    parser.add_argument("--seed", type=int, default=40)
    parser.add_argument("--only", nargs="+", default=STUDIES)
    asked = parser.parse_args()
    if asked.what != "cost":
        (gap if asked.what == "gap" else contact)(asked.only, asked.rods, asked.size, asked.seed)
    else:
        cost(asked.study)


if __name__ == "__main__":
    main()
