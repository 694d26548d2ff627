"""The compression of a pressure trace: its exponent, and the zero that the sensor has lost.

Piezoelectric sensors measure changes of pressure only. Between the closing of the valves and ignition the
absolute pressure follows p Vⁿ = const, so that of a measured p' = p − c the zero c is what makes it a
straight line over V⁻ⁿ (Randolph, SAE 900170). Exponent and zero together are badly conditioned, so that the
exponent has a prior. Nothing here depends on the unit: the law is the same in every one.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats

# Degrees from firing TDC: both valves are shut, and ignition is still to come, in nearly every engine.
FROM, TO = -100.0, -42.0
CLOSING = -130.0  # degrees from firing TDC at which the intake shuts, about
_SETTLED = 10.0  # degrees after that from which the law holds
# Exponents of compressions: mean and standard deviation of those of petrol and of diesel engines.
_PETROL, _DIESEL = (1.32, 0.03), (1.36, 0.03)
_DIESEL_RATIO = 13.5  # compression ratio from which an engine is taken for a diesel
_RATIOS = np.geomspace(7.5, 22.0, 17)  # of nearly all engines
ROD_RATIO = 0.29  # crank radius over rod length where it is not known; 0.2 to 0.33 change n by less than 0.05
_EXPONENTS = np.linspace(1.0, 1.8, 161)
# What a real compression departs from the law by, over the pressure; noise comes on top.
_DEPARTURE = 0.002
_LEAST_SAMPLES = 8
# Largest mean departure of a part of the samples, over the range of the pressures, that is not noise.
_BLOCKS, _CROOKED, _SIGNIFICANT = 4, 0.015, 4.0
# Largest departure, over the standard deviation of the pressures, with which there is a compression at all.
_NO_COMPRESSION = 0.5
# Exponents that measured compressions show, with a ratio that is 10 % and angles that are 2° off.
_USUAL_EXPONENTS = (1.15, 1.52)


@dataclass(frozen=True)
class Compression:
    """What a compression shows; pressures are in the unit of the trace."""

    exponent: float  #: n
    exponent_error: float  #: its standard deviation
    zero: float  #: c, added to the pressures of the trace it makes them absolute
    zero_error: float  #: its standard deviation; of both with that of a compression ratio that is not known
    closing: float  #: absolute pressure at which the intake shuts

    @property
    def is_usual(self) -> bool:
        """Whether the exponent, with its error, is one that compressions show."""
        least, most = _USUAL_EXPONENTS
        return least - 2 * self.exponent_error <= self.exponent <= most + 2 * self.exponent_error


def volume(degrees: Floats, ratio: float | Floats, rod_ratio: float = ROD_RATIO) -> Floats:
    """Volume over the swept volume at angles from TDC, degrees, of a compression ratio."""
    theta = np.radians(degrees)
    rod = (1 - np.sqrt(1 - (rod_ratio * np.sin(theta)) ** 2)) / rod_ratio
    return np.asarray(1 / (ratio - 1) + (1 - np.cos(theta) + rod) / 2, dtype=np.float64)


def compression(
    angles: Floats,
    pressures: Floats,
    ratio: float | None = None,
    rod_ratio: float = ROD_RATIO,
    shut: float = CLOSING,
) -> Compression | None:
    """Fit p + c = k V⁻ⁿ to a trace before ignition; None where it shows no compression.

    `angles` (n,) are degrees from firing TDC, `pressures` (n,) in any unit and of any zero; `rod_ratio`:
    crank radius over rod length; intake or exhaust port shut at about `shut`, degrees from firing TDC. Of an
    unknown compression `ratio`, those of nearly all engines are weighed by how well they fit.
    """
    inside = (angles >= max(FROM, shut + _SETTLED)) & (angles <= TO)
    theta, p = angles[inside], pressures[inside]
    if p.size < _LEAST_SAMPLES or not np.ptp(p) > 0:
        return None
    ratios = _RATIOS if ratio is None else np.array([ratio])
    lines = [_lines(theta, p, each, rod_ratio) for each in ratios]
    slope, zero, left, given = (np.array([getattr(line, name) for line in lines]) for name in _Lines._fields)
    best = np.unravel_index(int(left.argmin()), left.shape)
    if not math.sqrt(left.min() / p.size) <= _NO_COMPRESSION * float(p.std()) or slope[best] <= 0:
        return None
    shape = volume(theta, float(ratios[best[0]]), rod_ratio) ** -_EXPONENTS[best[1]]
    if _is_crooked(p + zero[best] - slope[best] * shape, float(np.ptp(p))):
        return None
    variance = left.min() / max(p.size - 3, 1) + (_DEPARTURE * float(np.ptp(p))) ** 2
    prior = np.array([_PETROL if each < _DIESEL_RATIO else _DIESEL for each in ratios])
    distance = (_EXPONENTS - prior[:, :1]) / prior[:, 1:]
    log = -(left / variance + distance**2) / 2
    weight = np.exp(log - log.max())
    weight /= weight.sum()
    exponent, mean = float((weight * _EXPONENTS).sum()), float((weight * zero).sum())
    at_closing = volume(np.full(1, shut), ratios[:, None], rod_ratio) ** -_EXPONENTS
    return Compression(
        exponent=exponent,
        exponent_error=math.sqrt(max(float((weight * (_EXPONENTS - exponent) ** 2).sum()), 1e-12)),
        zero=mean,
        zero_error=math.sqrt(float((weight * ((zero - mean) ** 2 + variance * given)).sum())),
        closing=float((weight * slope * at_closing).sum()),
    )


class _Lines(NamedTuple):
    """Straight lines p + c = k V⁻ⁿ, one for each of `_EXPONENTS`."""

    slope: Floats  #: k
    zero: Floats  #: c
    left: Floats  #: sum of squares that the line leaves
    given: Floats  #: variance of c, of pressures with a variance of one


def _lines(theta: Floats, p: Floats, ratio: float, rod_ratio: float) -> _Lines:
    base = volume(theta, ratio, rod_ratio)[:, None] ** -_EXPONENTS
    mean, y = base.mean(axis=0), p - p.mean()
    x = base - mean
    squares = (x**2).sum(axis=0)
    slope = (x * y[:, None]).sum(axis=0) / squares
    left = ((y[:, None] - slope * x) ** 2).sum(axis=0)
    return _Lines(slope, slope * mean - p.mean(), left, 1 / p.size + mean**2 / squares)


def _is_crooked(rest: Floats, height: float) -> bool:
    """Whether what a fit leaves of pressures that rise by `height` is more than noise: no compression."""
    noise = float(np.std(np.diff(rest))) / math.sqrt(2)
    means = [abs(float(block.mean())) for block in np.array_split(rest, _BLOCKS)]
    by_chance = _SIGNIFICANT * noise / math.sqrt(rest.size / _BLOCKS)
    return max(means) > max(_CROOKED * height, by_chance)


# A motored pressure is as low after TDC as before it, but for what heat and leaks take.
_LIKE_BEFORE = 1.06
_BESIDE = (20.0, 60.0)  # degrees from TDC at which both sides are compared


def is_motored(angles: Floats, absolute: Floats) -> bool:
    """Whether a cycle (n,) has no combustion: expansion does not exceed compression about TDC."""
    beside = np.linspace(*_BESIDE, 41)
    before, after = (np.interp(side * beside, angles, absolute, period=720.0) for side in (-1, 1))
    return bool(np.median(after / np.maximum(before, 1e-12)) <= _LIKE_BEFORE)


_TOP = 0.8  # of the peak: samples above it locate the peak


def peak_angle(angles: Floats, pressures: Floats) -> float:
    """Angle of the peak, degrees, by a parabola through the samples around it; `angles` (n,) increase."""
    at = angles[int(np.argmax(pressures))]
    near = np.mod(angles - at + 360.0, 720.0) - 360.0
    least = float(np.median(pressures))
    high = (np.abs(near) <= 8.0) & (pressures >= least + _TOP * (pressures.max() - least))
    if np.count_nonzero(high) < 4:
        return float(at)
    a, b, _ = np.polyfit(near[high], pressures[high], 2)
    return float(at - b / (2 * a)) if a < 0 else float(at)
