"""Equilibrium of a body that flows in a few elements: plastic strain as initial strain of the elastic body.

The stiffness of the elastic body, factorised once, serves every increment: the forces of the plastic strain
act on it, and the displacement that they cause changes the plastic strain (initial stress method of
Zienkiewicz, Valliappan & King 1969). Anderson's acceleration (1965) makes that converge in few steps.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from fea.plastic.zone import Zone
from fea.solid.parity import Parity
from geometry.arrays import Floats, Mask

# Steps that Anderson's acceleration remembers, and the most steps of an increment.
_MEMORY, _MOST_STEPS = 12, 400
# Where the force out of balance has not halved in so many steps, there is no equilibrium.
_STALLED = 60
# Largest force out of balance, relative to what an element at yield exerts on the same node.
BALANCED = 3e-4
# A larger plastic strain is not small, so that nothing that follows from it holds.
_LARGEST_STRAIN = 0.1
# Solves for forces (n, k) of one parity, which must vanish where the mask (n,) is True.
Solver = tuple[Mask, Callable[[Floats], Floats]]


class NoEquilibriumError(Exception):
    """No stress within the yield condition is in equilibrium with the load, as far as the iteration finds."""


class ElasticBody:
    """Displacement of an elastic body in a zone under forces there.

    `solvers` by parity about y = 0: both for two halves, else the even one.
    """

    def __init__(self, zone: Zone, solvers: Mapping[Parity, Solver]) -> None:
        self._nodes, self._solvers = zone.nodes, dict(solvers)
        self.halves = len(self._solvers)

    def __call__(self, forces: Floats) -> Floats:
        """Displacement (n_halves, n_nodes, 3), mm, at the nodes of the zone under forces there, N."""
        return self.everywhere(forces)[:, self._nodes]

    def everywhere(self, forces: Floats) -> Floats:
        """Displacement (n_halves, n_all_nodes, 3) of the whole cell, mm, likewise."""
        if self.halves == 1:
            return self._solved(Parity.SYMMETRIC, forces[0])[None]
        even = self._solved(Parity.SYMMETRIC, (forces[0] + forces[1]) / 2)
        odd = self._solved(Parity.ANTISYMMETRIC, (forces[0] - forces[1]) / 2)
        return np.stack([even + odd, even - odd])

    def _solved(self, parity: Parity, forces: Floats) -> Floats:
        fixed, solve = self._solvers[parity]
        sides = np.zeros((len(fixed) // 3, 3))
        sides[self._nodes] = forces
        sides = np.where(fixed, 0.0, sides.ravel())
        return np.where(fixed, 0.0, solve(sides[:, None])[:, 0]).reshape(-1, 3)


@dataclass(frozen=True)
class FlowState:
    """Plastic strain of a zone, in equilibrium with an elastic state."""

    plastic: Floats  #: (n_elements, n_points, 6)
    forces: Floats  #: (n_halves, n_nodes, 3) that hold it, N
    moved: Floats  #: (n_halves, n_nodes, 3) displacement that these cause, mm
    unbalanced: float = 0.0  #: largest force out of balance, relative

    def repeated(self, before: "FlowState", after: "FlowState") -> "FlowState":
        """Return what follows on this state if it flows as from another one, `before`, to `after`."""
        forces = self.forces + (after.forces - before.forces)
        return replace(self, forces=forces, moved=self.moved + (after.moved - before.moved))


def at_rest(zone: Zone, halves: int) -> FlowState:
    """Return the state in which nothing has flowed."""
    nothing = np.zeros((halves, len(zone.nodes), 3))
    return FlowState(zone.virgin, nothing, nothing)


def increment(
    zone: Zone, body: ElasticBody, elastic: Floats, before: FlowState, guess: FlowState | None = None
) -> FlowState:
    """Let a zone flow until it is in equilibrium with what acts.

    `elastic` (n_halves, n_nodes, 3) is the `projected` displacement, mm, of the elastic body under what acts;
    `before` is the state before. The iteration begins with its forces, or those of a `guess`. Raises
    `NoEquilibriumError`: none is found.
    """
    return _balanced(
        zone, body, guess or before, lambda moved: zone.returned(elastic + moved, before.plastic)
    )


def projected(zone: Zone, body: ElasticBody, elastic: Floats) -> Floats:
    """Return a displacement (n_halves, n_nodes, 3), mm, of the elastic body, of projected volumetric strain.

    Only what exceeds first yield is, so that flow begins where the elastic stress reaches the yield strength;
    both parts are in equilibrium. Where the iteration does not converge, nothing is projected.
    """
    beyond = 1 - 1 / max(1.0, float(zone.usage(elastic, zone.virgin).max(initial=0.0)))
    if beyond == 0:
        return elastic
    try:
        found = _balanced(zone, body, at_rest(zone, body.halves), lambda _: zone.virgin, elastic)
    except NoEquilibriumError:
        return elastic
    return elastic + beyond * found.moved


def _balanced(
    zone: Zone,
    body: ElasticBody,
    start: FlowState,
    flow: Callable[[Floats], Floats],
    elastic: Floats | float = 0.0,
) -> FlowState:
    """Find the state in which forces balance plastic strain and projection; `flow` of a displacement."""
    forces, moved = start.forces, start.moved
    scale = nodal_force(zone)
    tried, missed = list[Floats](), list[Floats]()
    least, reached = np.inf, 0
    for step in range(_MOST_STEPS):
        plastic = flow(moved)
        error = zone.initial_forces(elastic + moved, plastic) - forces
        unbalanced = float((np.abs(error) / scale).max(initial=0.0))
        if unbalanced <= BALANCED:
            return FlowState(plastic, forces, moved, unbalanced)
        if unbalanced < least / 2:
            least, reached = unbalanced, step
        if step - reached > _STALLED or not np.abs(plastic - start.plastic).max() < _LARGEST_STRAIN:
            break
        tried, missed = [*tried, forces][-_MEMORY:], [*missed, error][-_MEMORY:]
        forces = _accelerated(tried, missed)
        moved = body(forces)
    raise NoEquilibriumError


def _accelerated(tried: list[Floats], missed: list[Floats]) -> Floats:
    """Return the next forces: of those tried, the combination whose error is least, and that error."""
    if len(tried) == 1:
        return tried[-1] + missed[-1]
    steps, errors = (
        np.stack([(new - old).ravel() for old, new in pairwise(kept)], axis=1) for kept in (tried, missed)
    )
    weights = np.linalg.lstsq(errors, missed[-1].ravel(), rcond=1e-10)[0]
    step = missed[-1].ravel() - (steps + errors) @ weights
    return np.asarray(tried[-1] + step.reshape(tried[-1].shape))


def nodal_force(zone: Zone) -> Floats:
    """Force (n_nodes, 1), N, at the nodes of the zone at yield: σ_y ∫ |∂N/∂x| dV, the largest of any axis."""
    size = np.abs(zone.gradients) * np.repeat(zone.volumes, 3, axis=1)[..., None]
    of_element = (zone.strength[..., None] * size).reshape(len(size), -1, 3, size.shape[2]).sum(axis=1)
    found = np.zeros((len(zone.nodes), 1))
    np.maximum.at(found, zone.corners, of_element.max(axis=1)[..., None])
    return found
