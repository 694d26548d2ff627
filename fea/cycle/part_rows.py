"""Stress of the nodes of a part and of their images over a cycle, and bounds on it (`fea.cycle.search`)."""

import numpy as np

from fea.assess.deviatoric import deviator_norm, deviatoric
from fea.assess.fatigue import fatigue_factor
from fea.choices import Region
from fea.cycle.path import Path, norms, path
from fea.cycle.screened import Block, product, superposed
from fea.cycle.superposition import CycleAnalysis
from fea.cycle.unit_loads import Weights
from geometry.arrays import Floats, Ints

# Number of nodes for which bounds are computed together.
_NODES = 2000
# Relative allowance for rounding in the bounds.
_ROUNDING = 1e-9


class PartRows:
    """The nodes of a part, then their images across y = 0: rows, with their stresses and bounds on them.

    Nodes near a singular place are left out.
    """

    def __init__(self, analysis: CycleAnalysis, number: int) -> None:
        own, self._sides = analysis.units.parts[number], analysis.units.sides
        counts = analysis.counts[own.nodes]
        if not counts.any():  # a part has a worst place
            counts[:] = True
        self._even, self._odd = deviatoric(own.even[counts]), deviatoric(own.odd[counts])
        self._together = own.together
        self._norms = [
            norms(units, together)[0]
            for units, together in zip((self._even, self._odd), own.together, strict=True)
        ]
        self.material = analysis.materials[number]
        self._criterion, self.regions = analysis.fatigue, analysis.regions.at(own.nodes[counts])
        self._surface = np.tile(self.regions.factors(self.material), len(self._sides))
        points = analysis.mesh.cell.points[own.nodes[counts]]
        self.points = np.concatenate([points * [1, side, 1] for side in self._sides])

    def stress(self, weights: Weights, rows: Ints) -> Floats:
        """Stress (n, 6, n_instants) of some rows."""
        image, node = np.divmod(rows, len(self._even))
        side = np.asarray(self._sides)[image, None, None]
        return product(self._even[node], weights.even) + side * product(self._odd[node], weights.odd)

    def block(self, along: Path, rows: Ints) -> Block:
        """Return some rows over a path."""
        image, node = np.divmod(rows, len(self._even))
        side = np.asarray(self._sides)[image, None, None]
        return Block(self._even[node], side * self._odd[node], along, (1,), principals=False)

    def every(self, weights: Weights) -> Floats:
        """Stress (n_rows, 6, n_instants) of every row."""
        return np.asarray(superposed(self._even, self._odd, self._sides, weights), np.float64)

    def strayed(self, strays: Weights) -> Floats:
        """Upper bound (n_rows, n) of the von Mises stress for weights of at most these sizes."""
        even, odd = (norm @ away for norm, away in zip(self._norms, strays, strict=True))
        return np.concatenate([even + odd] * len(self._sides))

    def bound(self, weights: Weights) -> Floats:
        """Upper bound of the largest von Mises stress (n_rows,) over the instants."""
        along = path(weights, self._together)
        strays, ends = self.strayed(along.strays), along.at_ends()
        largest = np.empty(len(self.points))
        for start in range(0, len(largest), _NODES):
            rows = np.arange(start, min(start + _NODES, len(largest)))
            at_ends = deviator_norm(self.stress(ends, rows))
            chords = np.maximum(at_ends[:, :-1], at_ends[:, 1:]) + strays[rows]
            largest[rows] = chords.max(axis=1)
        return largest * (1 + _ROUNDING)

    def yielding_bound(self, largest: Floats) -> Floats:
        """Lower bound of the (uncapped) factors against yielding for stresses of at most `largest`."""
        return self.material.yield_strength / np.maximum(largest, np.finfo(float).tiny)

    def yielding_factor(self, highest: Floats, lowest: Floats, rows: Ints) -> Floats:  # noqa: ARG002
        """Factors (n,) against yielding of the extremes of the signed equivalent stress of some rows."""
        return self.yielding_bound(np.maximum(np.abs(highest), np.abs(lowest)))

    def fatigue_factor(self, highest: Floats, lowest: Floats, rows: Ints) -> Floats:
        """Factors (n,) against fatigue of the extremes of the signed equivalent stress of some rows."""
        return self._fatigue((highest + lowest) / 2, (highest - lowest) / 2, self._surface[rows])

    def _fatigue(self, mean: Floats, amplitude: Floats, surface: Floats) -> Floats:
        """Factors against fatigue; infinite if the strengths are not known."""
        found = fatigue_factor(self._criterion, mean, amplitude, self.material, surface)
        return np.full(len(mean), np.inf) if found is None else found

    def fatigue_bound(self, largest: Floats) -> Floats:
        """Lower bound (n_rows,) of the fatigue factors where the von Mises stress is at most `largest`."""
        none, surface = np.zeros_like(largest), self._surface
        return np.minimum(self._fatigue(none, largest, surface), self._fatigue(largest, none, surface))

    def surface(self, row: int) -> tuple[float, Region | None]:
        """Return the factor of the surface of a row, and its region; None inside the solid."""
        node = row % len(self._even)
        return float(self._surface[row]), self.regions.region(node, self.material)
