"""The multiple of a load at which something begins, such as the opening of a joint."""

from collections.abc import Callable

from scipy.optimize import brentq

# Largest multiple that is tried, relative error of the multiple, and most states that are tried.
LARGEST, WITHIN, _MOST = 8.0, 0.02, 12


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
    low, high = 0.0, 1.0
    while left(high) > 0:
        if high >= LARGEST:
            return None
        low, high = high, 2 * high
    found = brentq(left, low, high, xtol=WITHIN * high / 2, rtol=WITHIN, maxiter=_MOST, disp=False)
    return float(found)
