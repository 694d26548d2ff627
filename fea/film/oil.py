"""Oil under pressure: Roelands' viscosity, and the generalised pressure that the flow follows."""

import math
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats

# Roelands 1966, Correlational Aspects of the Viscosity–Temperature–Pressure Relationship of Lubricating Oils:
# all oils have the viscosity e^−9.67 Pa·s at the pressure −1/5.1e-9 Pa.
_LOG_POLE, _PER_MPA, _PA_S = 9.67, 5.1e-3, 1e6
# Largest logarithm of a relative viscosity: iterates on the way to a solution may go far beyond it.
_MOST = 50.0
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True)
class Oil:
    """An oil at the temperature of the film."""

    viscosity: float  #: μ₀ without pressure, MPa·s (1e-9 of it is 1 mPa·s)
    piezoviscosity: float = 0.0  #: α = d ln μ/dp without pressure, 1/MPa

    def relative_viscosity(self, pressure: Floats) -> Floats:
        """Return μ(p)/μ₀ at pressures p ≥ 0, MPa (Roelands 1966)."""
        if not self.piezoviscosity:
            return np.ones_like(pressure)
        log = math.log(self.viscosity * _PA_S) + _LOG_POLE
        exponent = self.piezoviscosity / (_PER_MPA * log)
        grown = log * ((1 + _PER_MPA * pressure) ** exponent - 1)
        return np.asarray(np.exp(np.minimum(grown, _MOST)))

    def generalised(self, pressure: Floats) -> tuple[Floats, Floats]:
        """Return q = ∫₀ᵖ μ₀/μ dp, MPa, and its derivative, at pressures p ≥ 0.

        The flow is in proportion to the gradient of q. A viscosity at the mean pressure of two cells has no
        such potential, and has two solutions where oil is trapped.
        """
        if not self.piezoviscosity:
            return pressure, np.ones_like(pressure)
        half = pressure / 2
        inner = 1 / self.relative_viscosity(half[..., None] * (1 + _PLACES))
        return half * (inner @ _WEIGHTS), 1 / self.relative_viscosity(pressure)
