"""Compare series of computations: Pareto front, times at equal error, advice."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from fea.verify.computations import ConvergenceRow

# Smaller errors, percent, come from the reference or are accidental; `floor` is what they count as.
FLOOR = 0.05
# The error of stress decreases with the size to the power of the element's order, at best to twice that
# power.
_BEST_RATE = 2


def pareto(rows: Sequence[ConvergenceRow], floor: float = FLOOR) -> list[ConvergenceRow]:
    """The rows of one problem that no other row beats in both time and error, the fastest first."""
    best: list[ConvergenceRow] = []
    for row in sorted(rows, key=lambda row: (row.seconds, abs(row.error_percent))):
        if not best or max(abs(row.error_percent), floor) < max(abs(best[-1].error_percent), floor):
            best.append(row)
    return best


def by_tool(rows: Iterable[ConvergenceRow]) -> dict[tuple[str, str], list[ConvergenceRow]]:
    """Rows of one problem by tool and element, each from coarse to fine."""
    series: dict[tuple[str, str], list[ConvergenceRow]] = {}
    for row in sorted(rows, key=lambda row: -row.computation.size):
        series.setdefault((row.computation.tool, row.computation.element), []).append(row)
    return series


def settled(rows: Sequence[ConvergenceRow], floor: float = FLOOR) -> list[float]:
    """Largest error, percent, of each mesh of a series and all finer ones.

    A mesh may be right by accident if the signed error crosses zero; the finer meshes show this. For the
    finest mesh there is none, so that its error counts as at least the error of the previous mesh reduced at
    twice the theoretical rate.
    """
    error = [abs(row.error_percent) for row in rows]
    if len(rows) > 1 and not rows[0].computation.adaptive:
        before, last = rows[-2].computation, rows[-1].computation
        error[-1] = max(error[-1], error[-2] * (last.size / before.size) ** (_BEST_RATE * last.order))
    running = np.maximum.accumulate(error[::-1])[::-1]
    return [max(float(value), floor) for value in running]


def fastest_within(rows: Sequence[ConvergenceRow], percent: float) -> dict[tuple[str, str], ConvergenceRow]:
    """Per tool and element, the fastest row for which it and all finer rows have errors within `percent`."""
    fastest = {}
    for tool, series in by_tool(rows).items():
        within = [row for row, error in zip(series, settled(series), strict=True) if error <= percent]
        if within:
            fastest[tool] = min(within, key=lambda row: row.seconds)
    return fastest


def seconds_to(rows: Sequence[ConvergenceRow], percent: float, floor: float = FLOOR) -> float:
    """Time after which a series stays below an error, interpolated logarithmically; infinite if never."""
    seconds = [row.seconds for row in rows]
    errors = settled(rows, floor)
    if not errors or errors[-1] > percent:
        return np.inf
    first = next(number for number, error in enumerate(errors) if error <= percent)
    if first == 0:
        return seconds[0]
    places = np.log([errors[first], errors[first - 1]])
    return float(np.exp(np.interp(np.log(percent), places, np.log([seconds[first], seconds[first - 1]]))))


PERCENTS = (5.0, 2.0, 1.0)
# Target: this many times as fast as CalculiX at equal error.
GOAL = 10.0
WHOLE, THEIRS = "fea, whole", "CalculiX"


@dataclass(frozen=True)
class EqualError:
    """Seconds to reach an error: infinite if a tool did not reach it."""

    percent: float
    #: ours, whole, theirs: s, of `fea` at its best and without mirror planes, and of CalculiX at its best
    ours: float
    whole: float
    theirs: float
    #: CalculiX's slowest row, s: if it did not reach the error, it would take longer than this
    longest: float

    @property
    def ratio(self) -> float:
        """CalculiX's time over ours, or a lower bound of it; NaN if we did not reach the error."""
        theirs = self.theirs if math.isfinite(self.theirs) else self.longest
        return theirs / self.ours if math.isfinite(self.ours) else math.nan

    @property
    def goal_met(self) -> bool:
        """Whether the ratio reaches `GOAL`."""
        return self.ratio >= GOAL


def same_mesh(rows: Sequence[ConvergenceRow]) -> list[tuple[ConvergenceRow, ConvergenceRow]]:
    """Rows of `fea` and of CalculiX on the same meshes, coarse to fine, where `fea` estimates its error."""
    series = by_tool(rows)
    return [
        (ours, theirs)
        for (tool, element), of_fea in series.items()
        if tool == "fea"
        for ours in of_fea
        for theirs in series.get((THEIRS, element), ())
        if theirs.computation.size == ours.computation.size and ours.error_bar is not None
    ]


def equal_error(rows: Sequence[ConvergenceRow], floor: float = FLOOR) -> list[EqualError]:
    """Compare at each of `PERCENTS`; empty without CalculiX."""
    longest = max((row.seconds for row in rows if row.computation.tool == THEIRS), default=0.0)
    compared = []
    for percent in PERCENTS if longest else ():
        best = dict.fromkeys(("ours", WHOLE, THEIRS), math.inf)
        for (tool, _), series in by_tool(rows).items():
            program = tool if tool in best else "ours"
            best[program] = min(best[program], seconds_to(series, percent, floor))
        compared.append(EqualError(percent, best["ours"], best[WHOLE], best[THEIRS], longest))
    return compared


def advice(rows: Sequence[ConvergenceRow], floor: float = FLOOR) -> list[str]:
    """A sentence for each accuracy, from the rows of the rod, whose errors are known to `floor` percent."""
    against = {compared.percent: compared for compared in equal_error(rows, floor)}
    return [_sentence(rows, percent, against.get(percent), floor) for percent in PERCENTS]


def _sentence(
    rows: Sequence[ConvergenceRow], percent: float, against: EqualError | None, floor: float
) -> str:
    if percent < floor:
        return f"Within {percent:g} %: the reference is not accurate enough (±{floor:.2g} %)."
    fastest = fastest_within(rows, percent)
    ours = {kind: row for kind, row in fastest.items() if kind[0] != THEIRS}
    if not ours:
        return f"Within {percent:g} %: no computation reached this within the time limit."
    (tool, element), best = min(ours.items(), key=lambda item: item[1].seconds)
    finest = min(by_tool(rows)[tool, element], key=lambda row: row.computation.size)
    meshes = "the finest mesh of the comparison" if best is finest else "confirmed by all finer meshes"
    text = (
        f"For a peak within {percent:g} %, {meshes}, use `{best.computation.name}` "
        f"with {element.upper()} elements: {best.seconds:.1f} s at {best.dofs} dofs"
    )
    if against is not None and math.isfinite(against.theirs):
        text += f"; CalculiX takes {against.ratio:.1f} times as long for the same error"
    elif against is not None:
        text += f"; CalculiX did not reach this in {against.longest:.0f} s"
    first = [name for name, kind in fastest if kind == "p1"]
    return text + ("." if first else ". No first-order mesh reached this.")
