"""Rough surfaces that touch: the pressure of their asperities, and the space between them.

Both depend on the gap between the mean planes of the undeformed surfaces, which may be negative.
"""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.special import ndtr, pbdv

from geometry.arrays import Floats

# Gaps over the roughness beyond which nothing touches: the pressure is 1e-10 of that of planes that coincide.
_APART = 6.0
# Where the table of pressures begins, and its length.
_NEAR, _PLACES = -20.0, 20000


@dataclass(frozen=True)
class Asperities:
    """Asperities with Gaussian heights on both surfaces (Greenwood & Tripp 1970, Proc. IMechE 185, 625-633).

    p = 16 √2 π/15 (σβη)² √(σ/β) E* F_5/2(h/σ), with F_n(x) = ∫ₓ^∞ (s − x)ⁿ exp(−s²/2) ds/√2π.
    """

    roughness: float  #: σ of both surfaces together, mm
    modulus: float  #: the factor before F_5/2, MPa
    friction: float  #: coefficient of boundary friction

    @classmethod
    def of(
        cls, roughness: float, crowding: float, slope: float, stiffness: float, friction: float
    ) -> "Asperities":
        """By σβη and σ/β, radius β and number per area η of the summits, and E* of the surfaces, MPa."""
        modulus = 16 * math.sqrt(2) * math.pi / 15 * crowding**2 * math.sqrt(slope) * stiffness
        return cls(roughness, modulus, friction)

    def pressure(self, gap: Floats) -> tuple[Floats, Floats]:
        """Pressure, MPa, and its derivative, MPa/mm, at gaps, mm."""
        ratio, pressure, slope = gap / self.roughness, np.zeros_like(gap), np.zeros_like(gap)
        near = ratio < _APART
        if near.any():
            places, logs, slopes = _table()
            pressure[near] = self.modulus * np.exp(np.interp(ratio[near], places, logs))
            slope[near] = pressure[near] / self.roughness * np.interp(ratio[near], places, slopes)
        return pressure, slope

    def space(self, gap: Floats) -> tuple[Floats, Floats]:
        """Mean distance of the surfaces that oil can fill, mm, and its derivative.

        It is the mean of h + s where that is positive, with the Gaussian heights s (Wu & Zheng 1989, Journal
        of Tribology 111, 179-185).
        """
        ratio = gap / self.roughness
        share = ndtr(ratio)
        return gap * share + self.roughness * np.exp(-(ratio**2) / 2) / math.sqrt(2 * math.pi), share


def _integral(order: float, x: Floats) -> tuple[Floats, Floats]:
    """F_n(x) by the parabolic cylinder function D_−n−1 (Abramowitz & Stegun 1964, 19.5.3), and its slope."""
    values, slopes = pbdv(-order - 1, x)
    factor = math.gamma(order + 1) / math.sqrt(2 * math.pi) * np.exp(-(x**2) / 4)
    return np.asarray(factor * values), np.asarray(factor * (slopes - x / 2 * values))


@cache
def _table() -> Floats:
    """Places, the logarithm of F_5/2 there and its slope (3, n), between which all is linear.

    That changes no pressure by more than 1e-6; nearer than its beginning, planes are only on the way to a
    solution.
    """
    x = np.linspace(_NEAR, _APART, _PLACES)
    integral, slope = _integral(2.5, x)
    return np.stack([x, np.log(integral), slope / integral])
