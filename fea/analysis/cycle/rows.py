"""A rod whose stresses are superposed: those of its places over cycles, and bounds that need few instants."""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fea.analysis.cycle.basis import Basis
from fea.analysis.cycle.screened import Path, norms, path, product, superposed
from fea.analysis.cycle.unit_solutions import UnitSolutions
from fea.base.choices import Fatigue, Region
from fea.base.material import Material
from fea.judge.fatigue import fatigue_factor
from fea.judge.history import deviator_norm, deviatoric
from fea.pins.model import UnitLoads, Weights
from fea.rod.meshed_rod import MeshedRod
from fea.rod.surface_regions import SurfaceRegions
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


# Number of nodes for which bounds are computed at once, and bytes of stress that are superposed at once.
_NODES, _BYTES = 2000, 2**21
# Relative allowance for rounding in the bounds, in single precision.
ROUNDING = 1e-6
# That for what rounding takes from differences of sums of squares.
_CANCELLED = 1e-6
# Number of sectors of the cycle with bounds of their own.
_SECTORS = 24


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
        self.joint, self._balanced = stress.joint, rod.loads.balanced
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

    @cached_property
    def _norms(self) -> list[Reals]:
        units = zip((self._even, self._odd), self.joint, strict=True)
        return [norms(unit, joint)[0] for unit, joint in units]

    @cached_property
    def of_errors(self) -> tuple[Floats, Floats]:
        """Largest von Mises and mean stress (n_rows,) that errors of weights of unit length can cause."""
        balanced = self._balanced()
        largest, pressed = np.zeros((2, len(self.sides), len(self._even)))
        if balanced is not None:
            units = [(q, z.astype(q.dtype)) for q, z in zip((self._even, self._odd), balanced, strict=True)]
            for start in range(0, len(self._even), _NODES):
                rows = slice(start, start + _NODES)
                near = [(q[rows, :, : len(z)], z) for q, z in units]
                every = sum(q @ q.swapaxes(1, 2) for q, _ in near)
                even, odd = (q @ z for q, z in near)
                for number, side in enumerate(self.sides):
                    free = even + side * odd
                    squares = every - free @ free.swapaxes(1, 2)
                    rounding = _CANCELLED * np.trace(every, axis1=1, axis2=2)
                    largest[number, rows] = np.linalg.eigvalsh(squares[:, :5, :5])[:, -1] + rounding
                    pressed[number, rows] = squares[:, 5, 5] + rounding
        return np.sqrt(largest.ravel()), np.sqrt(pressed.ravel())

    def stress(self, weights: Weights, rows: Ints) -> Floats:
        """Stress (n, 6, n_instants) of some rows."""
        image, node = np.divmod(rows, len(self._even))
        side = np.asarray(self.sides)[image, None, None]
        return product(self._even[node], weights.even) + side * product(self._odd[node], weights.odd)

    def errors(self, rows: Ints | slice, error: Floats, most: Floats) -> Floats:
        """Bounds (2, n, n_instants) of the errors of von Mises and mean stress of some rows, at `most` (n,).

        `error` (n_instants,): that of the weights.
        """
        errors = (of[rows][:, None] * error for of in self.of_errors)
        return np.stack([np.minimum(bound, most[:, None]) for bound in errors])

    def every(self, weights: Weights, nodes: slice = slice(None)) -> Floats:
        """Stress (n_rows, 6, n_instants) of every row, or of some nodes and then of their images."""
        stress = superposed(self._even[nodes], self._odd[nodes], self.sides, weights)
        return np.asarray(stress, np.float64)

    def strayed(self, strays: Weights, rows: Ints | None = None) -> Floats:
        """Upper bound (n, n_chords) of the von Mises stress of rows for weights of at most these sizes."""
        even, odd = self._norms
        node = slice(None) if rows is None else rows % len(self._even)
        bound = even[node] @ strays.even + odd[node] @ strays.odd
        return np.concatenate([bound] * len(self.sides)) if rows is None else bound

    def bound(self, weights: Weights) -> Reals:
        """Upper bound of the largest von Mises stress (n_rows, n_sectors) over each sector."""
        along = path(weights, self.joint)
        strays, ends, first = self.strayed(along.strays), along.at_ends(), first_chords(along)
        (at_ends,) = self.measured(ends, lambda stress: deviator_norm(stress)[None])
        chords = np.maximum(at_ends[:-1], at_ends[1:]).T + strays
        return np.asarray((1 + ROUNDING) * np.maximum.reduceat(chords, first, axis=1), np.float32)

    def measured(self, weights: Weights, measures: Callable[[Reals], Reals]) -> Floats:
        """Measures (m, n_instants, n_rows) of every row, given as (m, n, n_instants) of stress of some."""
        instants, sides, found = weights.even.shape[1], len(self.sides), []
        count = max(1, _BYTES // (48 * sides * instants))
        for start in range(0, len(self._even), count):
            of_some = measures(self.every(weights, slice(start, start + count))).swapaxes(1, 2)
            found.append(of_some.reshape(len(of_some), instants, sides, -1))
        return np.asarray(np.concatenate(found, axis=3).reshape(len(found[0]), instants, -1), float)

    def yielding_bound(self, largest: Floats) -> Floats:
        """Lower bound of the (uncapped) factors against yielding for stresses of at most `largest`.

        They are infinite in the lining of a bore, which does not end the rod: see `lining_factor`.
        """
        return np.full_like(largest, np.inf) if self.material.lining else self._yielding(largest)

    def lining_factor(self, highest: Floats, lowest: Floats) -> Floats:
        """Factors (n,) against yielding as of `yielding_factor`, but of a lining alone."""
        largest = np.maximum(np.abs(highest), np.abs(lowest))
        return self._yielding(largest) if self.material.lining else np.full_like(largest, np.inf)

    def _yielding(self, largest: Floats) -> Floats:
        return self.material.yield_strength / np.maximum(largest, np.finfo(float).tiny)

    def yielding_factor(self, highest: Floats, lowest: Floats, rows: Ints) -> Floats:  # noqa: ARG002
        """Factors (n,) against yielding of the extremes of the signed equivalent stress of some rows."""
        return self.yielding_bound(np.maximum(np.abs(highest), np.abs(lowest)))

    def fatigue_factor(self, highest: Floats, lowest: Floats, rows: Ints) -> Floats:
        """Factors (n,) against fatigue of the extremes of the signed equivalent stress of some rows."""
        return self._fatigue((highest + lowest) / 2, (highest - lowest) / 2, self._surface[rows])

    def _fatigue(self, mean: Floats, amplitude: Floats, surface: Floats) -> Floats:
        """Factors against fatigue; infinite if the strengths are not known."""
        factors = fatigue_factor(self._criterion, mean, amplitude, self.material, surface)
        return np.full(len(mean), np.inf) if factors is None else factors

    def fatigue_bound(self, largest: Floats) -> Floats:
        """Lower bound (n_rows,) of the fatigue factors where the von Mises stress is at most `largest`."""
        none, surface = np.zeros_like(largest), self._surface
        return np.minimum(self._fatigue(none, largest, surface), self._fatigue(largest, none, surface))

    def surface(self, rows: Ints) -> Floats:
        """Factors (n,) of the surface of some rows."""
        return np.asarray(self._surface[rows])

    def region(self, row: int) -> Region | None:
        """Return the region of the surface of a row; None inside the solid."""
        return self.regions.region(row % len(self._even), self.material)


def first_chords(along: Path) -> Ints:
    """Numbers of the chords with which sectors of a path begin."""
    count = len(along.ends) - 1
    return np.arange(0, count, -(-count // _SECTORS))
