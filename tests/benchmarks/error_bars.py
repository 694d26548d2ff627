"""Does the printed bar hold the true error of a peak? On known answers, and on rods drawn at random.

    python tests/benchmarks/error_bars.py [--hold-out 110000:14] [--report results/error-bars.md]

Every case is a peak von Mises stress with the bar that `fea run` gives it. Known answers: Lamé, Kirsch,
Goodier, NAFEMS LE1 and LE10, Howland's plate, the rotating disc. Rods of the hold-out sets: random ones under
random loads, of seeds that the constants of the estimate were not chosen with. Rods of the calibration set,
with `--calibration`: the shipped studies at random speeds and such random rods. Each as `fea run` leaves it
without flags, at the default size, at one and a half times that, refined to a tolerance, and with first-order
elements, against two references of its own.
"""

import dataclasses
import multiprocessing
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from scripts import command, reporting

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from error_bar_table import FACTORS, report_text
from hot_spots import hot_ratio, solved_finely
from known_peaks import SIZES, KnownPeak, benchmark_peaks, exact_peaks
from rod_studies import random_study, randomly_loaded

from fea.analysis.pipeline import prepare, refined_rod, solve_speed
from fea.analysis.refinement import predicted_elements, wanted_sizes
from fea.base.choices import Element
from fea.judge.case_result import CaseResult
from fea.judge.verdict import peak
from fea.machine.clock import Clock
from fea.solid.error_estimate import STRESS_FACTOR
from fea.study.option_tables import MeshTable
from fea.study.speed_tables import SpeedTable
from fea.study.study import Study, load_study
from mesh.sizing import Sizing

SHIPPED, DRAWS = ("leon-2001", "columba-2022", "molina-2024"), 2
CALIBRATION = "calibration"
CALIBRATION_SETS = ((20000, 14), (30000, 14), (50000, 14), (60000, 14), (90000, 14))
TOLERANCE = 2.0
# The references: elements of this over the default size, and where the stress of any case exceeds a share of
# its peak, smaller by the factor beside it. The two finest count that have no more elements than this; their
# difference is what the finer one may be off.
BASE = 0.9
REFERENCES = (
    {0.75: 1 / 2.2},
    {0.75: 1 / 2.2, 0.9: 1 / 4.5},
    {0.75: 1 / 2.5, 0.87: 1 / 5, 0.95: 1 / 9},
)
MOST_ELEMENTS = 350_000

Job = tuple[str, str, Study | None]
Rows = list[dict]


def row(group: str, known: KnownPeak) -> dict:
    """Printed figures of a case, with the bars that other factors on the estimate would give."""
    unit = known.error / STRESS_FACTOR[known.order]
    bars = [peak(known.value, f * unit, known.masked).error_percent for f in FACTORS[known.order]]
    found = peak(known.value, known.error, known.masked)
    return {
        "group": group,
        "case": known.case,
        "order": known.order,
        "value": found.value,
        "truth": known.truth,
        "bars_percent": bars,
        "error_percent": 100 * abs(known.truth / found.value - 1),
        "uncertainty_percent": 100 * known.uncertainty / found.value,
    }


def rod_rows(name: str, study: Study) -> Rows:
    """Rows of a rod."""
    rpm = study.speed.speeds()[0] if study.engine is not None else None
    rod = prepare(study)
    default, size = tuple(solve_speed(rod, rpm).cases.values()), rod.mesh.meshing.size
    wanted = [wanted_sizes(rod.mesh, hot_ratio(default, hot)) for hot in REFERENCES]
    growth = Sizing(size).growth
    few = [sizes for sizes in wanted if predicted_elements(rod.mesh, sizes, growth) < MOST_ELEMENTS]
    del rod
    middle, fine = (
        {case.load.name: case.peak.value for case in solved_finely(study, BASE * size, sizes, rpm)}
        for sizes in (few if len(few) > 1 else wanted)[-2:]
    )

    def rows(group: str, cases: Iterable[CaseResult], order: int = 2) -> Rows:
        return [
            row(
                group,
                KnownPeak(
                    f"{name}, {c.load.name}",
                    order,
                    *c.judged[0],
                    c.error.masked,
                    fine[c.load.name],
                    abs(fine[c.load.name] - middle[c.load.name]),
                ),
            )
            for c in cases
        ]

    def at(mesh: MeshTable) -> Iterable[CaseResult]:
        return solve_speed(prepare(dataclasses.replace(study, mesh=mesh)), rpm).cases.values()

    def refined(tolerance: float | None) -> Iterable[CaseResult]:
        options = dataclasses.replace(study.analysis, tolerance_percent=tolerance)
        asked = dataclasses.replace(study, analysis=options)
        return refined_rod(asked, (rpm,), Clock()).at(rpm).cases.values()

    return [
        *rows("without flags", refined(None)),
        *rows("--tolerance 0", default),
        *rows("1.5 times its size", at(MeshTable(size_mm=1.5 * size))),
        *rows(f"--tolerance {TOLERANCE:g}", refined(TOLERANCE)),
        *rows("first order", at(MeshTable(element=Element.P1)), 1),
    ]


def calibration() -> Iterator[Job]:
    """Shipped studies at random speeds, and random rods under random loads."""
    for name in SHIPPED:
        study = load_study(name)
        for draw in range(DRAWS):
            share = np.random.default_rng([len(name), draw]).uniform(0.3, 1.1)
            rpm = round(share * max(study.speed.speeds()))
            yield CALIBRATION, f"{name} {rpm} rpm", dataclasses.replace(study, speed=SpeedTable(float(rpm)))
    for first, rods in CALIBRATION_SETS:
        yield from random_rods(CALIBRATION, first, rods)


def random_rods(kind: str, first: int, rods: int) -> Iterator[Job]:
    """Random rods under random loads, of seeds from the first."""
    seed = first
    while rods:
        study = random_study(seed)
        if study is not None:
            # Of the rods held out every other one is loaded by contact, as a run is by default.
            in_contact = kind != CALIBRATION and seed % 2 == 1
            yield kind, f"rod {seed}", randomly_loaded(study, seed, in_contact=in_contact)
            rods -= 1
        seed += 1


def held_out(asked: str) -> Iterator[Job]:
    """Random rods that had no part in choosing the constants, from ``FIRST_SEED:RODS``."""
    first, rods = map(int, asked.split(":"))
    return random_rods(f"hold-out {first}", first, rods)


def done(job: Job) -> tuple[str, str, Rows | str]:
    """Rows of a job, or why there are none."""
    kind, name, study = job
    try:
        if study is not None:
            return kind, name, rod_rows(name, study)
        second = [row("exact solutions", known) for known in exact_peaks(2)]
        second += [row("benchmark problems", known) for known in benchmark_peaks()]
        return kind, name, second + [row("first order", known) for known in exact_peaks(1, SIZES[1:])]
    except Exception as error:
        return kind, name, f"{type(error).__name__}: {error}"


def main() -> None:
    """Compute every case anew; the report is written as far as it has come whenever one is done."""
    parser = reporting(__doc__)
    parser.add_argument(
        "--hold-out", nargs="+", default=["110000:14"], help="first seed and rods of each set"
    )
    parser.add_argument("--calibration", action="store_true", help="the calibration set as well")
    parser.add_argument("--processes", type=int, default=2)
    arguments = parser.parse_args()
    jobs = [
        ("known answers", "known answers", None),
        *(job for asked in arguments.hold_out for job in held_out(asked)),
        *(calibration() if arguments.calibration else ()),
    ]
    found: list[tuple[str, str, Rows | str]] = []
    with multiprocessing.get_context("spawn").Pool(arguments.processes, maxtasksperchild=1) as pool:
        for outcome in pool.imap_unordered(done, jobs):
            found.append(outcome)
            print(f"{len(found)} of {len(jobs)}: {outcome[1]}", file=sys.stderr, flush=True)
            if arguments.report:
                arguments.report.write_text(report_text(found, command()))
    print(report_text(found, command()))


if __name__ == "__main__":
    main()
