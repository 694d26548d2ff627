"""The Pareto front of error and time, and the error that each series reaches in a given time."""

from collections.abc import Iterable, Sequence

import numpy as np

from fea.verify.converge.row import Row

# Errors below this (percent) come from the reference or are accidental.
FLOOR = 0.05
# The error of stress decreases with the size to the power of the element's order, at best to twice that
# power.
_BEST_RATE = 2


def pareto(rows: Sequence[Row], floor: float = FLOOR) -> list[Row]:
    """The rows of one problem that no other row beats in both time and error, the fastest first.

    Parameters
    ----------
    rows
        Rows of one problem.
    floor
        Smaller errors, percent, count as this value.
    """
    best: list[Row] = []
    for row in sorted(rows, key=lambda row: (row.measured.seconds, abs(row.error_percent))):
        if not best or max(abs(row.error_percent), floor) < max(abs(best[-1].error_percent), floor):
            best.append(row)
    return best


def by_tool(rows: Iterable[Row]) -> dict[tuple[str, str], list[Row]]:
    """Rows of one problem by tool and element, each from coarse to fine."""
    found: dict[tuple[str, str], list[Row]] = {}
    for row in sorted(rows, key=lambda row: -row.computation.size):
        found.setdefault((row.computation.tool, row.computation.element), []).append(row)
    return found


def settled(rows: Sequence[Row], floor: float = FLOOR) -> list[float]:
    """Largest error, percent, of each mesh of a series and all finer ones.

    A mesh may be right by accident if the signed error crosses zero; the finer meshes show this. For the
    finest mesh there is none, so that its error counts as at least the error of the previous mesh reduced at
    twice the theoretical rate.

    Parameters
    ----------
    rows
        Rows of one problem, tool and element, coarse to fine.
    floor
        Smaller errors count as this value.
    """
    error = [abs(row.error_percent) for row in rows]
    if len(rows) > 1 and not rows[0].computation.adaptive:
        before, last = rows[-2].computation, rows[-1].computation
        error[-1] = max(error[-1], error[-2] * (last.size / before.size) ** (_BEST_RATE * last.order))
    running = np.maximum.accumulate(error[::-1])[::-1]
    return [max(float(value), floor) for value in running]


def fastest_within(rows: Sequence[Row], percent: float) -> dict[tuple[str, str], Row]:
    """Per tool and element, the fastest row for which it and all finer rows have errors within `percent`."""
    found = {}
    for tool, own in by_tool(rows).items():
        within = [row for row, error in zip(own, settled(own), strict=True) if error <= percent]
        if within:
            found[tool] = min(within, key=lambda row: row.measured.seconds)
    return found


def seconds_to(rows: Sequence[Row], percent: float, floor: float = FLOOR) -> float:
    """Time after which a series stays below an error, interpolated logarithmically; infinite if never.

    Parameters
    ----------
    rows
        Rows of one problem, tool and element, coarse to fine.
    percent
        The error.
    floor
        Smaller errors count as this value.
    """
    seconds = [row.measured.seconds for row in rows]
    errors = settled(rows, floor)
    if not errors or errors[-1] > percent:
        return np.inf
    first = next(number for number, error in enumerate(errors) if error <= percent)
    if first == 0:
        return seconds[0]
    places = np.log([errors[first], errors[first - 1]])
    return float(np.exp(np.interp(np.log(percent), places, np.log([seconds[first], seconds[first - 1]]))))


def error_after(rows: Sequence[Row], seconds: float, floor: float = FLOOR) -> float:
    """Error, percent, below which a series stays after a time, interpolated logarithmically.

    It is infinite before the first row, and that of the last row after it.
    """
    points = sorted(zip((row.measured.seconds for row in rows), settled(rows, floor), strict=True))
    if not points or seconds < points[0][0]:
        return np.inf
    times, errors = np.array(points).T
    best = np.minimum.accumulate(errors)
    return float(np.exp(np.interp(np.log(seconds), np.log(times), np.log(best))))
