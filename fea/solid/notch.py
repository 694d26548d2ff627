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

from geometry.arrays import Floats

# Rise of the peak of a rounded notch over the stress of the sharp one at the same distance r₀ from the tip,
# by the opening angle in degrees: ω̃₁ of Filippi, Lazzarin & Tovo 2002; 0 where there is no notch.
_OPENINGS = (0.0, 30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 180.0)
_RISES = (1.0, 1.034, 1.014, 0.970, 0.810, 0.570, 0.432, 0.0)
_RISE = PchipInterpolator(_OPENINGS, _RISES)


@dataclass(frozen=True)
class VNotch:
    """A re-entrant corner between two flat flanks."""

    opening: float  #: angle of the notch, outside the material, rad: 0 for a crack, π for a flat surface

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
    def rounded(self) -> float:
        """Peak at a rounded tip over the stress across the bisector of the sharp notch, one radius away."""
        rise = float(_RISE(math.degrees(self.opening)))
        q = 2 - self.opening / math.pi
        tip = (q - 1) / q  # distance r₀ of the field's origin from it over its radius (Neuber's hyperbola)
        return float((1 + rise) * tip ** (self.opens - 1))


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


# Flanks of a narrower notch hardly carry stress, so that nothing can be fitted to it.
LEAST_OPENING = math.radians(60.0)
# Powers of the distance from the tip of what is added to the singular fields: the next eigenvalues of a right
# angle are 1.63 (symmetric) and 2.30.
_NEXT = (0.63, 1.3)
# Share of the antisymmetric stress at the peak, which lies between the bisector, where there is none, and the
# flank: with it the peaks at fillets of 0.02 to 0.3 thicknesses, in plane shoulders of 90° to 135° in tension
# and bending, are between 10 % too low and 12 % too high.
_SLID = 0.7
# The smallest radius that is looked for, over the largest.
_SMALLEST = 1e-3


@dataclass(frozen=True)
class NotchField:
    """The singular stress at a sharp notch."""

    notch: VNotch
    #: opening, sliding: coefficients of the stress along the flanks: the mean of both flanks is opening ·
    #: r^(λ₁ − 1), half their difference sliding · r^(λ₂ − 1), MPa with r in mm
    opening: float
    sliding: float
    longest: float  #: distance up to which the stress is fitted, and largest radius of a fillet, mm

    @property
    def intensity(self) -> float:
        """K₁, MPa·mm^(1 − λ₁) (Gross & Mendelson 1972): √(2π) r^(1 − λ₁) times the stress on the bisector."""
        return math.sqrt(2 * math.pi) * self.opening / self.notch.flank

    def peak(self, radius: float) -> float:
        """Largest stress along a fillet of this radius, mm: MPa, of the sign of the opening field.

        The symmetric part is that of a rounded notch; of the antisymmetric one, which hardly changes with the
        distance, a share is taken from the flank of the sharp notch, one radius from the tip.
        """
        notch = self.notch
        opened = self.opening / notch.flank * notch.rounded * radius ** (notch.opens - 1)
        slid = _SLID * abs(self.sliding) * radius ** (notch.slides - 1)
        return float(opened + math.copysign(slid, opened))

    def radius(self, allowed: float) -> float | None:
        """Smallest fillet radius, mm, whose peak is at most `allowed`, MPa; None above `longest`."""

        def excess(radius: float) -> float:
            return abs(self.peak(radius)) - allowed

        if excess(self.longest) > 0:
            return None
        least = _SMALLEST * self.longest
        return least if excess(least) <= 0 else float(brentq(excess, least, self.longest))


def fitted(notch: VNotch, distance: Floats, one: Floats, other: Floats) -> NotchField | None:
    """Fit to stress (n,) across the edge on both flanks, MPa, at `distance` (n,), mm; None if impossible."""
    if notch.opening < LEAST_OPENING or len(distance) < 3:
        return None
    first = notch.opens - 1, notch.slides - 1
    coefficients = [
        np.linalg.lstsq(np.stack([distance**power, distance**following], axis=1), stress, rcond=None)[0][0]
        for power, following, stress in zip(first, _NEXT, ((one + other) / 2, (one - other) / 2), strict=True)
    ]
    return NotchField(notch, float(coefficients[0]), float(coefficients[1]), float(distance.max()))
