"""Our time against CalculiX's at equal error, and the errors at equal time."""

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from fea.verify.converge.front import FLOOR, by_tool, error_after, seconds_to
from fea.verify.converge.row import Row

PERCENTS = (5.0, 2.0, 1.0)
SECONDS = (0.3, 1.0, 3.0, 10.0, 30.0)
# Times as fast as CalculiX at equal error is what we aim at.
GOAL = 10.0
WHOLE, THEIRS = ("fea, whole",), ("CalculiX",)


@dataclass(frozen=True)
class EqualError:
    """Seconds to one error: infinite where a tool did not get there.

    Attributes
    ----------
    percent
        The error.
    ours, whole, theirs
        Of `fea` at its best, of `fea` without mirror planes, and of CalculiX at its best, s.
    longest
        CalculiX's slowest row, s: where it did not get there, it takes longer than that.
    """

    percent: float
    ours: float
    whole: float
    theirs: float
    longest: float

    @property
    def ratio(self) -> float:
        """CalculiX's time over ours, at least; NaN where we did not get there."""
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
        Of one problem.
    floor
        Errors are not known better, percent.
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
        Of one problem.
    floor
        Errors are not known better, percent.
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
    """The least that any series of these tools gives; infinite where there is none."""
    series = by_tool(row for row in rows if row.computation.tool in tools).values()
    return min((measure(own) for own in series), default=math.inf)
