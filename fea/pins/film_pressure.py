"""Pressure of an oil film on its bore: sums of the film's smooth functions."""

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from fea.film.functions import BoreFunctions
from fea.solid.bore import BoreFacets, BoreLoad, radial_loads, radial_traction
from fea.solid.parity import Split
from geometry.arrays import Floats


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

    def pressed(self, weights: Floats) -> tuple[BoreLoad, Split]:
        """Load and pressure (n_nodes,) on the cell of one sum (n_functions,)."""
        parts, cut = np.split(weights, self.counts[:1]), self.facets.cut_y
        loads = [load for parity, part in enumerate(parts) for load in self.loads(parity, part[None])]
        forces, traction = zip(*loads, strict=True)
        along, nodes = np.zeros((self._n_nodes, 3)), self.facets.nodes
        along[nodes, 0], along[nodes, 1] = np.cos(self.facets.node_angle), np.sin(self.facets.node_angle)
        pressure = np.einsum("ni,kni->kn", along, traction)
        load = BoreLoad(Split.of(*forces, cut=cut), Split.of(*traction, cut=cut), 1.0)
        return load, Split.of(*pressure, cut=cut)

    @cached_property
    def resultants(self) -> Floats:
        """Force (2, n_functions) on the whole rod's mesh of each function, N."""
        facets = self.facets
        both = self.functions.at(facets.angle, facets.corners[..., 2] @ facets.shape_values.T)
        return np.concatenate(facets.resultants(*both), axis=1)
