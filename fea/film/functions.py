"""Smooth functions on a bore that span film pressures and the displacements they cause."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fea.film.grid import FilmGrid
from geometry.arrays import Floats, Ints

# Highest harmonic around the bore for each even degree along the width: those left out are short waves, which
# hardly yield. Of the big end of leon-2001 at 8000 rpm, more of them change the highest pressure by 4 to 12 %
# and the smallest gap by 3 %; without degree 6 and with half of degree 4, the pressure is 60 % higher.
_HIGHEST = {0: 14, 2: 10, 4: 8, 6: 6}
_ODD = {1: 12, 3: 9, 5: 7}  # of the odd degrees, likewise
# Sub-intervals' points for the means over the width of a cell.
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True)
class BoreFunctions:
    """cos nφ (even about y = 0, first), sin nφ times Legendre polynomials; ∫ φᵢ φⱼ dA = δᵢⱼ, 1/mm."""

    radius: float  #: mm
    width: float  #: mm
    mirrored: bool = True  #: about z = 0; otherwise odd Legendre polynomials belong to them, too

    @cached_property
    def terms(self) -> Ints:
        """Harmonic and degree (n_even, 2) of the cosines; sines have those with a harmonic above 0."""
        every = _HIGHEST if self.mirrored else _HIGHEST | _ODD
        return np.array([(n, m) for m, highest in every.items() for n in range(highest + 1)])

    @property
    def count(self) -> int:
        """Number of functions."""
        return len(self.terms) + int((self.terms[:, 0] > 0).sum())

    @cached_property
    def translations(self) -> Ints:
        """Numbers (2,) of cos φ and sin φ, constant over the width, which move the bore as a whole."""
        return self._numbers(1, 0)

    @cached_property
    def rigid(self) -> Ints:
        """Numbers of the translations and, without mirror plane, of cos φ and sin φ times z: the tilts."""
        return np.concatenate([self.translations, *([] if self.mirrored else [self._numbers(1, 1)])])

    @property
    def oval(self) -> int:
        """Number of cos 2φ, constant over the width."""
        return int(self._numbers(2, 0)[0])

    def _numbers(self, n: int, m: int) -> Ints:
        """Numbers (2,) of the cosine and the sine of a term."""
        (even,) = np.flatnonzero((self.terms == [n, m]).all(axis=1))
        return np.array([even, len(self.terms) + np.count_nonzero(self.terms[:even, 0])])

    @cached_property
    def scales(self) -> Floats:
        """Factors (n_even,) that give the products their unit integral, 1/mm."""
        n, m = self.terms.T
        square = self.radius * np.where(n > 0, math.pi, 2 * math.pi) * self.width / (2 * m + 1)
        return np.asarray(1 / np.sqrt(square))

    @cached_property
    def waves(self) -> Floats:
        """Wave numbers (count,), 1/mm, along the width those of the ends, where a polynomial is steepest."""
        n, m = np.concatenate([self.terms, self.terms[self.terms[:, 0] > 0]]).T
        return np.asarray(np.hypot(n / self.radius, 2 * m * (m + 1) / (3 * self.width)))

    @cached_property
    def widening(self) -> Floats:
        """Weights (count,) of a displacement of 1 mm all over the bore, mm."""
        weights = np.zeros(self.count)
        (even,) = np.flatnonzero((self.terms == [0, 0]).all(axis=1))
        weights[even] = 1 / self.scales[even]
        return weights

    def _along(self, z: Floats) -> Floats:
        """Polynomials (n_even, …) at places along the width from its middle, scaled."""
        every = np.eye(self.terms[:, 1].max() + 1)[self.terms[:, 1]]
        values = np.polynomial.legendre.legval(2 * z / self.width, every.T)
        return np.asarray(values * self.scales.reshape(-1, *(1,) * z.ndim))

    def at(self, angle: Floats, z: Floats) -> tuple[Floats, Floats]:
        """Even (n_even, …) and odd (n_odd, …) functions at places (…)."""
        along, turned = self._along(z), np.multiply.outer(self.terms[:, 0], angle)
        turning = self.terms[:, 0] > 0
        return along * np.cos(turned), along[turning] * np.sin(turned[turning])

    def means(self, grid: FilmGrid) -> Floats:
        """Means (n_angle, n_width, count) over the cells of a grid."""
        n = self.terms[:, 0]
        along = self._along(grid.z[:, None] + grid.dz[:, None] / 2 * _PLACES) @ _WEIGHTS / 2
        along = along * np.sinc(n / grid.n_angle)[:, None]
        turned = np.multiply.outer(grid.angle, n)
        even = np.cos(turned)[:, None] * along.T
        odd = (np.sin(turned)[:, None] * along.T)[..., n > 0]
        return np.concatenate([even, odd], axis=-1)
