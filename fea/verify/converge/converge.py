"""Run the comparison within a time limit, each computation in a separate process."""

import dataclasses
import math
import shutil
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

from fea.machine.isolated import fresh
from fea.study.study import Study
from fea.verify.cases.elasticity import EQUATOR, GOODIER_EQUATOR, HOOP, LAME_HOOP
from fea.verify.converge.measurement import (
    Computation,
    ConvergenceRow,
    Measured,
    Reference,
    compute,
    rod_reference,
)
from mesh.sizing import default_size

PROBLEMS = ("rod", "lame", "goodier")
# Shares of the time. The rod is the main problem; the others show that its result is not accidental.
SHARE = {"rod": 0.7, "lame": 0.15, "goodier": 0.15}
QUANTITY = {
    "rod": "rod: largest von Mises stress",
    "lame": f"lame: {LAME_HOOP}",
    "goodier": f"goodier: {GOODIER_EQUATOR}",
}
EXACT = {"lame": HOOP, "goodier": EQUATOR}
# Number of runs of a computation that takes less than LONG seconds; their median counts.
RUNS, LONG = 3, 5.0
# Largest cost of the next size relative to the previous one: 2.4 times the nodes, to the power 1.5.
_GROWTH = 3.5

# Ratio of successive sizes: each mesh has about 2.4 times the nodes of the previous one.
STEP = 0.75
LEVELS = 9
# Coarsest sizes: for the rod relative to its default size, for the others in mm.
COARSEST = {"rod": 2.4, "lame": 8.0, "goodier": 0.6}
TOLERANCES = (10.0, 5.0, 3.0, 2.0, 1.0)
TOOLS = ("fea", "fea, mean", "CalculiX")


def series(problem: str, default_size: float) -> Iterator[list[Computation]]:
    """The computations of a problem, in series that differ only in the size, coarse to fine.

    `default_size` is that of the rod, mm.
    """
    unit = default_size if problem == "rod" else 1.0
    sizes = [COARSEST[problem] * unit * STEP**level for level in range(LEVELS)]
    tools = [tool for tool in TOOLS if tool != "CalculiX" or shutil.which("ccx")]
    for tool in (*tools, *(["fea, whole"] if problem == "rod" else [])):
        for element in ("p1", "p2") if tool != "fea, whole" else ("p2",):
            yield [Computation(tool, element, problem, size) for size in sizes]
    if problem == "rod":
        yield [Computation("fea --tolerance", "p2", problem, percent) for percent in TOLERANCES]
        first = round(COARSEST[problem] * unit, 1)
        tool = f"fea --size {first:g} --tolerance"
        yield [Computation(tool, "p2", problem, percent, first) for percent in TOLERANCES]


Outcomes = dict[Computation, Measured]

Outcome = TypeVar("Outcome")


def _apart(work: Callable[..., Outcome], *arguments: object) -> Outcome | None:
    """Do it in a fresh interpreter, to measure its peak memory and to survive its crash; None if it fails."""
    try:
        with fresh(patient=True) as process:
            return process.run(work, *arguments)
    except Exception:  # noqa: BLE001 - a computation that fails is no point of the comparison
        return None


@dataclass(frozen=True)
class Comparison:
    """All rows, by problem, tool, element and size, and the references by problem."""

    rows: list[ConvergenceRow]
    references: dict[str, Reference]

    def of(self, problem: str) -> list[ConvergenceRow]:
        """Return the rows of a problem."""
        return [row for row in self.rows if row.computation.problem == problem]


def converge(
    study: Study, minutes: float = 10.0, listener: Callable[[str], None] | None = None
) -> Comparison:
    """Compare tools, elements and recoveries by error and total run time.

    Of the rod, the first load case at its first speed is used. The limit of `minutes` is that of everything
    except the rod's reference; `listener` is called with the name of each computation before it begins.
    """
    length = study.rod.length or 0.0
    rows: list[ConvergenceRow] = []
    references = {}
    for problem in PROBLEMS:
        if listener:
            listener(f"{problem}, reference")
        if problem in EXACT:
            references[problem] = Reference(EXACT[problem])
        else:
            unknown = Reference(math.nan, math.inf)
            references[problem] = _apart(rod_reference, study) or unknown
        outcomes = _computed(study, problem, default_size(length), 60 * minutes * SHARE[problem], listener)
        truth = references[problem].value
        rows += [
            ConvergenceRow(computation, found, QUANTITY[problem], 100 * (found.value / truth - 1))
            for computation, found in sorted(
                outcomes.items(), key=lambda item: (item[0].series, -item[0].size)
            )
        ]
    return Comparison(rows, references)


def _computed(
    study: Study, problem: str, size: float, seconds: float, listener: Callable[[str], None] | None
) -> Outcomes:
    """Refine the series with the cheapest next step, until no step fits into the remaining time."""
    end = time.perf_counter() + seconds
    waiting = [(0.0, computations) for computations in series(problem, size)]
    outcomes: Outcomes = {}
    _apart(compute, waiting[0][1][0], study)  # the first computation also pays for reading files
    while waiting:
        waiting.sort(key=lambda item: item[0])
        cost, (computation, *finer) = waiting.pop(0)
        if time.perf_counter() + cost > end:
            break
        if listener:
            listener(f"{problem}, {computation.tool}, {computation.element}, {computation.size:.3g}")
        start = time.perf_counter()
        found = _apart(compute, computation, study)
        if found is None:
            if finer and not any(done.series == computation.series for done in outcomes):
                waiting.append((cost, finer))  # this size was too coarse for the mesher
            continue
        spent = time.perf_counter() - start
        if spent < LONG:  # the median of the times counts
            again = [_apart(compute, computation, study) for _ in range(RUNS - 1)]
            times = [each.seconds for each in (found, *again) if each is not None]
            found = dataclasses.replace(found, seconds=statistics.median(times))
        outcomes[computation] = found
        if finer:
            waiting.append((_GROWTH * spent, finer))
    return outcomes
