"""Unit loads of pins in contact: patterns of pressure on the vertices of the bores, and four inertia fields.

The pressures of an instant are the solution of a small contact problem; everything that follows from them is
linear. The patterns are the eigenvectors of the compliance, smooth ones first, of unit work: the smooth ones
reach far into the rod, and what all others do together is bounded by their work.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fea.contact.touch import Touch
from fea.pins.rod_contact import RodContact
from fea.pins.unit_loads import Contacts, Together, Weights, inertial_fields
from fea.solid.inertia import Inertia
from fea.solid.parity import Parity
from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.instants import Instants

# Patterns of either parity that are bounded each by itself.
SMOOTH = 10
_INERTIAL = 2
# Of the largest pressure of an instant: what rounding leaves where nothing touches.
NOTHING = 1e-9


@dataclass(frozen=True)
class ContactFields:
    """Unit loads of one parity on the cell.

    Attributes
    ----------
    contact
        The contact problem.
    patterns
        (n_cell, n) unknowns of the contact problem on the cell in each unit load.
    inertial
        Nodal forces (n_nodes, 3) of the inertia fields, which belong to the last unit loads.
    """

    contact: RodContact
    patterns: Floats
    inertial: tuple[Floats, ...]

    @property
    def count(self) -> int:
        """Number of unit loads."""
        return int(self.patterns.shape[1])

    def forces(self, units: slice) -> list[Floats]:
        """Nodal forces (n_nodes, 3) of some of them."""
        pressed = (self.contact.problem.forces @ self.patterns[:, units]).T
        found = [column.reshape(-1, 3) for column in pressed]
        for number, own in enumerate(self.inertial, self.count - len(self.inertial) - units.start):
            if 0 <= number < len(found):
                found[number] = found[number] + own
        return found

    def traction(self, units: slice) -> dict[Surface, Floats]:
        """Traction (n_nodes, 3, n) of some of them on each surface."""
        return self.contact.traction(self.patterns[:, units])


class ContactLoads:
    """The unit loads of a meshed rod with pins in contact.

    Parameters
    ----------
    contact
        The contact problem.
    inertia
        Inertia of the same mesh.
    """

    series_error, jumps, remembers = 0.0, False, False

    def __init__(self, contact: RodContact, inertia: Inertia) -> None:
        self._contact, self._inertia = contact, inertia
        problem = contact.problem
        n_cell = len(problem.unfolding.on_y)
        self._patterns, self._weighing = {}, {}
        for parity, compliance in problem.cell_compliance.items():
            own = np.flatnonzero(problem.unfolding.has(parity))
            self._patterns[parity], self._weighing[parity] = np.zeros((2, n_cell, len(own)))
            patterns = of_unit_work(compliance[np.ix_(own, own)])
            self._patterns[parity][own], self._weighing[parity][own] = patterns
        nothing = np.zeros((n_cell, 0))
        for of_parity in (self._patterns, self._weighing):
            of_parity.setdefault(Parity.ANTISYMMETRIC, nothing)
        self.together = Together(*(slice(SMOOTH, self._patterns[parity].shape[1]) for parity in Parity))

    def fields(self) -> tuple[ContactFields, ContactFields]:
        """Return the even and the odd unit loads."""
        even, odd = (
            ContactFields(
                self._contact,
                np.hstack([self._patterns[parity], np.zeros((len(self._patterns[parity]), len(inertial)))]),
                tuple(inertial),
            )
            for parity, inertial in zip(Parity, inertial_fields(self._inertia), strict=True)
        )
        return even, odd

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:  # noqa: ARG002
        """Weights of the unit loads at n instants, as `UnitLoads.weights`.

        Raises
        ------
        ContactError
            No pressure on a bore has the force of its pin.
        """
        motions, solved = instants.motions, self._contact.solutions(instants)
        parts = self._contact.problem.unfolding.parts(np.stack([each.values for each in solved], axis=1))
        none = np.zeros((len(self._contact.problem.unfolding.on_y), len(instants)))
        even, odd = (self._weighing[parity].T @ parts.get(parity, none) for parity in Parity)
        return Weights(
            np.concatenate([even, motions[:_INERTIAL]]), np.concatenate([odd, motions[_INERTIAL:]])
        )

    def contacts(self, weights: Weights, instants: Instants, cycle: CrankCycle) -> Contacts:  # noqa: ARG002
        """Contact of the pins with the bores at each instant."""
        parts = {}
        for parity, own in zip(Parity, weights, strict=True):
            patterns = self._patterns[parity]
            parts[parity] = patterns @ own[: patterns.shape[1]]
        pressure = self._contact.problem.unfolding.unfolded(parts)
        return Contacts(touches(self._contact, pressure, slice(None)))


def touches(contact: RodContact, values: Floats, pins: slice | Ints) -> tuple[Mapping[Surface, Touch], ...]:
    """Contact of the pins at each instant from the unknowns (n, n_instants); `pins` are their pressures."""
    values = np.where(values < NOTHING * values[pins].max(axis=0), 0.0, values)
    return tuple(contact.touch(instant) for instant in values.T)


def of_unit_work(compliance: Floats) -> tuple[Floats, Floats]:
    """Eigenvectors (n, n) of a compliance of unit work, softest first, and what weighs values by them."""
    work, vectors = np.linalg.eigh(compliance)
    scale = np.sqrt(work[::-1])
    return vectors[:, ::-1] / scale, vectors[:, ::-1] * scale
