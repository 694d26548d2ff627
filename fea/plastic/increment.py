"""Equilibrium of a body that flows in a few elements: plastic strain as initial strain of the elastic body.

The stiffness of the elastic body, factorised once, serves every increment: the forces of the plastic strain
act on it, and the displacement that they cause changes the plastic strain (initial stress method of
Zienkiewicz, Valliappan & King 1969). Anderson's acceleration (1965) makes that converge in few steps.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from fea.plastic.zone import Zone
from fea.solid.parity import Parity
from geometry.arrays import Floats, Ints, Mask

# Steps that Anderson's acceleration remembers, and the most steps of an increment.
_MEMORY, _MOST_STEPS = 12, 400
# Of the force out of balance, the share that may be left to the next step if that saves a solution, as long
# as the force halves within so many steps.
_LEFT, _QUICK = 0.5, 2
# Where the force out of balance has not halved in so many steps, there is no equilibrium.
_STALLED = 60
# Largest force out of balance, relative to what an element at yield exerts on the same node.
BALANCED = 1e-3
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
        self._nodes, self.halves = zone.nodes, len(solvers)
        self._sides = {parity: _Side(zone.nodes, *solver) for parity, solver in solvers.items()}
        self.scale = nodal_force(zone)  #: (n_nodes, 1), N
        self.steps = 0  #: of iterations so far

    def __call__(self, forces: Floats) -> Floats:
        """Displacement (n_halves, n_nodes, 3), mm, at the nodes of the zone under forces there, N."""
        return self.everywhere(forces)[:, self._nodes]

    def everywhere(self, forces: Floats) -> Floats:
        """Displacement (n_halves, n_all_nodes, 3) of the whole cell, mm, likewise."""
        return np.asarray(self._by_side(forces, lambda side, part: side.everywhere(part)[None])[0])

    def near(self, forces: Floats, missing: float) -> tuple[Floats, Floats]:
        """Return forces near given ones and the displacement that they cause, each (n_halves, n_nodes, 3).

        Forces that were solved for before are combined, if at no node more than `missing` is left, relative
        to what an element at yield exerts there. Else the given forces are solved for.
        """
        self.steps += 1
        share = missing / self.halves
        near, moved = self._by_side(forces, lambda side, part: side.near(part, share * self.scale))
        return near, moved

    def _by_side(self, forces: Floats, found: Callable[["_Side", Floats], Floats]) -> Floats:
        """Combine what is found for each parity, (k, n, 3), to (k, n_halves, n, 3)."""
        if self.halves == 1:
            return found(self._sides[Parity.SYMMETRIC], forces[0])[:, None]
        even = found(self._sides[Parity.SYMMETRIC], (forces[0] + forces[1]) / 2)
        odd = found(self._sides[Parity.ANTISYMMETRIC], (forces[0] - forces[1]) / 2)
        return np.stack([even + odd, even - odd], axis=1)


# Forces that a parity remembers at most, and numbers that these may have.
_KNOWN, _NUMBERS = 160, 2**24


class _Side:
    """An elastic body of one parity, which remembers the forces for which it was solved.

    As a body that flows repeats itself from turn to turn, most forces are combinations of earlier ones.
    """

    def __init__(self, nodes: Ints, fixed: Mask, solve: Callable[[Floats], Floats]) -> None:
        self._nodes, self._fixed, self._solve = nodes, fixed.reshape(-1, 3), solve
        self._count, self._most = 0, max(1, min(_KNOWN, _NUMBERS // max(1, 3 * len(nodes))))
        #: Forces, orthonormal, and the displacements that they cause, each (n_known, 3 n_nodes)
        self._forces, self._moved = (np.zeros((self._most, 3 * len(nodes))) for _ in range(2))

    def everywhere(self, forces: Floats) -> Floats:
        """Displacement (n_all_nodes, 3) of the cell under forces (n_nodes, 3) in the zone."""
        sides = np.zeros(self._fixed.shape)
        sides[self._nodes] = forces
        sides = np.where(self._fixed, 0.0, sides).reshape(-1, 1)
        return np.where(self._fixed, 0.0, self._solve(sides).reshape(-1, 3))

    def near(self, forces: Floats, missing: Floats) -> Floats:
        """Forces of which no more than `missing` (n_nodes, 1) is left out, and their displacement."""
        known, moved = (each[: min(self._count, self._most)] for each in (self._forces, self._moved))
        left = np.where(self._fixed[self._nodes], 0.0, forces).ravel()
        weights = known @ left
        left = left - weights @ known
        if (np.abs(left.reshape(-1, 3)) <= missing).all():
            return np.stack([forces - left.reshape(-1, 3), (weights @ moved).reshape(-1, 3)])
        again = known @ left  # rounding leaves a part that is not orthogonal
        weights, left = weights + again, left - again @ known
        new = self.everywhere(left.reshape(-1, 3))[self._nodes].ravel()
        found = weights @ moved + new
        size, place = float(np.linalg.norm(left)), self._count % self._most
        self._forces[place], self._moved[place] = left / size, new / size
        self._count += 1
        return np.stack([forces, found.reshape(-1, 3)])


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
    zone: Zone, body: ElasticBody, elastic: Floats, before: FlowState, guesses: Sequence[FlowState] = ()
) -> FlowState:
    """Let a zone flow until it is in equilibrium with what acts.

    `elastic` (n_halves, n_nodes, 3) is the `projected` displacement, mm, of the elastic body under what acts;
    `before` is the state before. The iteration begins with its forces or those of one of the `guesses`, where
    least is out of balance. Raises `NoEquilibriumError`: none is found.
    """
    own, starts = zone.strain(elastic)[0], [before, *guesses]
    return _balanced(zone, body, starts, lambda added: zone.returned(own + added, before.plastic))


def projected(zone: Zone, body: ElasticBody, elastic: Floats) -> Floats:
    """Return a displacement (n_halves, n_nodes, 3), mm, of the elastic body, of projected volumetric strain.

    Only what exceeds first yield is, so that flow begins where the elastic stress reaches the yield strength;
    both parts are in equilibrium. Where the iteration does not converge, nothing is projected.
    """
    beyond = 1 - 1 / max(1.0, float(zone.usage(elastic, zone.virgin).max(initial=0.0)))
    if beyond == 0:
        return elastic
    own, rest = zone.strain(elastic)[1], at_rest(zone, body.halves)
    try:
        found = _balanced(zone, body, [rest], lambda _: zone.virgin, own, tolerance=BALANCED / beyond)
    except NoEquilibriumError:
        return elastic
    return elastic + beyond * found.moved


def _balanced(
    zone: Zone,
    body: ElasticBody,
    starts: Sequence[FlowState],
    flow: Callable[[Floats], Floats],
    projected: Floats | float = 0.0,
    *,
    tolerance: float = BALANCED,
) -> FlowState:
    """Find the state in which forces balance plastic strain and projection.

    `flow` gives plastic strain by the deviatoric strain added; what is projected beside the volumetric strain
    added. The iteration begins at that of the `starts` where least is out of balance.
    """

    def tried(forces: Floats, moved: Floats) -> _Trial:
        deviatoric, volumetric = zone.strain(moved)
        plastic = flow(deviatoric)
        missed = zone.initial_forces(projected + volumetric, plastic, body.halves) - forces
        unbalanced = float((np.abs(missed) / body.scale).max(initial=0.0))
        return _Trial(FlowState(plastic, forces, moved, unbalanced), missed)

    trials = [min((tried(each.forces, each.moved) for each in starts), key=lambda one: one.state.unbalanced)]
    least, reached = np.inf, 0
    for step in range(_MOST_STEPS):
        state = trials[-1].state
        if state.unbalanced <= tolerance:
            return state
        if state.unbalanced < least / 2:
            least, reached = state.unbalanced, step
        if step - reached > _STALLED or not np.abs(state.plastic - starts[0].plastic).max() < _LARGEST_STRAIN:
            break
        share = _LEFT if step - reached < _QUICK else 0.0
        trials = [*trials[1 - _MEMORY :], tried(*body.near(_accelerated(trials), share * state.unbalanced))]
    raise NoEquilibriumError


class _Trial(NamedTuple):
    """A state that was tried, and the forces (n_halves, n_nodes, 3), N, that it misses."""

    state: FlowState
    missed: Floats


def _accelerated(trials: Sequence[_Trial]) -> Floats:
    """Return the next forces: of those tried, the combination that misses least, and what it misses."""
    forces, missed = trials[-1].state.forces, trials[-1].missed
    if len(trials) == 1:
        return forces + missed
    steps = np.stack([(b.state.forces - a.state.forces).ravel() for a, b in pairwise(trials)], axis=1)
    changes = np.stack([(b.missed - a.missed).ravel() for a, b in pairwise(trials)], axis=1)
    weights = np.linalg.lstsq(changes, missed.ravel(), rcond=1e-10)[0]
    step = missed.ravel() - (steps + changes) @ weights
    return np.asarray(forces + step.reshape(forces.shape))


def nodal_force(zone: Zone) -> Floats:
    """Force (n_nodes, 1), N, at the nodes of the zone at yield: σ_y ∫ |∂N/∂x| dV, the largest of any axis."""
    size = np.abs(zone.gradients) * np.repeat(zone.volumes, 3, axis=1)[..., None]
    of_element = (zone.strength[..., None] * size).reshape(len(size), -1, 3, size.shape[2]).sum(axis=1)
    found = np.zeros((len(zone.nodes), 1))
    np.maximum.at(found, zone.corners, of_element.max(axis=1)[..., None])
    return found
