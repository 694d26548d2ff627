"""Random rods as default runs: each is answered, marked or refused by name; do its error bars hold?

    python tests/benchmarks/default_runs.py --rods 300 --references 24 --resume runs.json [--report FILE.md]

A rod, its engine and its speed are drawn by `tests/support/rod_studies.py`; nothing else is asked for: pins
are in contact and the mesh is refined as `fea run` does it. The peaks of the first rods, as many as
`--references` says, are compared with those of the same rod with `--tolerance 1`. A reference is known to its
own bar only; which peaks that decides is said once for this and for error_bars.py
(`tests/support/error_bar_table.py`).
"""

import json
import multiprocessing
import os
import statistics
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from scripts import command, publish, reporting

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from error_bar_table import decided
from rod_studies import random_study

FIRST, REFERENCE_TOLERANCE = 440_000, 1.0

Row = dict[str, Any]


def outcome(seed: int, *, compared: bool) -> Row | None:
    """What a default run of a rod says; None where a dimension rule refuses the rod before any run."""
    from fea.apps.result import Result, analyse
    from fea.solid.errors import ContactError
    from geometry.errors import GeometryError, InvalidValue
    from mesh.tetmesh import MeshError

    study = random_study(seed)
    if study is None:
        return None

    def peaks(result: Result) -> dict[str, tuple[float, float]]:
        return {name: (case.max_von_mises, case.error_percent) for name, case in result.cases.items()}

    start = sum(os.times()[:4])
    try:
        result = analyse(study)
        row: Row = {"outcome": "trusted" if result.trusted else "marked"}
        row["failed_checks"] = [name for name, check in result.checks.items() if not check.passed]
        row["pins"] = str(result.summary.model.pressure)
        row["survival"] = result.summary.survival.answer
        row["verdicts"] = {name: case.verdict for name, case in result.summary.results.items()}
        row["nodes"], row["peaks"] = len(result.mesh.points), peaks(result)
        row["seconds"] = sum(os.times()[:4]) - start
        if compared:
            row["references"] = peaks(analyse(study, tolerance=REFERENCE_TOLERANCE))
    except (InvalidValue, GeometryError, MeshError, ContactError) as error:
        return {"outcome": "refused", "by": f"{type(error).__name__}: {error}"}
    return row


def decided_peaks(kept: dict[str, Row]) -> list[tuple[str, str, float, float]]:
    """Seed, case, bar and true error, both in percent, of every peak whose reference is known well enough."""
    peaks = []
    for seed, row in kept.items():
        for name, (value, bar) in row["peaks"].items() if "references" in row else ():
            truth, uncertainty = row["references"].get(name, (0.0, float("inf")))
            if decided(uncertainty * truth, bar * value):
                peaks.append((seed, name, bar, 100 * abs(truth / value - 1)))
    return peaks


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
    lines = ["# Random rods as default runs", "", f"Made by `{command}`.", "", "| | |", "| --- | ---: |"]
    lines += [f"| {name} | {count} |" for name, count in counts.items()]
    if peaks := decided_peaks(kept):
        inside = sum(error <= bar for *_, bar, error in peaks)
        ratio = statistics.median(bar / max(error, 1e-9) for *_, bar, error in peaks)
        held = f"{inside} of {len(peaks)} decided peaks are within their bars "
        held += f"({100 * inside / len(peaks):.0f} %); the median bar is {ratio:.1f} times the error."
        lines += [
            "",
            held,
            "",
            *(f"- rod {s}, {n}: ± {b:.1f} %, off by {e:.1f} %" for s, n, b, e in peaks if e > b),
        ]
    told = [
        f"- rod {seed}: {row['outcome']}: {row.get('by') or ', '.join(row['failed_checks'])}"
        for seed, row in kept.items()
        if row["outcome"] != "trusted"
    ]
    return "\n".join([*lines, *(["", *told] if told else []), ""])


def main() -> None:
    """Run the rods that are not in the file of outcomes yet, and print the report."""
    parser = reporting(__doc__)
    parser.add_argument("--rods", type=int, default=300)
    parser.add_argument("--first", type=int, default=FIRST)
    parser.add_argument("--references", type=int, default=24)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--resume", type=Path, required=True, help="a JSON file to keep outcomes in")
    arguments = parser.parse_args()
    kept: dict[str, Row] = json.loads(arguments.resume.read_text()) if arguments.resume.exists() else {}
    last = arguments.first + 20 * arguments.rods
    seeds = [seed for seed in range(arguments.first, last) if random_study(seed) is not None]
    seeds = seeds[: arguments.rods]
    compared = set(seeds[: arguments.references])
    left = [seed for seed in seeds if str(seed) not in kept]
    while left:
        with ProcessPoolExecutor(arguments.workers, multiprocessing.get_context("spawn")) as pool:
            coming = {pool.submit(outcome, seed, compared=seed in compared): seed for seed in left}
            try:
                for done in as_completed(coming):
                    kept[str(coming[done])] = done.result()
                    arguments.resume.write_text(json.dumps(kept))
                    print(len(kept), coming[done], done.result(), file=sys.stderr, flush=True)
            except BrokenProcessPool:
                running = [seed for seed in left if str(seed) not in kept][: arguments.workers]
                kept |= {str(seed): {"outcome": "crashed", "by": "the process died"} for seed in running}
        left = [seed for seed in left if str(seed) not in kept]
    kept = {str(seed): kept[str(seed)] for seed in seeds}
    text = report_text(kept, command())
    publish(text, arguments.report)


if __name__ == "__main__":
    main()
