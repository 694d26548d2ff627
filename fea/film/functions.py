"""Smooth functions on a bore that span film pressures and the displacements they cause, and their loads."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fea.film.grid import FilmGrid
from fea.solid.bore import BoreFacets, BoreLoad, radial_loads, radial_traction
from fea.solid.parity import ParityPair
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
        """_Harmonic and degree (n_even, 2) of the cosines; sines have those with a harmonic above 0."""
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


class FilmPressure:
    """Smooth functions of the pressure on a bore as loads on the cell (n_nodes).

    Attributes: `counts`: how many of the functions are even about y = 0, and odd.
    """

    def __init__(self, facets: BoreFacets, functions: BoreFunctions, n_nodes: int) -> None:
        self.facets, self.functions, self._n_nodes = facets, functions, n_nodes
        n_even = len(functions.terms)
        self.counts = n_even, functions.count - n_even

    def loads(self, parity: int, sums: Floats | None = None) -> Iterator[tuple[Floats, Floats]]:
        """Forces and traction (n_nodes, 3) on the cell of each even function, or of each odd one.

        `sums`: weights (k, n) of sums of them, whose forces and traction these are then.
        """
        facets, z = self.facets, self.facets.corners[..., 2]
        there, nodal = self.functions.at(facets.angle, z @ facets.shape_values.T)[parity], self._nodal[parity]
        if sums is not None:
            there, nodal = (np.tensordot(sums, each, axes=1) for each in (there, nodal))
        return radial_loads(facets, self._n_nodes, there, nodal)

    @cached_property
    def forces(self) -> list[list[Floats]]:
        """Nodal forces (n_nodes, 3) on the cell of the even functions, and of the odd ones."""
        return [[forces for forces, _ in self.loads(parity)] for parity in range(2)]

    @cached_property
    def _nodal(self) -> tuple[Floats, Floats]:
        return self.functions.at(self.facets.node_angle, self.facets.corners[..., 2])

    def traction(self, weights: Floats) -> Floats:
        """Traction (n_nodes, 3, k) on the cell of sums of the functions, by weights (n_functions, k)."""
        pressures = np.tensordot(weights.T, np.concatenate(self._nodal), axes=1)
        each = [radial_traction(self.facets, self._n_nodes, pressure) for pressure in pressures]
        return np.stack(each, axis=-1)

    def pressed(self, weights: Floats) -> tuple[BoreLoad, ParityPair]:
        """Load and pressure (n_nodes,) on the cell of one sum (n_functions,)."""
        parts, cut = np.split(weights, self.counts[:1]), self.facets.cut_y
        loads = [load for parity, part in enumerate(parts) for load in self.loads(parity, part[None])]
        forces, traction = zip(*loads, strict=True)
        along, nodes = np.zeros((self._n_nodes, 3)), self.facets.nodes
        along[nodes, 0], along[nodes, 1] = np.cos(self.facets.node_angle), np.sin(self.facets.node_angle)
        pressure = np.einsum("ni,kni->kn", along, traction)
        load = BoreLoad(ParityPair.of(*forces, cut=cut), ParityPair.of(*traction, cut=cut), 1.0)
        return load, ParityPair.of(*pressure, cut=cut)

    @cached_property
    def resultants(self) -> Floats:
        """Force (2, n_functions) on the whole rod's mesh of each function, N."""
        facets = self.facets
        both = self.functions.at(facets.angle, facets.corners[..., 2] @ facets.shape_values.T)
        return np.concatenate(facets.resultants(*both), axis=1)
