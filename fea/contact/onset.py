"""The multiple of a load at which something begins, such as the opening of a joint."""

from collections.abc import Callable

from scipy.optimize import brentq

# Least and largest multiple that are tried, relative error of the multiple, and most steps to it.
LEAST, LARGEST, WITHIN, _MOST = 1 / 1024, 8.0, 0.02, 12


def onset(left: Callable[[float], float]) -> float | None:
    """Find where what is left of something first falls to zero; 0 where nothing is left without load.

    Parameters
    ----------
    left
        By the multiple, at least continuous before it falls to zero.

    Returns
    -------
    float or None
        None beyond `LARGEST`.
    """
    if left(0.0) <= 0:
        return 0.0
    high = 1.0
    while left(high) > 0:
        if high >= LARGEST:
            return None
        high *= 2
    low = high / 2
    while left(low) <= 0:
        if low <= LEAST:
            return low
        low, high = low / 2, low
    return float(brentq(left, low, high, xtol=WITHIN * low / 4, maxiter=_MOST, disp=False))
