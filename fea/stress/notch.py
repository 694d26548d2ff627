"""Sharp and rounded V-notches: the exponents of the stress at the tip, and the peak at a small radius.

Near the tip of a sharp re-entrant corner the stress across it grows as r^(λ − 1) (Williams 1952, J. Appl.
Mech. 19, 526). Where the corner is rounded by a radius ρ, small against the section, the peak is that of the
same field with the tip moved into the notch (Creager & Paris 1967 for cracks; Filippi, Lazzarin & Tovo 2002,
Int. J. Solids Struct. 39, 4543, for V-notches).
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

# Rise of the peak of a rounded notch over the stress of the sharp one at the same distance r₀ from the tip,
# by the opening angle in degrees: ω̃₁ of Filippi, Lazzarin & Tovo 2002; 0 where there is no notch.
_OPENINGS = (0.0, 30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 180.0)
_RISES = (1.0, 1.034, 1.014, 0.970, 0.810, 0.570, 0.432, 0.0)
_RISE = PchipInterpolator(_OPENINGS, _RISES)


@dataclass(frozen=True)
class VNotch:
    """A re-entrant corner between two flat flanks.

    Attributes
    ----------
    opening
        Angle of the notch, outside the material, rad: 0 for a crack, π for a flat surface.
    """

    opening: float

    @property
    def half(self) -> float:
        """γ, half the angle of the material, rad."""
        return math.pi - self.opening / 2

    @cached_property
    def opens(self) -> float:
        """λ₁: under a load that opens it symmetrically the stress grows as r^(λ₁ − 1)."""
        return _root(self.half, 1.0)

    @cached_property
    def slides(self) -> float:
        """λ₂, of the antisymmetric field; above 1, where the stress is finite, for openings beyond 102.6°."""
        return _root(self.half, -1.0)

    @property
    def flank(self) -> float:
        """Stress along the flanks over that across the bisector at the same distance, symmetric field."""
        lam, gamma = self.opens, self.half
        chi = -(1 + lam) / (1 - lam) * math.cos((1 - lam) * gamma) / math.cos((1 + lam) * gamma)
        return float(4 * math.cos((1 - lam) * gamma) / (1 + lam + chi * (1 - lam)))

    @property
    def tip(self) -> float:
        """Distance r₀ of the field's origin from a rounded tip over the tip's radius (Neuber's hyperbola)."""
        q = 2 - self.opening / math.pi
        return (q - 1) / q

    @property
    def rounded(self) -> float:
        """Peak at a rounded tip over the stress across the bisector of the sharp notch, one radius away."""
        rise = float(_RISE(math.degrees(self.opening)))
        return float((1 + rise) * self.tip ** (self.opens - 1))


def _root(gamma: float, sign: float) -> float:
    """Least root λ ≥ ½ of sin 2λγ ± λ sin 2γ = 0 that is no rigid motion (λ = 1, where the sign is −)."""

    def equation(lam: float) -> float:
        value = math.sin(2 * lam * gamma) + sign * lam * math.sin(2 * gamma)
        return value if sign > 0 else value / (lam - 1)

    # The quotient is finite, but not defined, at λ = 1, which is not among these places.
    places = np.linspace(0.4999, 2.0003, 302)
    values = [equation(place) for place in places]
    at = next(k for k in range(301) if values[k] * values[k + 1] <= 0)
    return float(brentq(equation, places[at], places[at + 1]))
