"""Cracks under a stress that varies with depth: their stress intensity, and how they grow by Paris' law.

Stress intensity follows from weight functions whose coefficients reproduce that of uniform and of linear
stress (Shen & Glinka 1991), which Newman & Raju (1981) give for half an ellipse at the surface of a plate;
the edge crack is the limit of a long one. A crack inside is round (Sneddon 1946).
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from fea.base.material import CrackMetal
from geometry.arrays import Floats

DEEPEST = 0.8  # depth over wall up to which Newman & Raju's equations hold
_METRE = 1e-3
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(12)
_POINTS, _WEIGHTS = (_POINTS + 1) / 2, _WEIGHTS / 2
_STEP = 0.02  # relative growth of the faster of both dimensions

# K, MPa √m, at the deepest point and at the surface, of depth and half length, mm.
Intensity = Callable[[float, float], tuple[float, float]]


def _newman_raju(depth: float, half: float, wall: float, sine: float) -> tuple[float, float]:
    """K over σ √(π a/Q) in tension, and of a stress that falls linearly to 0 at the depth a of the crack.

    At the angle of a sine, 1 at the deepest point and 0 at the surface; half the length is at least a.
    """
    ratio, share = depth / half, depth / wall
    m1 = 1.13 - 0.09 * ratio
    m2 = -0.54 + 0.89 / (0.2 + ratio)
    m3 = 0.5 - 1 / (0.65 + ratio) + 14 * (1 - ratio) ** 24
    g = 1 + (0.1 + 0.35 * share**2) * (1 - sine) ** 2
    angle = (ratio**2 * (1 - sine**2) + sine**2) ** 0.25
    uniform = (m1 + m2 * share**2 + m3 * share**4) * g * angle
    # (1 − H)/share: σ (1 − x/a) is tension and t/(2 a) of bending, σ (1 − 2 x/t).
    less = 0.34 + 0.11 * ratio
    if sine:
        less = 1.22 + 0.12 * ratio - (0.55 - 1.05 * ratio**0.75 + 0.47 * ratio**1.5) * share
    return uniform, uniform * (1 - less / 2)


def surface_intensity(
    depth: float, half: float, wall: float, stress: Callable[[Floats], Any]
) -> tuple[float, float]:
    """K, MPa √m, at the deepest point and at the surface of half an ellipse in a wall, mm.

    `half` is half of its length; `stress` (n,), MPa, is that at depths (n,), mm. A crack that is deeper than
    half its length counts as half a circle, which is larger.
    """
    half, v = max(half, depth), _POINTS
    root, shape = np.sqrt(depth * _METRE / np.pi), 1 + 1.464 * (depth / half) ** 1.65
    uniform, linear = np.pi / np.sqrt(2 * shape) * np.array(_newman_raju(depth, half, wall, 1.0))
    first = 4 * uniform - 6 * linear - 24 / 5
    weight = 1 + first * v + 3 * v**2 + 2 * (uniform - first - 4) * v**3
    deepest = 2 * np.sqrt(2) * root * (_WEIGHTS @ (weight * stress(depth * (1 - v**2))))
    uniform, linear = np.pi / np.sqrt(4 * shape) * np.array(_newman_raju(depth, half, wall, 0.0))
    first, second = 30 * linear - 18 * uniform - 8, 60 * uniform - 90 * linear + 15
    weight = 1 + first * v + second * v**2 - (1 + first + second) * v**3
    return float(deepest), float(4 * root * (_WEIGHTS @ (weight * stress(depth * v**2))))


def penny_intensity(radius: float, stress: float) -> float:
    """K, MPa √m, of a round crack inside under a uniform stress, MPa; radius in mm."""
    return float(2 / np.pi * stress * np.sqrt(np.pi * radius * _METRE))


def grown(
    size: tuple[float, float], deepest: float, high: Intensity, low: Intensity, metal: CrackMetal
) -> tuple[Floats, Floats, bool]:
    """Let a crack of a depth and half length grow to a `deepest` depth, mm, or until the rest breaks.

    Returned are cycles and depths (n,), and whether it breaks. K is `high` and `low` in turn, of which only
    the tensile part opens a crack. No threshold stops it: whether it grows is asked before. Midpoint rule.
    """

    def speed(a: float, c: float) -> tuple[float, float, float]:
        highest, lowest = high(a, c), low(a, c)
        ranges = (max(one, 0) - max(other, 0) for one, other in zip(highest, lowest, strict=True))
        da, dc = (metal.coefficient * each**metal.exponent for each in ranges)
        return da, dc, max(highest)

    (a, c), cycles, depths = size, [0.0], [size[0]]
    while True:
        da, dc, highest = speed(a, c)
        breaks = highest >= metal.toughness
        if breaks or a >= deepest * (1 - 1e-9) or max(da, dc) <= 0:
            return np.array(cycles), np.array(depths), breaks
        step = min(_STEP / max(da / a, dc / c), (deepest - a) / da if da > 0 else np.inf)
        da, dc, _ = speed(a + da * step / 2, c + dc * step / 2)
        a, c = a + da * step, max(c + dc * step, a + da * step)
        cycles.append(cycles[-1] + step)
        depths.append(a)
