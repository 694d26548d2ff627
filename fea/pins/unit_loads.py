"""Unit loads for every instant at every speed.

A rod in plane motion is loaded by pressures on two bores and by the body force −ρ(a₀ + α × x − ω² x). Each
unit load is even about y = 0 (pressures that are, a_x, ω²) or odd (the other pressures, a_y, α). Their
weights follow from the forces and the motion.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from fea.contact.assembly_state import AssemblyState
from fea.contact.touch import Touch
from fea.solid.inertia import EVEN_MOTIONS, ODD_MOTIONS, Inertia
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import Surface

# Crank angle of a four-stroke cycle, rad, and decimal places to which rounding leaves the share of an
# increment.
_CYCLE, _DIGITS = 4 * np.pi, 9


class Instants(NamedTuple):
    """What acts on the rod at n instants.

    Attributes
    ----------
    pin, crank
        (2, n) forces on the rod along rod x and y, N.
    acceleration
        (2, n) of the rod frame's origin in rod axes, mm/s².
    rate, turning
        (n,) angular velocity and acceleration of the rod about +z, rad/s and rad/s².
    """

    pin: Floats
    crank: Floats
    acceleration: Floats
    rate: Floats
    turning: Floats

    @property
    def motions(self) -> Floats:
        """Weights (4, n) of `EVEN_MOTIONS`, then of `ODD_MOTIONS`."""
        return np.stack([self.acceleration[0], self.rate**2, self.acceleration[1], self.turning])


class Course(NamedTuple):
    """A whole cycle, which instants belong to.

    Attributes
    ----------
    angles
        (n,) crank angles of the instants, rad.
    step_angles
        (m,) those of its increments in their order, rad; the first follows the last.
    steps
        What acts at the increments.
    """

    angles: Floats
    step_angles: Floats
    steps: Instants

    @property
    def places(self) -> Floats:
        """Numbers (n,) of the increments before the instants, with the share of the way to the next."""
        first = self.step_angles[0]
        ends = np.append(self.step_angles, first + _CYCLE)
        places = np.interp((self.angles - first) % _CYCLE, ends - first, np.arange(len(ends)))
        return np.asarray(np.round(places, _DIGITS) % len(self.step_angles))


class Weights(NamedTuple):
    """How much of each unit load there is.

    Attributes
    ----------
    even, odd
        (n_units, n_instants), of the unit loads of either parity.
    """

    even: Floats
    odd: Floats

    def at(self, instants: slice | Ints | Mask) -> "Weights":
        """Return those of some instants."""
        return Weights(self.even[:, instants], self.odd[:, instants])


class Together(NamedTuple):
    """Unit loads of either parity whose deviations are bounded together instead of each by itself.

    The bound is close if they are orthogonal states of equal energy.
    """

    even: slice
    odd: slice


ALONE = Together(slice(0, 0), slice(0, 0))


class Fields(Protocol):
    """Unit loads of one parity on the cell."""

    @property
    def count(self) -> int:
        """Number of unit loads."""

    def forces(self, units: slice) -> Sequence[Floats]:
        """Nodal forces (n_nodes, 3) of some of them, N."""

    def traction(self, units: slice) -> dict[Surface, Floats]:
        """Traction (n_nodes, 3, n) of some of them on each bore, MPa."""


class Contacts(NamedTuple):
    """Contact at each instant.

    Attributes
    ----------
    touches
        Of the pins with the bores; empty where their pressure is prescribed.
    states
        Of bolts and interfaces; empty for a rod of one piece.
    """

    touches: tuple[Mapping[Surface, Touch], ...] = ()
    states: tuple[AssemblyState, ...] = ()


class UnitLoads(Protocol):
    """The unit loads of a meshed rod.

    Attributes
    ----------
    series_error
        Largest error of the pressures that they can represent, relative to their peak.
    jumps
        Whether the pressure jumps at the ends of its arc.
    together
        Unit loads whose deviations are bounded together.
    remembers
        Whether friction makes an instant depend on those before it.
    """

    series_error: float
    jumps: bool
    together: Together
    remembers: bool

    def fields(self) -> tuple[Fields, Fields]:
        """Return the even and the odd unit loads."""

    def weights(self, instants: Instants, course: Course | None = None) -> Weights:
        """Weights of the unit loads at n instants.

        Parameters
        ----------
        instants
            What acts.
        course
            The cycle that they belong to, where friction makes them depend on it; by default each of them
            follows on the rod as it was put together.
        """

    def contacts(self, weights: Weights, instants: Instants, course: Course) -> Contacts:
        """Contact at the instants of a cycle, whose weights are known."""


def inertial_fields(inertia: Inertia) -> tuple[list[Floats], list[Floats]]:
    """Nodal forces (n_nodes, 3) of the even and of the odd unit accelerations."""
    even, odd = ([inertia.forces(motion) for motion in motions] for motions in (EVEN_MOTIONS, ODD_MOTIONS))
    return [split.symmetric for split in even], [
        split.symmetric if split.antisymmetric is None else split.antisymmetric for split in odd
    ]
