"""Unit loads of pins in contact: a pressure at each vertex of the bores, and four inertia fields.

The pressures of an instant are the solution of a small contact problem; everything that follows from them is
linear.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from fea.contact.rod_contact import RodContact
from fea.cycle.unit_loads import Weights, inertial_fields
from fea.solid.inertia import Inertia
from fea.solid.parity import Parity
from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface


@dataclass(frozen=True)
class ContactFields:
    """Unit loads of one parity on the cell.

    Attributes
    ----------
    contact
        The contact problem.
    vertices
        (n,) numbers of the pressures of this parity.
    inertial
        Nodal forces (n_nodes, 3) of the inertia fields.
    """

    contact: RodContact
    vertices: Ints
    inertial: tuple[Floats, ...]

    @property
    def count(self) -> int:
        """Number of unit loads."""
        return len(self.vertices) + len(self.inertial)

    def forces(self, units: slice) -> list[Floats]:
        """Nodal forces (n_nodes, 3) of some of them: of pressures, then of the inertia fields."""
        own = self.vertices[units]
        pressed = sparse.csc_array(self.contact.problem.forces)[:, own].toarray().T
        first = max(units.start - len(self.vertices), 0)
        last = max(units.stop - len(self.vertices), 0)
        return [*(column.reshape(-1, 3) for column in pressed), *self.inertial[first:last]]

    def traction(self, units: slice) -> dict[Surface, Floats]:
        """Traction (n_nodes, 3, n) of some of them on each bore."""
        own = self.vertices[units]
        n_cell = self.contact.problem.forces.shape[1]
        unit = np.zeros((n_cell, units.stop - units.start))
        unit[own, np.arange(len(own))] = 1.0
        return self.contact.traction(unit)


class ContactLoads:
    """The unit loads of a meshed rod with pins in contact.

    Parameters
    ----------
    contact
        The contact problem.
    inertia
        Inertia of the same mesh.
    """

    series_error, jumps = 0.0, False

    def __init__(self, contact: RodContact, inertia: Inertia) -> None:
        self._contact, self._inertia = contact, inertia
        fold = contact.problem.fold
        self._odd = np.flatnonzero(~fold.on_y) if fold.both_sides else np.zeros(0, dtype=int)

    def fields(self) -> tuple[ContactFields, ContactFields]:
        """Return the even and the odd unit loads."""
        even, odd = inertial_fields(self._inertia)
        every = np.arange(self._contact.problem.forces.shape[1])
        return (
            ContactFields(self._contact, every, tuple(even)),
            ContactFields(self._contact, self._odd, tuple(odd)),
        )

    def weights(
        self, pin: Floats, crank: Floats, acceleration: Floats, rate: Floats, turning: Floats
    ) -> Weights:
        """Weights of the unit loads at n instants, as `UnitLoads.weights`.

        Raises
        ------
        ContactError
            No pressure on a bore has the force of its pin.
        """
        motions = np.stack([acceleration[0], rate**2, acceleration[1], turning])
        pressure = self._contact.pressures(pin, crank, motions)
        parts = self._contact.problem.fold.parts(pressure)
        odd = parts[Parity.ANTISYMMETRIC][self._odd] if self._odd.size else np.zeros((0, pressure.shape[1]))
        return Weights(
            np.concatenate([parts[Parity.SYMMETRIC], motions[:2]]), np.concatenate([odd, motions[2:]])
        )
