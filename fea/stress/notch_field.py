"""The stress near a sharp V-notch, fitted to the stress along its flanks; the peak at a fillet of its tip."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from fea.stress.notch import VNotch
from geometry.arrays import Floats

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
    """The singular stress at a sharp notch.

    Attributes
    ----------
    notch
        Its angle.
    opening, sliding
        Coefficients of the stress along the flanks: the mean of both flanks is opening · r^(λ₁ − 1), half
        their difference sliding · r^(λ₂ − 1), MPa with r in mm.
    longest
        The fit is of the stress up to this distance, mm, and a fillet may have it as its radius.
    """

    notch: VNotch
    opening: float
    sliding: float
    longest: float

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
    """Fit the field to the stress (n,) across the edge along both flanks; None where that is not possible.

    Parameters
    ----------
    notch
        Its angle.
    distance
        (n,) from the edge, mm.
    one, other
        (n,) on either flank, MPa.
    """
    if notch.opening < LEAST_OPENING or len(distance) < 3:
        return None
    first = notch.opens - 1, notch.slides - 1
    coefficients = [
        np.linalg.lstsq(np.stack([distance**power, distance**following], axis=1), stress, rcond=None)[0][0]
        for power, following, stress in zip(first, _NEXT, ((one + other) / 2, (one - other) / 2), strict=True)
    ]
    return NotchField(notch, float(coefficients[0]), float(coefficients[1]), float(distance.max()))
