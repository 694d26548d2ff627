"""Fretting: what rubs at the places where parts touch, over a closed cycle of loads.

From slip δ and shear τ follow, by Ruiz, Boddington & Chen 1984 (Exp. Mech. 24, 208), the work τδ, and with
the tensile stress σ_T along the surface σ_T τδ. Definitions vary; here δ is the range of slip over the cycle,
and τ and σ_T are of one instant, that of the largest product. Where a place slips, the shear is what friction
can carry: a cycle costs ∮ μ p |dδ| per area.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components, dijkstra

from fea.contact.assembled import Assembled
from fea.contact.friction_system import ContactState
from geometry.arrays import Floats, Ints, Mask
from mesh.tetmesh import FACET_EDGES

# Directions in which the extent of a path is measured: the longest is found to 0.1 %.
_DIRECTIONS = 36
# Slip that is none, mm, and relative to the largest: what rounding leaves where friction holds.
_NO_SLIP, _ROUNDING = 1e-9, 1e-6


@dataclass(frozen=True)
class Rubbing:
    """Slip, shear and pressure of k places at n instants, from the beginning of a cycle to its end."""

    slip: Floats  #: (k, 2, n) of one side over the other, along two tangents, mm
    shear: Floats  #: (k, n) size of the shear stress, MPa
    pressure: Floats  #: (k, n) MPa; 0 where the parts have parted
    friction: float  #: coefficient μ

    @classmethod
    def of(
        cls, assembled: Assembled, states: Sequence[ContactState], more: Floats | float = 0.0
    ) -> "Rubbing":
        """Gather it at `assembled.vertices`, from states that follow each other.

        `more` (n_J, n): what is to be added to their gaps: see `FrictionCycle.continued`.
        """
        vertices, tightened = assembled.vertices, assembled.tightened.gap
        some = vertices.shear >= 0
        gaps = np.stack([state.gap - tightened for state in states], axis=1) + more
        slip = [assembled.slipped(gap) for gap in gaps.T]
        shear = [np.hypot(*np.where(some, state.values[vertices.shear], 0.0).T) for state in states]
        opened = [state.guess.opened[: len(some)] for state in states]
        pressed = [np.maximum(state.values[vertices.normal], 0.0) for state in states]
        pressure = np.where(opened, 0.0, pressed).T
        friction = float(assembled.system.places.friction[: len(some)].max(initial=0.0))
        held = np.where(pressure > 0, np.transpose(shear), 0.0)
        return cls(np.stack(slip, axis=-1), held, pressure, friction)

    @cached_property
    def range(self) -> Floats:
        """Largest distance (k,) between two places of the path of slip while the parts touch, mm."""
        found = extent(self.slip, self.pressure > 0)
        return np.where(found > max(_NO_SLIP, _ROUNDING * found.max(initial=0.0)), found, 0.0)

    @property
    def creep(self) -> Floats:
        """Slip (k,) that is left after the cycle, mm: one that has settled leaves none."""
        return np.asarray(np.linalg.norm(self.slip[..., -1] - self.slip[..., 0], axis=1))

    @cached_property
    def energy(self) -> Floats:
        """Energy (k,) that a cycle costs per area, N/mm, which is mJ/mm²."""
        moved = np.linalg.norm(np.diff(self.slip, axis=2), axis=1)
        between = (self.pressure[:, 1:] + self.pressure[:, :-1]) / 2
        pressed = np.minimum(self.pressure[:, 1:], self.pressure[:, :-1]) > 0  # not where it is open
        spent = self.friction * (between * np.where(pressed, moved, 0.0)).sum(axis=1)
        return np.where(self.range > 0, spent, 0.0)

    @cached_property
    def work(self) -> Floats:
        """Ruiz's first parameter τδ (k, n) at each instant, N/mm."""
        return np.asarray(self.shear * self.range[:, None])


def extent(path: Floats, counts: Mask) -> Floats:
    """Largest distance (k,) between two places of plane paths (k, 2, n), where they count, (k, n)."""
    angle = np.arange(_DIRECTIONS) * np.pi / _DIRECTIONS
    found = np.zeros(len(path))
    for direction in np.stack([np.cos(angle), np.sin(angle)], axis=1):
        along = np.einsum("d,kdn->kn", direction, path)
        ends = np.where(counts, along, -np.inf).max(axis=1), np.where(counts, along, np.inf).min(axis=1)
        found = np.maximum(found, ends[0] - ends[1])
    return found


def facets_across(slips: Mask, facets: Ints) -> Ints:
    """Facets (k,) that span the zone of slip around each place; 0 where it sticks.

    They are counted along the edges of the facets (m, 3), from what sticks to the farthest place of the zone;
    where nothing of a surface sticks, from one place to the farthest. `slips` (k,): which places slip.
    """
    ends = facets[:, FACET_EDGES].reshape(-1, 2).T
    graph = sparse.csr_array((np.ones(ends.shape[1]), tuple(ends)), shape=(len(slips), len(slips)))
    sticks, across = np.flatnonzero(~slips), np.zeros(len(slips), dtype=np.int64)
    steps = np.full(len(slips), np.inf)
    if len(sticks):
        steps = dijkstra(graph, directed=False, indices=sticks, unweighted=True, min_only=True)
    rows = np.flatnonzero(slips)
    count, zone = connected_components(graph[rows][:, rows], directed=False)
    for number in range(count):
        own = rows[zone == number]
        far = steps[own]
        if np.isinf(far).all():
            far = dijkstra(graph, directed=False, indices=own[0], unweighted=True)[own]
        across[own] = int(far.max())
    return across
