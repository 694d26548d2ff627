"""Where a level that is costly to compute passes 0, in few steps."""

import math
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

# To which level a root is found, after how many steps at most, and what is left of one that counts.
WITHIN, STEPS, ALMOST = 1e-3, 8, 5e-3
# Relative distance of places from which a slope is taken, at least.
_APART = 2e-3
# A step changes the logarithm of the place by so much at most.
_LEAP = 0.5


class Root(NamedTuple):
    """Where a level passes 0: the place x, d ln x/d level there, and what is left of the level."""

    x: float
    slope: float
    left: float


def root(
    level: Callable[[float], float],
    known: Iterable[float],
    slope: float,
    ends: tuple[float, float],
    within: float = WITHIN,
) -> Root | None:
    """Find where a level passes 0, by secants in ln x within a bracket; None where it does not in the range.

    `known`: places near it, or whose level is at hand; `slope`: an estimate, whose sign says which way the
    level passes.
    """
    values, before = {x: level(x) for x in known}, slope
    for _ in range(STEPS):
        x = min(values, key=lambda at: abs(values[at]))
        if abs(values[x]) < within:
            break
        above, below = ([at for at, value in values.items() if (value > 0) is side] for side in (True, False))
        between = bool(above and below)
        if not between:  # an edge of this kind lies on one side, whatever the slope here
            upwards = (values[x] > 0) is (before < 0)
            x = max(values) if upwards else min(values)
            slope = slope if slope * before > 0 else before
            if x == ends[upwards] or not math.isfinite(values[x]):
                return None
        step = leap(x, slope, values[x])
        step = min(max(step, ends[0]), ends[1])
        if between:
            near = min(((p, q) for p in above for q in below), key=lambda pair: abs(pair[0] - pair[1]))
            if not min(near) < step < max(near):
                step = math.sqrt(near[0] * near[1])
        if step in values:
            break
        values[step] = level(step)
        change = values[step] - values[x]
        slope = math.log(step / x) / change if change and math.isfinite(change) else before
    x = min(values, key=lambda at: abs(values[at]))
    passed = abs(values[x]) < max(ALMOST, within) or len({value > 0 for value in values.values()}) > 1
    return Root(x, _slope(values, x, before), abs(values[x])) if passed else None


def leap(x: float, slope: float, level: float) -> float:
    """Return where a level would pass 0 by its slope d ln x/d level, not too far away."""
    return x * math.exp(min(max(-slope * level, -_LEAP), _LEAP))


def _slope(values: Mapping[float, float], x: float, otherwise: float) -> float:
    """D ln x/d level at a place, from the nearest other one that is not so near that rounding counts."""
    others = [at for at in values if abs(math.log(at / x)) >= _APART and math.isfinite(values[at])]
    if not others:
        return otherwise
    other = min(others, key=lambda at: abs(math.log(at / x)))
    change = values[other] - values[x]
    return math.log(other / x) / change if change else otherwise
