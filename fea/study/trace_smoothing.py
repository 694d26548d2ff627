"""Smoothing of noise in finely sampled pressures, as little as serves."""

from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats

# Smoothed without being asked: samples at most this far apart whose noise is above this part of the peak.
# A mean over one degree flattens a combustion peak by p″/24, some hundredths of a percent.
_FINE_DEG, _NOISY = 0.5, 1e-3
_WIDTH_DEG = 1.0
# Not smoothed without being asked if the peak changes by more of it and by more times the noise: knocking.
_MOST_CHANGE, _MOST_NOISE = 0.01, 5.0
_CYCLE = 720.0
_SAME = 1e-3  # degrees: angles that differ by less than encoders tell apart


class Smoothed(NamedTuple):
    """Smoothed pressures.

    Attributes
    ----------
    pressures
        (n,)
    width
        Of the moving average, degrees; 0 for none.
    change
        The largest change of a pressure.
    """

    pressures: Floats
    width: float
    change: float


def smoothed(angles: Floats, pressures: Floats, step: float, width: float | None) -> Smoothed:
    """Smooth a cycle by a moving average.

    Parameters
    ----------
    angles
        (n,) degrees, increasing within one cycle.
    pressures
        (n,)
    step
        Degrees between most samples.
    width
        Of the average, degrees; None to decide by the noise.
    """
    if width:
        return _averaged(angles, pressures, width)
    plain = Smoothed(pressures, 0.0, 0.0)
    peak, noise = float(np.abs(pressures).max()), _noise(pressures)
    if width == 0 or step > _FINE_DEG or noise <= _NOISY * peak:
        return plain
    found = _averaged(angles, pressures, _WIDTH_DEG)
    changed = abs(float(found.pressures.max() - pressures.max()))
    return found if changed <= max(_MOST_CHANGE * peak, _MOST_NOISE * noise) else plain


def _averaged(angles: Floats, pressures: Floats, width: float) -> Smoothed:
    """Mean over the samples within half a width, as many on either side; the cycle repeats."""
    around = np.concatenate([angles - _CYCLE, angles, angles + _CYCLE])
    sums = np.concatenate([[0.0], np.cumsum(np.tile(pressures, 3))])
    half = width / 2 + _SAME
    first, last = np.searchsorted(around, angles - half), np.searchsorted(around, angles + half, side="right")
    own = np.arange(angles.size) + angles.size
    beside = np.minimum(own - first, last - 1 - own)
    mean = (sums[own + beside + 1] - sums[own - beside]) / (2 * beside + 1)
    return Smoothed(mean, width, float(np.abs(mean - pressures).max()))


def _noise(pressures: Floats) -> float:
    """Standard deviation of the noise, from the median of second differences (6 σ² for white noise)."""
    second = np.diff(pressures, n=2)
    return float(1.4826 * np.median(np.abs(second)) / np.sqrt(6)) if second.size else 0.0
