"""Rainflow counting of a repeated history: the cycles that close in its second period.

They are those of ASTM E1049 begun at the largest peak. A range between two that are not smaller is closed,
wherever it stands (the four-point rule), so that all such ranges of a history are taken out at once.
"""

import numpy as np

from geometry.arrays import Floats, Ints


def cycle_ends(history: Floats) -> Ints:
    """Return where in a period (n,) each cycle begins and ends: numbers (2, n_cycles) of its values."""
    start = int(np.argmax(history))
    order = np.append(np.roll(np.arange(len(history)), -start), start)
    rising = np.diff(history[order])
    order = order[np.append(True, rising != 0)]
    rising = rising[rising != 0] > 0
    order = order[np.concatenate([[True], rising[1:] != rising[:-1], [True]])] if rising.size else order[:0]
    ends = [np.empty((2, 0), dtype=np.int64)]
    while len(order) > 1:
        size = np.abs(np.diff(history[order]))
        closed = (size <= np.append(np.inf, size[:-1])) & (size <= np.append(size[1:], -np.inf))
        # Of equal ranges side by side, every other one.
        number = np.arange(len(size))
        closed &= (number - np.maximum.accumulate(np.where(closed, -1, number))) % 2 == 1
        at = np.flatnonzero(closed)
        if not at.size:
            raise ValueError("a history must be finite")
        ends.append(np.stack([order[at], order[at + 1]]))
        order = np.delete(order, np.concatenate([at, at + 1]))
    return np.concatenate(ends, axis=1)


def rainflow(history: Floats) -> tuple[Floats, Floats]:
    """Means and amplitudes of the cycles of a period (n,), each counted whole, wherever the period begins."""
    ends = history[cycle_ends(history)]
    return ends.mean(axis=0), np.ptp(ends, axis=0) / 2
