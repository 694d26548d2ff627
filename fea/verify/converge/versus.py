"""Times of fea and CalculiX at equal error, and errors at equal time."""

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from fea.verify.converge.front import FLOOR, by_tool, error_after, seconds_to
from fea.verify.converge.row import Row

PERCENTS = (5.0, 2.0, 1.0)
SECONDS = (0.3, 1.0, 3.0, 10.0, 30.0)
# Target: this many times as fast as CalculiX at equal error.
GOAL = 10.0
WHOLE, THEIRS = ("fea, whole",), ("CalculiX",)


@dataclass(frozen=True)
class EqualError:
    """Seconds to reach an error: infinite if a tool did not reach it.

    Attributes
    ----------
    percent
        The error.
    ours, whole, theirs
        Of `fea` at its best, of `fea` without mirror planes, and of CalculiX at its best, s.
    longest
        CalculiX's slowest row, s: if it did not reach the error, it would take longer than this.
    """

    percent: float
    ours: float
    whole: float
    theirs: float
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


class EqualTime(NamedTuple):
    """What two programs reach in the same time.

    Attributes
    ----------
    seconds
        The time.
    ours, theirs
        Errors of `fea` and of CalculiX, each at its best, percent.
    """

    seconds: float
    ours: float
    theirs: float


def equal_error(rows: Sequence[Row], floor: float = FLOOR) -> list[EqualError]:
    """Compare at each of `PERCENTS`; empty without CalculiX.

    Parameters
    ----------
    rows
        Rows of one problem.
    floor
        Smaller errors, percent, count as this value.
    """
    longest = max((row.measured.seconds for row in rows if row.computation.tool in THEIRS), default=0.0)
    programs = (_ours(rows), WHOLE, THEIRS)
    if not longest:
        return []
    compared = []
    for percent in PERCENTS:
        until = partial(seconds_to, percent=percent, floor=floor)
        ours, whole, theirs = (_best(rows, tools, until) for tools in programs)
        compared.append(EqualError(percent, ours, whole, theirs, longest))
    return compared


def equal_time(rows: Sequence[Row], floor: float = FLOOR) -> list[EqualTime]:
    """Compare at each of `SECONDS`, as far as both have rows.

    Parameters
    ----------
    rows
        Rows of one problem.
    floor
        Smaller errors, percent, count as this value.
    """
    programs = (_ours(rows), THEIRS)
    longest = min(
        max((row.measured.seconds for row in rows if row.computation.tool in tools), default=0.0)
        for tools in programs
    )
    found = []
    for seconds in (time for time in SECONDS if time <= longest):
        after = partial(error_after, seconds=seconds, floor=floor)
        ours, theirs = (_best(rows, tools, after) for tools in programs)
        if math.isfinite(ours) and math.isfinite(theirs):
            found.append(EqualTime(seconds, ours, theirs))
    return found


def _ours(rows: Sequence[Row]) -> set[str]:
    return {row.computation.tool for row in rows} - {*WHOLE, *THEIRS}


def _best(rows: Sequence[Row], tools: Collection[str], measure: Callable[[list[Row]], float]) -> float:
    """The smallest value that any series of these tools gives; infinite if there is none."""
    series = by_tool(row for row in rows if row.computation.tool in tools).values()
    return min((measure(own) for own in series), default=math.inf)
