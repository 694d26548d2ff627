"""Unit loads of a rod of separate parts.

What acts between the parts is linear in the pressures of the pins and the inertia while everything sticks,
so that these unit loads are those of the joined rod. The state in which the parts were put together is one
more, and what opens and slips over a cycle is spanned by a few patterns: the largest singular vectors of its
course.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from fea.contact.assembled_rod import AssembledRod
from fea.contact.joined_system import Joined
from fea.cycle.contact_loads import NOTHING, SMOOTH, ContactFields, of_unit_work
from fea.cycle.unit_loads import Course, Instants, Together, Weights, inertial_fields
from fea.rod.assembly_state import AssemblyState
from fea.rod.touch import Touch
from fea.solid.inertia import Inertia
from fea.solid.parity import Parity
from geometry.arrays import Floats
from geometry.surfaces import Surface

# Singular values that are kept, relative to the stress between the parts as they were put together.
_KEPT = 1e-5
_Parts = dict[Parity, Floats]


class AssembledLoads:
    """The unit loads of a meshed rod of separate parts.

    Parameters
    ----------
    contact
        The contact problem.
    inertia
        Inertia of the same mesh.
    courses, alone
        Cycles and load cases whose opening and slip the unit loads shall span.

    Attributes
    ----------
    series_error
        0: the pressures are not a series.
    """

    series_error, jumps, remembers = 0.0, False, True

    def __init__(
        self, contact: AssembledRod, inertia: Inertia, courses: Sequence[Course], alone: Sequence[Instants]
    ) -> None:
        self._contact, self._inertia = contact, inertia
        self._fold, self._assembled = contact.problem.fold, contact.assembled
        self._courses: dict[bytes, list[Joined]] = {}
        self._last = b"", dict[bytes, Joined]()  # the states of the last cycle are asked for again
        self._pinned = {parity: self._of_pins(parity) for parity in self._fold.parities()}
        states = [state for course in courses for state in self._course(course)]
        for cases in alone:
            states += contact.solutions(cases.pin, cases.crank, cases.motions)
        slips = np.stack([state.gap for state in states], axis=1) - self._assembled.start.gap[:, None]
        self._slips = self._principal(self._fold.parts(self._assembled.slipped(slips)))
        self._inertial = self._fold.parts(self._assembled.tied_loads())
        self._start = self._fold.parts(self._assembled.tied_start[:, None])
        count = {parity: own[0].shape[1] for parity, own in self._pinned.items()}
        self.together = Together(*(slice(SMOOTH, count.get(parity, 0)) for parity in Parity))

    def _of_pins(self, parity: Parity) -> tuple[Floats, Floats]:
        """Patterns (n_cell, k) of unit work with what they cause between parts, and weights (k, n_cell)."""
        assembled, fold = self._assembled, self._fold
        cells = np.flatnonzero(fold.has(parity)[: contact_size(self._contact)])
        unit = np.zeros((len(fold.on_y), len(cells)))
        unit[cells, np.arange(len(cells))] = 1.0
        nothing = np.zeros_like(unit)
        both = {own: unit if own is parity else nothing for own in fold.parities()}
        every = fold.joined(both)[assembled.pins]
        smooth, weighing_own = of_unit_work(every.T @ assembled.tied_compliance @ every)
        patterns = fold.parts(assembled.tied_to(every @ smooth))[parity]
        weighing = np.zeros((len(cells), len(fold.on_y)))
        weighing[:, cells] = weighing_own.T
        return patterns, weighing

    def _principal(self, parts: _Parts) -> _Parts:
        """Orthonormal patterns (n_cell, k) that span opening and slip."""
        least = _KEPT * np.abs(self._assembled.tied_start).max()
        found = {}
        for parity, own in parts.items():
            left, values, _ = np.linalg.svd(own, full_matrices=False)
            found[parity] = left[:, values > least]
        return found

    def fields(self) -> tuple[ContactFields, ContactFields]:
        """Return the even and the odd unit loads."""
        even, odd = (
            ContactFields(self._contact, self._patterns(parity), tuple(inertial))
            for parity, inertial in zip(Parity, inertial_fields(self._inertia), strict=True)
        )
        return even, odd

    def _patterns(self, parity: Parity) -> Floats:
        """Unknowns (n_cell, n) of each unit load: pins, the parts put together, opening and slip, inertia."""
        motions = slice(0, 2) if parity is Parity.SYMMETRIC else slice(2, 4)
        if parity not in self._pinned:  # a cell that is not cut at y = 0 has everything in its even part
            return self._inertial[Parity.SYMMETRIC][:, motions]
        own = [self._pinned[parity][0], self._start[parity], self._slips[parity]]
        return np.hstack([*own, self._inertial[parity][:, motions]])

    def weights(self, instants: Instants, course: Course | None = None) -> Weights:
        """Weights of the unit loads at n instants, as `UnitLoads.weights`.

        Raises
        ------
        ContactError
            No state of contact between the parts carries the load.
        """
        motions = instants.motions
        solved = self._solved(instants, course)
        values = np.stack([state.values for state in solved], axis=1)
        slips = np.stack([state.gap for state in solved], axis=1) - self._assembled.start.gap[:, None]
        slipped, pressed = self._fold.parts(self._assembled.slipped(slips)), self._fold.parts(values)
        one = np.ones((1, len(solved)))
        found = []
        for parity, moved in zip(Parity, (motions[:2], motions[2:]), strict=True):
            if parity not in self._pinned:
                found.append(moved)
                continue
            pinned = self._pinned[parity][1] @ pressed[parity]
            found.append(np.concatenate([pinned, one, self._slips[parity].T @ slipped[parity], moved]))
        return Weights(*found)

    def _solved(self, instants: Instants, course: Course | None) -> Sequence[Joined]:
        if course is None:
            return self._contact.solutions(instants.pin, instants.crank, instants.motions)
        every = list(zip(instants.pin.T, instants.crank.T, instants.motions.T, strict=True))
        keys = [b"".join(own.tobytes() for own in instant) for instant in every]
        if self._last[0] != self._key(course):
            self._last = self._key(course), {}
        known = self._last[1]
        left = [number for number, key in enumerate(keys) if key not in known]
        states = self._course(course)
        places = np.interp(course.angles, course.step_angles, np.arange(len(states)))
        found = self._contact.between([every[number] for number in left], states, places[left])
        known.update(zip([keys[number] for number in left], found, strict=True))
        return [known[key] for key in keys]

    @staticmethod
    def _key(course: Course) -> bytes:
        return course.steps.pin.tobytes() + course.steps.motions.tobytes()

    def _course(self, course: Course) -> list[Joined]:
        """States at the increments of a cycle, computed once."""
        key = self._key(course)
        if key not in self._courses:
            steps = course.steps
            self._courses[key] = self._contact.course(steps.pin, steps.crank, steps.motions)
        return self._courses[key]

    def states(self, instants: Instants, course: Course) -> tuple[AssemblyState, ...]:
        """Bolts and interfaces at each instant of a cycle, as `UnitLoads.states`."""
        return tuple(self._contact.states(state) for state in self._solved(instants, course))

    def touches(self, weights: Weights) -> tuple[Mapping[Surface, Touch], ...]:
        """Contact of the pins with the bores at each instant."""
        values = self._values(weights)
        values[values < NOTHING * values[self._assembled.pins].max(axis=0)] = 0.0
        return tuple(self._contact.touch(instant) for instant in values.T)

    def _values(self, weights: Weights) -> Floats:
        """Unknowns (n, n_instants) of the contact problem."""
        parts = {}
        for parity, own in zip(Parity, weights, strict=True):
            if parity in self._pinned:
                parts[parity] = self._patterns(parity) @ own
        if len(parts) < len(weights):
            parts[Parity.SYMMETRIC] += self._patterns(Parity.ANTISYMMETRIC) @ weights.odd
        return self._fold.joined(parts)


def contact_size(contact: AssembledRod) -> int:
    """Number of pressures of the pins on the cell."""
    return int(contact.problem.starts[len(contact.problem.bores)])
