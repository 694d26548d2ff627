"""A rod whose stresses are superposed, and the histories and factors of its places over a cycle."""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass

import numpy as np

from fea.analysis.cycle.basis import Basis
from fea.analysis.cycle.screened import product, superposed
from fea.analysis.cycle.unit_solutions import UnitSolutions
from fea.base.choices import Fatigue, Region
from fea.base.material import Material
from fea.judge.fatigue import fatigue_factor
from fea.judge.history import deviatoric
from fea.pins.model import UnitLoads, Weights
from fea.rod.meshed_rod import MeshedRod
from fea.rod.places import SurfaceRegions
from geometry.arrays import Floats, Ints, Mask, Reals
from loads.crank_cycle import CrankCycle


@dataclass(frozen=True)
class SpannedRod:
    """What is superposed, and what its stress is judged by."""

    mesh: MeshedRod
    materials: tuple[Material, ...]  #: one per part
    basis: Basis  #: what is superposed
    fatigue: Fatigue  #: the mean-stress correction
    masked: Mask  #: nodes of the cell near stress singularities, which do not count
    regions: SurfaceRegions  #: of the surface of the cell

    @property
    def loads(self) -> UnitLoads:
        """The unit loads that span every instant."""
        return self.basis.loads

    @property
    def units(self) -> UnitSolutions:
        """The unit solutions that are superposed."""
        return self.basis.units

    @property
    def counts(self) -> Mask:
        """Nodes of the cell that count; all nodes if none would be left."""
        return counting(self.masked)

    def weights(self, cycle: CrankCycle, angles: Floats) -> Weights:
        """Weights of the unit solutions at crank angles (n_instants,), rad."""
        return self.basis.weights(cycle.at(angles), cycle)


def counting(masked: Mask) -> Mask:
    """Nodes that count: those that are not masked; all nodes if none would be left."""
    return np.ones_like(masked) if masked.all() else ~masked


# Bytes of stress that are superposed at once.
_BYTES = 2**21


class PartRows:
    """A part's nodes, then their images across y = 0, as rows with stresses.

    `counts` (n,): which nodes of the part; by default those away from singular places. Attributes: `sides`:
    1 for the nodes, −1 for their images.
    """

    def __init__(self, rod: SpannedRod, number: int, counts: Mask | None = None) -> None:
        stress, self.sides = rod.units.parts[number], rod.units.sides
        if counts is None:
            counts = rod.counts[stress.nodes]
        if not counts.any():  # a part has a worst place
            counts[:] = True
        self._even, self._odd = deviatoric(stress.even[counts]), deviatoric(stress.odd[counts])
        self.material = rod.materials[number]
        self._criterion, self.regions = rod.fatigue, rod.regions.at(stress.nodes[counts])
        self._surface = np.tile(self.regions.factors(self.material), len(self.sides))
        points = rod.mesh.cell.points[stress.nodes[counts]]
        self.points = np.concatenate([points * [1, side, 1] for side in self.sides])

    def made_of(self, material: Material) -> "PartRows":
        """Return the same rows of another material, whose stresses under the unit loads are the same."""
        other = copy(self)
        other.material = material
        other._surface = np.tile(self.regions.factors(material), len(self.sides))  # noqa: SLF001
        return other

    def stress(self, weights: Weights, rows: Ints) -> Floats:
        """Stress (n, 6, n_instants) of some rows."""
        image, node = np.divmod(rows, len(self._even))
        side = np.asarray(self.sides)[image, None, None]
        return product(self._even[node], weights.even) + side * product(self._odd[node], weights.odd)

    def every(self, weights: Weights, nodes: slice = slice(None)) -> Floats:
        """Stress (n_rows, 6, n_instants) of every row, or of some nodes and then of their images."""
        stress = superposed(self._even[nodes], self._odd[nodes], self.sides, weights)
        return np.asarray(stress, np.float64)

    def measured(self, weights: Weights, measures: Callable[[Reals], Reals]) -> Floats:
        """Measures (m, n_instants, n_rows) of every row, given as (m, n, n_instants) of stress of some."""
        instants, sides, found = weights.even.shape[1], len(self.sides), []
        count = max(1, _BYTES // (48 * sides * instants))
        for start in range(0, len(self._even), count):
            of_some = measures(self.every(weights, slice(start, start + count))).swapaxes(1, 2)
            found.append(of_some.reshape(len(of_some), instants, sides, -1))
        return np.asarray(np.concatenate(found, axis=3).reshape(len(found[0]), instants, -1), float)

    def yielding_factor(self, highest: Floats, lowest: Floats) -> Floats:
        """Factors (n,) against yielding of extremes of the signed equivalent stress, without a cap.

        They are infinite in the lining of a bore, which does not end the rod: see `lining_factor`.
        """
        factors = self._yielding(highest, lowest)
        return np.full_like(factors, np.inf) if self.material.lining else factors

    def lining_factor(self, highest: Floats, lowest: Floats) -> Floats:
        """Factors (n,) against yielding as of `yielding_factor`, but of a lining alone."""
        factors = self._yielding(highest, lowest)
        return factors if self.material.lining else np.full_like(factors, np.inf)

    def _yielding(self, highest: Floats, lowest: Floats) -> Floats:
        largest = np.maximum(np.abs(highest), np.abs(lowest))
        return self.material.yield_strength / np.maximum(largest, np.finfo(float).tiny)

    def fatigue_factor(self, highest: Floats, lowest: Floats, rows: Ints) -> Floats:
        """Factors (n,) against fatigue of the extremes of the signed equivalent stress of some rows.

        They are infinite where the strengths are not known.
        """
        mean, amplitude = (highest + lowest) / 2, (highest - lowest) / 2
        factors = fatigue_factor(self._criterion, mean, amplitude, self.material, self._surface[rows])
        return np.full(len(mean), np.inf) if factors is None else factors

    def surface(self, rows: Ints) -> Floats:
        """Factors (n,) of the surface of some rows."""
        return np.asarray(self._surface[rows])

    def region(self, row: int) -> Region | None:
        """Return the region of the surface of a row; None inside the solid."""
        return self.regions.region(row % len(self._even), self.material)
