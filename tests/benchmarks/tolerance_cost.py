"""Cost of `--tolerance` over a single solve on the mesh it ends with, and whether it is kept.

    python tests/benchmarks/tolerance_cost.py --report results/tolerance.md

For shipped studies at several speeds and for rods drawn at random, all in one process. Every load case
counts. The true peaks are those of meshes that are far finer where it is hot; they are kept beside this file,
and `--references` solves for them anew, which a change of rods or loads asks for.
"""

import dataclasses
import json
import statistics
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from scripts import reporting

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from hot_spots import hot_ratio, solved_finely
from rod_studies import random_study

from fea.analysis.pipeline import RefinedRod, prepare, refined_rod, solve_speed
from fea.analysis.refinement import wanted_sizes
from fea.machine.clock import Clock
from fea.study.option_tables import MeshTable
from fea.study.speed_tables import SpeedTable
from fea.study.study import Study, load_study

SPEEDS = {"leon-2001": (800, 3000, 6000), "columba-2022": (800, 5100), "molina-2024": (780, 2000)}
SEEDS = (7, 10, 13, 16, 18, 20)
GOAL = 2.5
KEPT = Path(__file__).with_name("tolerance_peaks.json")
# The true peaks: elements of this over the default size, and where the stress of any case exceeds a share of
# its peak, smaller by the factor beside it.
BASE, HOT = 0.9, {0.75: 1 / 2.2, 0.9: 1 / 4.5}

# By case, its peak von Mises stress, MPa, and the bar on that, percent.
Peaks = dict[str, list[float]]


@dataclass(frozen=True)
class Row:
    """A study brought within a tolerance; percentages are the largest of all cases."""

    study: str
    rpm: float
    tolerance: float
    passes: int
    nodes: int
    bar: float
    error: float
    reference_bar: float
    seconds: float
    ratio: float

    def text(self) -> str:
        """Return it as a line of the table."""
        cells = (
            f"{self.study} | {self.rpm:.0f} | {self.tolerance:g} | {self.passes} | {self.nodes}",
            f"{self.bar:.1f} | {self.error:.2f} | ±{self.reference_bar:.1f} | {self.seconds:.1f}",
            f"{self.ratio:.2f}",
        )
        return f"| {' | '.join(cells)} |"


def drawn_studies() -> Iterator[Study]:
    """Each with one speed."""
    for name, speeds in SPEEDS.items():
        for rpm in speeds:
            yield dataclasses.replace(load_study(name), speed=SpeedTable(rpm=float(rpm)))
    yield from filter(None, map(random_study, SEEDS))


def true_peaks(study: Study) -> Peaks:
    """Solve with small elements where any case is hot."""
    (rpm,) = study.speed.speeds()
    coarse = prepare(study)
    cases = solve_speed(coarse, rpm).cases.values()
    sizes = wanted_sizes(coarse.mesh, hot_ratio(cases, HOT))
    fine = solved_finely(study, BASE * coarse.mesh.meshing.size, sizes, rpm)
    return {case.load.name: [case.peak.value, case.peak.error_percent] for case in fine}


def brought_within(study: Study, tolerance: float) -> tuple[RefinedRod, float]:
    """Run to the tolerance; return the seconds as well."""
    options = dataclasses.replace(study.analysis, tolerance_percent=tolerance)
    start = time.perf_counter()
    found = refined_rod(dataclasses.replace(study, analysis=options), study.speed.speeds(), Clock())
    return found, time.perf_counter() - start


def row(study: Study, tolerance: float, truth: Peaks, runs: int) -> Row:
    """Median cost of some runs, and the result."""
    timings = []
    for _ in range(runs):
        found, seconds = brought_within(study, tolerance)
        timings.append((seconds / found.passes[-1].seconds, seconds))
    (rpm,) = study.speed.speeds()
    cases, last = found.at(rpm).cases.values(), found.passes[-1]
    return Row(
        study.name,
        rpm,
        tolerance,
        len(found.passes),
        last.nodes,
        max(case.error_percent for case in cases),
        max(100 * abs(case.peak.value / truth[case.load.name][0] - 1) for case in cases),
        max(bar for _, bar in truth.values()),
        statistics.median(seconds for _, seconds in timings),
        statistics.median(ratio for ratio, _ in timings),
    )


def report_text(rows: list[Row], runs: int, command: str) -> str:
    """Return the report."""
    met, true = sum(r.bar <= r.tolerance for r in rows), sum(r.error <= r.tolerance for r in rows)
    cheap, middle = sum(r.ratio <= GOAL for r in rows), statistics.median(r.ratio for r in rows)
    head = f"""# What a tolerance costs, and whether it is kept

Made by `{command}`; times are medians of {runs} runs.

The last pass is a single solve on the final mesh: *ratio* is the total time over its. The *bar* is what
`fea run --tolerance` prints, *error* how far peaks are from those of a mesh that is far finer where it is hot
and has the bar beside it; of all load cases the largest counts.

Of {len(rows)} runs, {met} came within the tolerance by their bars and {true} by their true errors. {cheap}
took at most {GOAL} times the time of the last pass; the median is {middle:.2f}.

| study | rpm | tolerance % | passes | nodes | bar % | error % | reference | s | ratio |
| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |
"""
    return head + "\n".join(r.text() for r in rows) + "\n"


def main() -> None:
    """Warm up on a coarse mesh, then tell each job."""
    parser = reporting(__doc__)
    parser.add_argument("--tolerance", type=float, nargs="+", default=[2.0, 5.0])
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--references", action="store_true", help="solve for the true peaks anew")
    arguments = parser.parse_args()
    kept: dict[str, Peaks] = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    solve_speed(prepare(dataclasses.replace(load_study(), mesh=MeshTable(size_mm=14.0))), 6000.0)
    rows = []
    for study in drawn_studies():
        key = f"{study.name} {study.speed.rpm:.0f}"
        if arguments.references or key not in kept:
            kept[key] = true_peaks(study)
            KEPT.write_text(json.dumps(kept, indent=1) + "\n")
        for tolerance in arguments.tolerance:
            rows.append(row(study, tolerance, kept[key], arguments.runs))
            print(rows[-1].text(), flush=True)
    if arguments.report:
        command = f"python tests/benchmarks/tolerance_cost.py --report {arguments.report}"
        arguments.report.write_text(report_text(rows, arguments.runs, command))


if __name__ == "__main__":
    main()
