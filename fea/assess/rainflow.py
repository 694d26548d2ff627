"""Rainflow counting of a stress history that repeats (ASTM E1049-85, section 5.4.5)."""

import numpy as np

from geometry.arrays import Floats


def rainflow(history: Floats) -> tuple[Floats, Floats]:
    """Return the means and the amplitudes of the cycles of a period, each counted whole.

    Parameters
    ----------
    history
        (n,) one period, in the order of time; where it begins does not matter.
    """
    turning = _turning_points(history)
    kept: list[float] = []
    cycles: list[tuple[float, float]] = []
    for value in turning:
        kept.append(value)
        # A range that is not larger than the next one is closed by it.
        while len(kept) > 2 and abs(kept[-1] - kept[-2]) >= abs(kept[-2] - kept[-3]):
            *before, one, other, last = kept
            cycles.append((one, other))
            kept = [*before, last]
    ends = np.array(cycles).reshape(-1, 2)
    return ends.mean(axis=1), np.abs(ends[:, 1] - ends[:, 0]) / 2


def _turning_points(history: Floats) -> list[float]:
    """Extremes of a period that begins and ends with its largest value; none of a constant."""
    start = int(np.argmax(history))
    period = np.concatenate([history[start:], history[: start + 1]])
    period = period[np.concatenate([[True], np.diff(period) != 0])]
    rising = np.diff(period) > 0
    turns = np.concatenate([[True], rising[1:] != rising[:-1], [True]]) if len(period) > 1 else [False]
    return [float(value) for value in period[turns]]
