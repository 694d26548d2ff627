"""Random rods, or those of files, as default runs: is each answered or refused; do its error bars hold?

    python tests/benchmarks/default_runs.py --rods 300 --references 24 --resume runs.json [--report FILE.md]
    python tests/benchmarks/default_runs.py --cad FILE... [--engine NAME] --resume runs.json

A rod, its engine and its speed are drawn by `tests/support/rod_studies.py`; nothing else is asked for: pins
are in contact and the mesh is refined as `fea run` does it. The peaks of the first rods, as many as
`--references` says, are compared with those of the same rod with `--tolerance 1`. A reference is known to its
own bar only; which peaks that decides is said once for this and for error_bars.py
(error_bar_table.py).

A FILE is a study, or a CAD file that holds rod and cap, which is then run in an engine of the library. Its
reference is one further mesh, with elements smaller than those of the default run's last one everywhere and
far smaller where the stress is high: the finest of `REFERENCES` with at most `--elements`, as predicted.
"""

import dataclasses
import itertools
import multiprocessing
import os
import statistics
import sys
from collections import Counter
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from scripts import command, keep, kept_in, publish, reporting, table

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from error_bar_table import decided
from hot_spots import hot_ratio
from rod_studies import random_study

from fea.analysis.meshing import adaptive_mesh
from fea.analysis.pipeline import RefinedRod, prepare, refined_rod, solve_speed
from fea.analysis.refinement import predicted_elements, wanted_sizes
from fea.analysis.result import run_result
from fea.judge.case_result import CaseResult
from fea.machine.clock import Clock
from fea.solid.errors import ContactError
from fea.study.study import Study, load_study
from geometry.errors import GeometryError, InvalidValue
from mesh.sizing import Sizing
from mesh.tetmesh import MeshError

FIRST, REFERENCE_TOLERANCE = 440_000, 1.0
# The finest first: factors on the size where any case's stress exceeds a share of its peak.
REFERENCES = ({0.0: 0.8, 0.75: 1 / 2.2, 0.9: 1 / 4.5}, {0.0: 0.9, 0.8: 1 / 2.2}, {0.0: 0.95, 0.9: 1 / 1.8})

Row = dict[str, Any]
Peaks = dict[str, tuple[float, float]]
Decided = tuple[str, str, float, float]


def peaks_of(cases: Mapping[str, CaseResult]) -> Peaks:
    """Largest stress, MPa, and its error bar, percent, of load cases."""
    return {name: (case.max_von_mises, case.error_percent) for name, case in cases.items()}


def study_of(rod: str, engine: str) -> Study | None:
    """The random rod of a seed, if no rule refuses it, or the rod of a file."""
    if rod.isdigit():
        return random_study(int(rod))
    study = load_study(rod)
    return study.with_engine(engine) if study.engine is None else study


def tighter(study: Study) -> Peaks:
    """Peaks with a small tolerance."""
    options = dataclasses.replace(study.analysis, tolerance_percent=REFERENCE_TOLERANCE)
    strict = dataclasses.replace(study, analysis=options)
    return peaks_of(refined_rod(strict, strict.speeds(), Clock()).at(strict.speeds()[0]).cases)


def on_finer_mesh(adapted: RefinedRod, rpm: float | None, most: int) -> Peaks:
    """Peaks on the finest reference that is predicted to have at most so many elements."""
    study, mesh = adapted.rod.study, adapted.rod.mesh
    cases, growth = tuple(adapted.at(rpm).cases.values()), Sizing(mesh.meshing.size).growth
    fields = [sizes for hot in REFERENCES if (sizes := wanted_sizes(mesh, hot_ratio(cases, hot)))]
    few = [sizes for sizes in fields if predicted_elements(mesh, sizes, growth) <= most]
    finer = adaptive_mesh(study, Clock(), few[:1] or fields[-1:])
    return peaks_of(solve_speed(prepare(study, mesh=finer), rpm).cases)


def outcome(rod: str, *, compared: bool, engine: str, elements: int) -> Row | None:
    """Figures of a default run of a rod; None where a dimension rule refuses the rod before any run."""
    start = sum(os.times()[:4])
    try:
        study = study_of(rod, engine)
        if study is None:
            return None
        rpm = study.speeds()[0]
        adapted = refined_rod(study, (rpm,), Clock())
        result = run_result(study, adapted, adapted.at(rpm))
        row: Row = {"outcome": "trusted" if result.trusted else "marked"}
        row["failed_checks"] = [name for name, check in result.checks.items() if not check.passed]
        row["pins"] = str(result.summary.model.pressure)
        row["survival"] = result.summary.survival.answer
        row["verdicts"] = {name: case.verdict for name, case in result.summary.results.items()}
        row["nodes"], row["peaks"] = len(result.mesh.points), peaks_of(result.cases)
        row["at_mm"] = {name: case.at_mm for name, case in result.summary.results.items()}
        row["seconds"] = sum(os.times()[:4]) - start
        if compared:
            row["references"] = tighter(study) if rod.isdigit() else on_finer_mesh(adapted, rpm, elements)
    except (InvalidValue, GeometryError, MeshError, ContactError) as error:
        return {"outcome": "refused", "by": f"{type(error).__name__}: {error}"}
    return row


def decided_peaks(kept: dict[str, Row]) -> list[Decided]:
    """Seed, case, bar and true error, both in percent, of every peak whose reference is known well enough."""
    peaks = []
    for seed, row in kept.items():
        for name, (value, bar) in row["peaks"].items() if "references" in row else ():
            truth, uncertainty = row["references"].get(name, (0.0, float("inf")))
            if decided(uncertainty * truth, bar * value):
                peaks.append((seed, name, bar, 100 * abs(truth / value - 1)))
    return peaks


def by_rod(kept: dict[str, Row], peaks: list[Decided]) -> list[str]:
    """A table of the rods of files: held and decided peaks, and bar over error of each decided one."""
    rows = []
    for name in (name for name, row in kept.items() if "references" in row and not name.isdigit()):
        own = [(case, bar, error) for rod, case, bar, error in peaks if rod == name]
        held = f"{sum(error <= bar for *_, bar, error in own)} of {len(own)}"
        each = ", ".join(f"{case} {bar:.1f}/{error:.1f}" for case, bar, error in own)
        rows.append((Path(name).stem, held, str(len(kept[name]["peaks"])), each))
    heads = ("rod", "held of decided", "peaks:", "bar / error of the decided ones, %")
    return [*table(heads, rows), ""] if rows else []


def report_text(kept: dict[str, Row], command: str) -> str:
    """The report."""
    answered = [row for row in kept.values() if "peaks" in row]
    verdicts = Counter(verdict for row in answered for verdict in row["verdicts"].values())
    nodes, seconds = ([row[key] for row in answered] for key in ("nodes", "seconds"))
    counts = {
        **{f"rods: {name}": n for name, n in Counter(row["outcome"] for row in kept.values()).items()},
        **{f"pins: {name}": n for name, n in Counter(row["pins"] for row in answered).items()},
        **{f"answer: {name}": n for name, n in Counter(row["survival"] for row in answered).items()},
        **{f"peaks: {name}": n for name, n in verdicts.items()},
        "nodes, median and most": f"{statistics.median(nodes):.0f}, {max(nodes)}",
        "processor seconds, median and most": f"{statistics.median(seconds):.0f}, {max(seconds):.0f}",
    }
    lines = ["# Rods as default runs", "", f"Made by `{command}`.", "", "| | |", "| --- | ---: |"]
    lines += [f"| {name} | {count} |" for name, count in counts.items()]
    if peaks := decided_peaks(kept):
        inside = sum(error <= bar for *_, bar, error in peaks)
        ratio = statistics.median(bar / max(error, 1e-9) for *_, bar, error in peaks)
        held = f"{inside} of {len(peaks)} decided peaks are within their bars "
        held += f"({100 * inside / len(peaks):.0f} %); the median bar is {ratio:.1f} times the error."
        lines += ["", held, "", *by_rod(kept, peaks)]
        lines += [f"- rod {s}, {n}: ± {b:.1f} %, off by {e:.1f} %" for s, n, b, e in peaks if e > b]
    told = [
        f"- rod {seed}: {row['outcome']}: {row.get('by') or ', '.join(row['failed_checks'])}"
        for seed, row in kept.items()
        if row["outcome"] != "trusted"
    ]
    return "\n".join([*lines, *(["", *told] if told else []), ""])


def random_rods(first: int, count: int) -> list[str]:
    """So many seeds from the first, of rods that no rule refuses."""
    drawn = (str(seed) for seed in itertools.count(first) if random_study(seed) is not None)
    return list(itertools.islice(drawn, count))


def main() -> None:
    """Run the rods that are not in the file of outcomes yet, and print the report."""
    parser = reporting(__doc__)
    parser.add_argument("--rods", type=int, default=300)
    parser.add_argument("--first", type=int, default=FIRST)
    parser.add_argument("--references", type=int, default=24)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--resume", type=Path, required=True, help="a JSON file to keep outcomes in")
    parser.add_argument("--cad", nargs="+", help="files of rods, or studies, in place of random rods")
    parser.add_argument("--engine", default="sd195", help="of CAD files; a study has its own")
    parser.add_argument("--elements", type=float, default=400_000, help="most of a reference of a file")
    arguments = parser.parse_args()
    kept: dict[str, Row] = kept_in(arguments.resume)
    rods = arguments.cad or random_rods(arguments.first, arguments.rods)
    asked = {"engine": arguments.engine, "elements": arguments.elements}
    compared = set(arguments.cad or rods[: arguments.references])
    while left := [rod for rod in rods if rod not in kept]:
        with ProcessPoolExecutor(
            arguments.workers, multiprocessing.get_context("spawn"), max_tasks_per_child=1
        ) as pool:
            coming = {pool.submit(outcome, rod, compared=rod in compared, **asked): rod for rod in left}
            try:
                for done in as_completed(coming):
                    kept[coming[done]] = done.result()
                    keep(arguments.resume, kept)
                    print(len(kept), coming[done], done.result(), file=sys.stderr, flush=True)
            except BrokenProcessPool:
                running = [rod for rod in left if rod not in kept][: arguments.workers]
                kept |= {rod: {"outcome": "crashed", "by": "the process died"} for rod in running}
    kept = {rod: kept[rod] for rod in rods}
    text = report_text(kept, command())
    publish(text, arguments.report)


if __name__ == "__main__":
    main()
