"""Unit loads of a rod of separate parts.

What acts between the parts is linear in the inertia while everything sticks, so that these unit loads are
those of the joined rod. The state in which the parts were put together is one more. What the pins, opening
and slip add over a cycle is spanned by the largest singular vectors of its states (method of snapshots,
Sirovich 1987, Q. Appl. Math. 45, 561).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fea.contact.friction_cycle import FrictionCycle
from fea.contact.friction_system import ContactState
from fea.pins.assembled_rod import AssembledRod
from fea.pins.contact_loads import SMOOTH, ContactFields, of_unit_work, touches
from fea.pins.rod_contact import acting, key
from fea.pins.unit_loads import Contacts, Together, Weights, inertial_fields
from fea.solid.inertia import Inertia
from fea.solid.parity import Parity
from geometry.arrays import Floats
from loads.crank_cycle import CrankCycle
from loads.instants import Instants

# Largest error of a pressure, relative to the largest, and of a bolt force likewise, that the patterns may
# leave over a cycle: stresses, which are larger, err less. Of load cases, some of which have little stress,
# it is a tenth. And the least singular values, relative to the largest, with which that is tried.
_ERROR, _OF_CASES = 2e-3, 10
_KEPT = np.geomspace(1e-3, 1e-6, 31)
# Singular values, relative to the largest, that a Gram matrix does not tell from rounding.
_NOISE = 1e-7
_Parts = dict[Parity, Floats]


class _Span(NamedTuple):
    """Patterns (n_cell, k) of unit work, and weights (k, n_cell) of what they span."""

    patterns: Floats
    weighing: Floats


class _Cycle(NamedTuple):
    """A cycle, and states that were found before by what acts."""

    cycle: FrictionCycle
    known: dict[bytes, ContactState]


class AssembledLoads:
    """The unit loads of a meshed rod of separate parts.

    Parameters
    ----------
    contact
        The contact problem.
    inertia
        Inertia of the same mesh.
    cycles, alone
        Instants of cycles, and load cases, that the unit loads shall span.
    """

    series_error, jumps, remembers = 0.0, False, True

    def __init__(
        self,
        contact: AssembledRod,
        inertia: Inertia,
        cycles: Sequence[CrankCycle],
        alone: Sequence[Instants],
    ) -> None:
        self._contact, self._inertia = contact, inertia
        self._unfolding, self._assembled = contact.problem.unfolding, contact.assembled
        self._spanned = frozenset(map(_key, cycles))
        self._cycles: dict[bytes, _Cycle] = {}
        self._joined = self._assembled.sticking_loads(), self._assembled.sticking_start[:, None]
        over_cycles = [(self.states(cycle.degrees, cycle), cycle.degrees.motions) for cycle in cycles]
        of_cases = [(self.states(cases, None), cases.motions) for cases in alone]
        rests = [self._rest(*own) for own in over_cycles] + [_OF_CASES * self._rest(*own) for own in of_cases]
        largest = np.max([np.abs(state.values) for states, _ in over_cycles for state in states], axis=0)
        self._spans = self._spanning(self._unfolding.parts(np.hstack(rests)), largest)
        self._inertial, self._start = map(self._unfolding.parts, self._joined)
        count = {parity: own.patterns.shape[1] for parity, own in self._spans.items()}
        self.together = Together(*(slice(SMOOTH, count.get(parity, 0)) for parity in Parity))

    def _rest(self, states: Sequence[ContactState], motions: Floats) -> Floats:
        """Unknowns (n, n_instants) less those of the parts put together and of inertia in the joined rod."""
        inertial, start = self._joined
        values = np.stack([state.values for state in states], axis=1)
        return np.asarray(values - start - inertial @ motions)

    def _spanning(self, parts: _Parts, largest: Floats) -> dict[Parity, _Span]:
        """Span states (n_cell, n_states) of each parity, whose unknowns reach the values `largest` (n,)."""
        problem, bolts = self._contact.problem, self._assembled.bolts
        pressure, force = np.delete(largest, bolts).max(), largest[bolts].max(initial=0.0)
        scale = np.ones(len(problem.unfolding.on_y))
        if force > 0:  # both count in their own sizes
            scale[len(scale) - len(problem.bolts) :] = pressure / force
        scaled = {parity: scale[:, None] * own for parity, own in parts.items()}
        bases = _principal(scaled, _ERROR * pressure)
        spans = {}
        for parity, basis in bases.items():
            unscaled = basis / scale[:, None]
            smooth, weighing = of_unit_work(unscaled.T @ problem.cell_compliance[parity] @ unscaled)
            nearest = basis.T * scale
            # Exactly the forces of the pins: what is left must not reach beyond the ends of the rod.
            forces, of_patterns = (self._pin_forces(parity, own) for own in (np.eye(len(scale)), unscaled))
            nearest += np.linalg.pinv(of_patterns, rcond=_NOISE) @ (forces - of_patterns @ nearest)
            spans[parity] = _Span(unscaled @ smooth, weighing.T @ nearest)
        return spans

    def _pin_forces(self, parity: Parity, values: Floats) -> Floats:
        """Resultants (m, k) of the pins in states (n_cell, k) of one parity."""
        parts = {
            own: values if own is parity else np.zeros_like(values) for own in self._unfolding.parities()
        }
        return np.asarray(self._contact.problem.rigid.T @ self._unfolding.unfolded(parts))

    def fields(self) -> tuple[ContactFields, ContactFields]:
        """Return the even and the odd unit loads."""
        even, odd = (
            ContactFields(self._contact, self._patterns(parity), tuple(inertial))
            for parity, inertial in zip(Parity, inertial_fields(self._inertia), strict=True)
        )
        return even, odd

    def _patterns(self, parity: Parity) -> Floats:
        """Unknowns (n_cell, n) of each unit load: pins, opening and slip; the parts put together; inertia."""
        motions = slice(0, 2) if parity is Parity.SYMMETRIC else slice(2, 4)
        if parity not in self._spans:  # a cell that is not cut at y = 0 has everything in its even part
            return self._inertial[Parity.SYMMETRIC][:, motions]
        own = [self._spans[parity].patterns, self._start[parity], self._inertial[parity][:, motions]]
        return np.hstack(own)

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:
        """Weights of the unit loads at n instants, as `UnitLoads.weights`.

        Raises
        ------
        ContactError
            No state of contact between the parts carries the load.
        """
        motions = instants.motions
        rest = self._unfolding.parts(self._rest(self.states(instants, cycle), motions))
        one = np.ones((1, motions.shape[1]))
        found = []
        for parity, moved in zip(Parity, (motions[:2], motions[2:]), strict=True):
            known = [self._spans[parity].weighing @ rest[parity], one] if parity in self._spans else []
            found.append(np.concatenate([*known, moved]))
        return Weights(*found)

    def states(self, instants: Instants, crank_cycle: CrankCycle | None) -> Sequence[ContactState]:
        """States at n instants: of a cycle, or each of them from the parts put together."""
        if crank_cycle is None:
            return self._contact.solutions(instants)
        keys = [key(*instant) for instant in acting(instants)]
        cycle, known = self._cycle(crank_cycle)
        left = [number for number, key in enumerate(keys) if key not in known]
        if left:
            some = instants[np.array(left)]
            found = cycle.at(self._contact.loads(some), crank_cycle.places(some.crank_angle))
            known.update(zip([keys[number] for number in left], found, strict=True))
        return [known[key] for key in keys]

    def _cycle(self, crank_cycle: CrankCycle) -> _Cycle:
        """A cycle with what is known of it: kept for what is spanned and the last one."""
        key = _key(crank_cycle)
        if key not in self._cycles:
            kept = {own: cycle for own, cycle in self._cycles.items() if own in self._spanned}
            made = self._contact.cycle(crank_cycle.increments)
            self._cycles = kept | {key: _Cycle(made, {})}
        return self._cycles[key]

    def contacts(self, weights: Weights, instants: Instants, cycle: CrankCycle) -> Contacts:  # noqa: ARG002
        """Contact of the pins with the bores, bolts and interfaces at each instant."""
        solved = self.states(instants, cycle)
        values = np.stack([state.values for state in solved], axis=1)
        return Contacts(
            touches(self._contact, values, self._assembled.pins),
            tuple(self._contact.states(state) for state in solved),
        )


def _principal(parts: _Parts, error: float) -> _Parts:
    """Orthonormal patterns (n_cell, k) that span states (n_cell, n_states) up to an error at any place."""
    found = {parity: _singular(own) for parity, own in parts.items()}
    most = max(float(sizes.max(initial=0.0)) for sizes, _ in found.values())
    left, count = parts, dict.fromkeys(parts, 0)
    for least in _KEPT:
        for parity, (sizes, vectors) in found.items():
            before, count[parity] = count[parity], int((sizes > least * most).sum())
            more = vectors[:, before : count[parity]]
            left = left | {parity: left[parity] - more @ (more.T @ left[parity])}
        if np.sum([np.abs(own) for own in left.values()], axis=0).max() <= error:
            break
    return {parity: vectors[:, : count[parity]] for parity, (_, vectors) in found.items()}


def _singular(states: Floats) -> tuple[Floats, Floats]:
    """Singular values (k,), the largest first, and left vectors (n_cell, k), from the smaller Gram matrix."""
    few = states.shape[1] <= states.shape[0]
    values, vectors = np.linalg.eigh(states.T @ states if few else states @ states.T)
    sizes = np.sqrt(np.maximum(values[::-1], 0.0))
    kept = sizes > _NOISE * sizes.max(initial=0.0)
    sizes, vectors = sizes[kept], vectors[:, ::-1][:, kept]
    return sizes, states @ (vectors / sizes) if few else vectors


def _key(cycle: CrankCycle) -> bytes:
    return cycle.increments.pin.tobytes() + cycle.increments.motions.tobytes()
