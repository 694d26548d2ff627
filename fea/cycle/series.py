"""The pressure of a pin as a cosine series in the bore's angle.

A pressure s(φ − ψ) centred on the direction ψ of the force is

    s(φ − ψ) = Σ c_n (cos nψ cos nφ + sin nψ sin nφ),    c_n = (1/π) ∫ s(φ) cos nφ dφ (c₀: half of it),

so that the harmonics cos nφ and sin nφ of two bores span every direction. The half cosine has only
n = 0, 1 and even terms, which fall like 1/n²: the series errs most at the arc's ends, where the slope
jumps, and what it leaves out there alternates so fast that it dies within a fraction of the wall.
A table of directions with the force split between two neighbours errs at the same place; but what it errs
by has one sign on either side and so makes the ring oval, which is felt in the whole end.
"""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt

from loads.bearing import Arc

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# Largest error of the series anywhere on the bore, in parts of the peak pressure, where the pressure is
# continuous: about 0.2 % of a rod's peak stress.
TOLERANCE = 1e-2
# Where the pressure jumps (a uniform arc) no series converges at the jump; this bounds the work.
HIGHEST = 48
# Coefficients below this are rounding.
_NEGLIGIBLE = 1e-12
_SAMPLES = 1 << 12
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


@dataclass(frozen=True)
class Series:
    """Cosine series of a relative pressure.

    Attributes
    ----------
    orders
        (n_terms,) n, increasing, beginning with 0 and 1.
    coefficients
        (n_terms,) c_n.
    error
        Largest difference from the pressure it stands for, in parts of the peak.
    """

    orders: Ints
    coefficients: Floats
    error: float

    def __call__(self, phi: npt.ArrayLike) -> Floats:
        """Relative pressure at angles φ (rad) from the force."""
        angles = np.multiply.outer(np.asarray(phi, dtype=np.float64), self.orders)
        return np.asarray(np.cos(angles) @ self.coefficients)


@cache
def series(arc: Arc, highest: int | None = None) -> Series:
    """Expand the pressure of an arc.

    Parameters
    ----------
    arc
        The pressure.
    highest
        Highest order; by default the least that keeps the error below `TOLERANCE`, at most `HIGHEST`.
    """
    if highest is not None:
        return _truncated(arc, highest)
    candidates = (_truncated(arc, order) for order in range(8, HIGHEST + 1, 4))
    return next((found for found in candidates if found.error <= TOLERANCE), _truncated(arc, HIGHEST))


def _truncated(arc: Arc, highest: int) -> Series:
    phi = 2 * math.pi * (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    pressure = arc(phi)
    orders = np.arange(highest + 1)
    coefficients = np.array([_coefficient(arc, int(n)) for n in orders])
    used = (np.abs(coefficients) > _NEGLIGIBLE) | (orders <= 1)
    found = Series(orders[used], coefficients[used], 0.0)
    return Series(found.orders, found.coefficients, float(np.abs(found(phi) - pressure).max()))


def _coefficient(arc: Arc, n: int) -> float:
    """c_n by Gauss's quadrature over the arc, inside which the pressure is smooth."""
    half = arc.angle / 2
    phi = _PLACES * half
    integral = half * float(_WEIGHTS @ (arc(phi) * np.cos(n * phi)))
    return integral / (math.pi if n else 2 * math.pi)
