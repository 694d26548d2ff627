"""Smoothing of noise in finely sampled pressures, as little as serves."""

from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats

# Smoothed without being asked: samples at most this far apart whose noise is above this part of the peak.
# A mean over one degree flattens a combustion peak by p″/24, some hundredths of a percent.
_FINE_DEG, _NOISY = 0.5, 1e-3
WIDTH_DEG = 1.0
# Not smoothed without being asked if the peak changes by more of it and by more times the noise: knocking.
_MOST_CHANGE, _MOST_NOISE = 0.01, 5.0


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


def smoothed(pressures: Floats, step: float, width: float | None) -> Smoothed:
    """Smooth a cycle by a moving average.

    Parameters
    ----------
    pressures
        (n,) of a whole cycle.
    step
        Degrees between samples.
    width
        Of the average, degrees; None to decide by the noise.
    """
    plain = Smoothed(pressures, 0.0, 0.0)
    peak = float(np.abs(pressures).max())
    if width is None:
        noise = _noise(pressures)
        if step > _FINE_DEG or noise <= _NOISY * peak:
            return plain
        found = _averaged(pressures, step, WIDTH_DEG)
        changed = abs(float(found.pressures.max() - pressures.max()))
        return found if changed <= max(_MOST_CHANGE * peak, _MOST_NOISE * noise) else plain
    return _averaged(pressures, step, width) if width > step else Smoothed(pressures, width, 0.0)


def _averaged(pressures: Floats, step: float, width: float) -> Smoothed:
    """Mean over the samples within half a width on either side; the cycle is periodic."""
    half = min(int(width / step / 2 + 1e-9), (pressures.size - 1) // 2)
    around = np.concatenate([pressures[pressures.size - half :], pressures, pressures[:half]])
    mean = np.convolve(around, np.full(2 * half + 1, 1 / (2 * half + 1)), mode="valid")
    return Smoothed(mean, width, float(np.abs(mean - pressures).max()))


def _noise(pressures: Floats) -> float:
    """Standard deviation of the noise, from the median of second differences (6 σ² for white noise)."""
    second = np.diff(pressures, n=2)
    return float(1.4826 * np.median(np.abs(second)) / np.sqrt(6)) if second.size else 0.0
