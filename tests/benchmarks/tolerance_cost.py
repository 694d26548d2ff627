"""What `--tolerance` costs over a single solve on the mesh it ends with.

    python tests/benchmarks/tolerance_cost.py [--tolerance 2 5]

For shipped studies at several speeds, all in one process: the passes, the total time over that of the last
pass (at most 2.5 is the goal), and whether every peak came within the tolerance. Every load case counts.
"""

import argparse
import dataclasses
import time

from fea.adaptive.adapt import analysed
from fea.machine.clock import Clock
from fea.pipeline import Analysis
from fea.study.study import MeshTable, load_study

JOBS = (
    ("leon-2001", 800.0),
    ("leon-2001", 3000.0),
    ("leon-2001", 6000.0),
    ("columba-2022", 800.0),
    ("columba-2022", 5100.0),
    ("molina-2024", 780.0),
    ("molina-2024", 2000.0),
)
GOAL = 2.5


def cost(name: str, rpm: float, tolerance: float) -> str:
    """Run to the tolerance and describe what it took."""
    study = load_study(name)
    options = dataclasses.replace(study.analysis, tolerance_percent=tolerance)
    start = time.perf_counter()
    found = analysed(dataclasses.replace(study, analysis=options), (rpm,), Clock())
    result = found.at(rpm)
    total, last = time.perf_counter() - start, found.passes[-1]
    ratio = total / last.seconds
    passes = ", ".join(f"{p.elements} (±{p.error_percent:.1f} %, {p.seconds:.1f} s)" for p in found.passes)
    met = max(case.error_percent for case in result.cases) <= tolerance
    verdict = "met" if met else "NOT MET"
    goal = "" if ratio <= GOAL else "  above the goal"
    return f"{name} {rpm:g} rpm, {tolerance:g} %: {verdict}, {total:.1f} s, ratio {ratio:.2f}{goal}: {passes}"


def main() -> None:
    """Warm up on a coarse mesh, then tell each job."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tolerance", type=float, nargs="+", default=[2.0, 5.0])
    coarse = dataclasses.replace(load_study(), mesh=MeshTable(size_mm=14.0))
    Analysis(coarse, Clock()).at(6000.0)
    for tolerance in parser.parse_args().tolerance:
        for name, rpm in JOBS:
            print(cost(name, rpm, tolerance), flush=True)


if __name__ == "__main__":
    main()
