"""Cracks under a stress that varies with depth: their stress intensity, and how they grow by Paris' law.

Stress intensity of half an ellipse at the surface of a plate follows from weight functions whose coefficients
reproduce that of uniform and of linear stress (Shen & Glinka 1991), which Newman & Raju (1981) give. A long
one turns into an edge crack in a strip, with the weight function of Fett & Munz (1997; from memory, held to
handbooks in `tests/judge/test_crack.py`). An ellipse inside has the equations of Newman & Raju (1984) for a
plate whose surfaces are both as far from its middle as the nearer one.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from fea.base.material import CrackMetal
from geometry.arrays import Floats

# Depth over wall to which Newman & Raju's equations hold; of a flaw inside, over the depth where it begins.
DEEPEST = 0.8
_METRE = 1e-3
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(12)
_POINTS, _WEIGHTS = (_POINTS + 1) / 2, _WEIGHTS / 2
# Fett & Munz: of (1 − x/a)^(ν + 1) α^μ, by ν and μ, with α the depth over the wall.
_EDGE = np.array(
    [
        [0.4980, 2.4463, 0.0700, 1.3187, -3.067],
        [0.5416, -5.0806, 24.3447, -32.7208, 18.1214],
        [-0.19277, 2.55863, -12.6415, 19.7630, -10.986],
    ]
)
_LONG = 40  # power of 1 − a/c: how much of an edge crack half an ellipse is; 0.01 % at 0.2, their longest
# Of half the height of a flaw inside: where the stress counts for an end. Exact for a round one and linear
# stress (Tada, Paris & Irwin); 1/2 for a long one.
_TOWARDS_END = 2 / 3
_STEP = 0.02  # relative growth of the fastest of the dimensions

Stress = Callable[[Floats], Any]  # (n,) MPa, across the plane of a crack at depths (n,), mm
# K (k,), MPa √m, at the ends of a crack of dimensions (k,), mm, under a stress.
Intensity = Callable[[Floats, Stress], Floats]


class CrackLoad(NamedTuple):
    """Cycles that are alike: the stress where it opens the crack most, and least; the rest between."""

    high: Stress
    low: Stress
    rate: float  #: of such cycles, an hour


class CrackGrowth(NamedTuple):
    """How a crack grows."""

    hours: Floats  #: (n,) rising, from 0
    sizes: Floats  #: (n, k) its dimensions, mm
    breaks: bool  #: whether the rest breaks at the end
    surfaces: float | None = None  #: hours until one that began inside has reached the surface


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


def edge_intensity(depth: float, wall: float, stress: Stress) -> float:
    """K, MPa √m, of an edge crack in a strip of a width, `wall`, whose ends turn freely; mm."""
    v, share = _POINTS, depth / wall  # at x = a (1 − v²)
    weight = 1 + _EDGE @ share ** np.arange(5) / (1 - share) ** 1.5 @ v ** np.array([[2], [4], [6]])
    return float(np.sqrt(8 / np.pi * depth * _METRE) * (_WEIGHTS @ (weight * stress(depth * (1 - v**2)))))


def surface_intensity(size: Floats, stress: Stress, wall: float) -> Floats:
    """K (2,), MPa √m, at the deepest point and at the surface of half an ellipse in a wall, mm.

    `size`: depth and half of the length, mm. A crack that is deeper than half its length counts as half a
    circle, which is larger.
    """
    depth, half = float(size[0]), float(size.max())
    v, long = _POINTS, (1 - depth / half) ** _LONG
    root, shape = np.sqrt(depth * _METRE / np.pi), 1 + 1.464 * (depth / half) ** 1.65
    uniform, linear = np.pi / np.sqrt(2 * shape) * np.array(_newman_raju(depth, half, wall, 1.0))
    first = 4 * uniform - 6 * linear - 24 / 5
    weight = 1 + first * v + 3 * v**2 + 2 * (uniform - first - 4) * v**3
    deepest = 2 * np.sqrt(2) * root * (_WEIGHTS @ (weight * stress(depth * (1 - v**2))))
    uniform, linear = np.pi / np.sqrt(4 * shape) * np.array(_newman_raju(depth, half, wall, 0.0))
    first, second = 30 * linear - 18 * uniform - 8, 60 * uniform - 90 * linear + 15
    weight = 1 + first * v + second * v**2 - (1 + first + second) * v**3
    at_surface = 4 * root * (_WEIGHTS @ (weight * stress(depth * v**2)))
    return np.array([(1 - long) * deepest + long * edge_intensity(depth, wall, stress), at_surface])


def inside_intensity(size: Floats, stress: Stress, below: float) -> Floats:
    """K (3,), MPa √m, of an ellipse inside: at the end near the surface, at the other, and at its sides.

    `size`: how far it reaches towards the surface and away from it, from a place `below` it, and half of the
    length, mm. One that is higher than long counts as a circle, which is larger.
    """
    height, middle = (size[0] + size[1]) / 2, below + (size[1] - size[0]) / 2
    ratio, share = height / max(float(size[2]), height), height / middle
    grows = 1 + 0.05 / (0.11 + ratio**1.5) * share**2 + 0.29 / (0.23 + ratio**1.5) * share**4
    sides = (1 - share**4 * np.sqrt(2.6 - 2 * share) / (1 + 4 * ratio)) * np.sqrt(ratio)
    apart = _TOWARDS_END * height
    opened = stress(np.array([middle - apart, middle + apart, middle])) * np.array([1, 1, sides])
    return np.asarray(opened * grows * np.sqrt(np.pi * height * _METRE / (1 + 1.464 * ratio**1.65)))


def grown(
    size: Floats, furthest: float, intensity: Intensity, loads: Sequence[CrackLoad], metal: CrackMetal
) -> CrackGrowth:
    """Let a crack of dimensions (k,) grow until the first is `furthest`, mm, or until the rest breaks.

    Only the tensile part of a cycle opens it. No threshold stops it: that is asked before. Midpoint rule.
    """

    def speed(size: Floats) -> tuple[Floats, float]:
        rates, largest = np.zeros_like(size), 0.0
        for high, low, rate in loads:
            highest, lowest = (np.maximum(intensity(size, stress), 0) for stress in (high, low))
            rates += rate * metal.coefficient * np.maximum(highest - lowest, 0) ** metal.exponent
            largest = max(largest, float(highest.max()))
        return rates, largest

    hours, sizes, breaks = [0.0], [size], False
    while size[0] < furthest * (1 - 1e-9):
        rates, largest = speed(size)
        breaks = largest >= metal.toughness
        if breaks or rates.max() <= 0:
            break
        step = _STEP / float((rates / size).max())
        rates, _ = speed(size + rates * step / 2)
        step = min(step, float((furthest - size[0]) / rates[0])) if rates[0] > 0 else step
        size = size + rates * step
        hours.append(hours[-1] + step)
        sizes.append(size)
    return CrackGrowth(np.array(hours), np.array(sizes), breaks)


def grown_flaw(
    size: tuple[float, float], below: float, wall: float, loads: Sequence[CrackLoad], metal: CrackMetal
) -> CrackGrowth:
    """Let half an ellipse of a depth and half length, mm, grow to `DEEPEST` of the wall, or until it breaks.

    One that is deeper than half its length begins as half a circle. Where its middle lies `below` the
    surface, mm, it is a whole ellipse of a height: where little is left before the surface, or where that
    breaks, it goes on as half an ellipse that is as deep as its farther end. The dimensions of the growth
    are the height, then the depth, and half of the length.
    """
    if below <= 0:
        start = np.array([size[0], max(size)])
        return grown(start, DEEPEST * wall, partial(surface_intensity, wall=wall), loads, metal)
    start = np.array([size[0] / 2, size[0] / 2, size[1]])
    inside = grown(start, DEEPEST * below, partial(inside_intensity, below=below), loads, metal)
    near, far, half = inside.sizes[-1].tolist()
    inside = inside._replace(sizes=np.stack([inside.sizes[:, :2].sum(axis=1), inside.sizes[:, 2]], axis=1))
    if not inside.breaks and near < DEEPEST * below * (1 - 1e-6):  # nothing opens it
        return inside
    beyond, since = grown_flaw((below + far, half), 0.0, wall, loads, metal), float(inside.hours[-1])
    hours = np.concatenate([inside.hours, since + beyond.hours])
    return CrackGrowth(hours, np.concatenate([inside.sizes, beyond.sizes]), beyond.breaks, since)
