"""Roots of costly functions, such as the speed at which a safety factor is the required one."""

import math
from collections.abc import Callable, Iterable
from itertools import product
from typing import NamedTuple

from scipy.optimize import brentq

# To which level a root is found, after how many steps of each stage at most, and what may be left.
WITHIN, STEPS, ALMOST = 1e-3, 8, 5e-3
# The largest change of ln x in a step, and the least between places from which a slope is taken.
_LEAP, _APART = 0.5, 2e-3
_LARGEST = 50.0  # stands for an infinite level


class Root(NamedTuple):
    """Where a level passes 0."""

    x: float
    slope: float  #: d ln x/d level
    left: float  #: size of the level at x


def root(
    level: Callable[[float], float],
    near: Iterable[float],
    slope: float,
    ends: tuple[float, float],
    within: float = WITHIN,
) -> Root | None:
    """Find where a level, such as the logarithm of a safety factor, passes 0; None where it does not.

    Secants in ln x bracket the root; Brent's method then finds it to a level of `within`. `near`: positive
    places, near the root or where the level is cheap; `slope`: an estimate of d ln x/d level, whose sign says
    whether the level rises or falls through 0; `ends`: the range that is searched.
    """
    levels, steepness = {x: level(x) for x in near}, slope
    for _ in range(STEPS):
        best = min(levels, key=lambda x: abs(levels[x]))
        above, below = ([x for x, value in levels.items() if (value > 0) is side] for side in (True, False))
        if abs(levels[best]) < within or (above and below):
            break
        upwards = bool(above) is (slope < 0)  # the root is on this side, whatever the slope here
        x = max(levels) if upwards else min(levels)
        if x == ends[upwards] or not math.isfinite(levels[x]):
            return None
        step = leap(x, steepness if steepness * slope > 0 else slope, levels[x])
        step = min(max(step, ends[0]), ends[1])
        levels[step] = level(step)
        change = levels[step] - levels[x]
        if change and math.isfinite(change):
            steepness = math.log(step / x) / change
        else:  # on a plateau, such as of a share that is counted in whole facets
            steepness = slope if math.isinf(levels[step]) else 2 * steepness
    if above and below and abs(levels[best]) >= within:
        low, high = min(product(above, below), key=lambda pair: abs(pair[0] - pair[1]))

        def between(share: float) -> float:
            """Return the level at a share of the way from low to high in ln x; 0 where that suffices."""
            x = high if share == 1 else low * (high / low) ** share
            levels[x] = value = levels[x] if x in levels else level(x)
            return 0.0 if abs(value) < within else min(max(value, -_LARGEST), _LARGEST)

        brentq(between, 0.0, 1.0, maxiter=STEPS, disp=False)
        best = min(levels, key=lambda x: abs(levels[x]))
    left = abs(levels[best])
    if left >= max(ALMOST, within) and not (above and below):
        return None
    apart = {abs(math.log(x / best)): x for x, value in levels.items() if math.isfinite(value)}
    other = apart[min((distance for distance in apart if distance >= _APART), default=0.0)]
    change = levels[other] - levels[best]
    return Root(best, math.log(other / best) / change if change else slope, left)


def leap(x: float, slope: float, level: float) -> float:
    """Return where a level would pass 0 by its slope d ln x/d level, not too far away."""
    return x * math.exp(min(max(-slope * level, -_LEAP), _LEAP))
