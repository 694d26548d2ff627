"""The pressure of a pin as a Fourier series in the angle of the bore.

A pressure s(φ − ψ) centred on the direction ψ of the force is

    s(φ − ψ) = Σ c_n (cos nψ cos nφ + sin nψ sin nφ),    c_n = (1/π) ∫ s(φ) cos nφ dφ (c₀: half of it),

so that the harmonics cos nφ and sin nφ of two bores cover every direction. The half cosine has only n = 0, 1
and even terms, which decrease like 1/n². The truncated series has its largest error at the ends of the arc,
where the slope jumps; the missing terms alternate so fast there that their effect decays within a fraction of
the wall thickness. A table of directions, with the force split between two neighbours, would have its error
at the same place, but with one sign on either side, which makes the ring oval and affects the whole end.

On a bore of varying width that pressure alone would leave a resultant across the force. Then s(ψ)(a + b sin
ψ) is used, with ψ = φ − ψ₀ measured from the force: its second term is Σ d_n sin nψ.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from geometry.arrays import Floats, Ints
from loads.bearing import Arc

Wave = Callable[[Floats], Floats]

# Largest error of the series anywhere on the bore for a continuous pressure, relative to the peak pressure:
# equivalent to about 0.2 % of a rod's peak stress.
TOLERANCE = 1e-2
# Highest order: if the pressure jumps (a uniform arc), the series does not converge at the jump.
HIGHEST = 48
# Coefficients below this are rounding.
_NEGLIGIBLE = 1e-12
_SAMPLES = 1 << 12
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


@dataclass(frozen=True)
class Series:
    """The orders of a series that approximates a pressure.

    Attributes
    ----------
    orders
        (n_terms,) n, increasing, starting with 0 and 1.
    error
        Largest difference from the pressure, relative to its peak.
    """

    orders: Ints
    error: float


@cache
def series(arc: Arc, highest: int | None = None) -> Series:
    """Expand the pressure of an arc.

    Parameters
    ----------
    arc
        The pressure.
    highest
        Highest order; by default the lowest with an error below `TOLERANCE`, at most `HIGHEST`.
    """
    return _enough(arc, np.cos, 1.0) if highest is None else _truncated(arc, highest, np.cos)


@cache
def skewed(arc: Arc, share: float) -> Series:
    """Expand s(ψ) sin ψ, which has at most the weight `share`: a smaller weight needs fewer terms."""
    return _enough(arc, np.sin, share)


def coefficients(arc: Arc, orders: Ints) -> tuple[Floats, Floats]:
    """Return c_n of s(ψ) and d_n of s(ψ) sin ψ, each (n_terms,)."""
    return _coefficients(arc, orders, np.cos), _coefficients(arc, orders, np.sin)


def _enough(arc: Arc, wave: Wave, share: float) -> Series:
    candidates = (_truncated(arc, order, wave) for order in range(8, HIGHEST + 1, 4))
    fit = (found for found in candidates if share * found.error <= TOLERANCE)
    return next(fit, _truncated(arc, HIGHEST, wave))


def _truncated(arc: Arc, highest: int, wave: Wave) -> Series:
    psi = 2 * math.pi * (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    orders = np.arange(highest + 1)
    found = _coefficients(arc, orders, wave)
    used = (np.abs(found) > _NEGLIGIBLE) | (orders <= 1)
    sums = wave(np.multiply.outer(psi, orders[used])) @ found[used]
    return Series(orders[used], float(np.abs(sums - _pressure(arc, psi, wave)).max()))


def _coefficients(arc: Arc, orders: Ints, wave: Wave) -> Floats:
    """Coefficients by Gauss quadrature over the arc, within which the pressure is smooth."""
    half = arc.angle / 2
    psi = _PLACES * half
    integrals = half * wave(np.multiply.outer(orders, psi)) @ (_WEIGHTS * _pressure(arc, psi, wave))
    return np.asarray(integrals / np.where(orders == 0, 2 * math.pi, math.pi))


def _pressure(arc: Arc, psi: Floats, wave: Wave) -> Floats:
    """The pressure function that is even about the force (cosine), or odd (sine)."""
    return arc(psi) if wave is np.cos else arc(psi) * np.sin(psi)
