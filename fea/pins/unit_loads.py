"""Unit loads for every instant at every speed.

A rod in plane motion is loaded by pressures on two bores and by the body force −ρ(a₀ + α × x − ω² x). Each
unit load is even about y = 0 (pressures that are, a_x, ω²) or odd (the other pressures, a_y, α). Their
weights follow from the forces and the motion.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

from fea.contact.assembly_state import AssemblyState
from fea.contact.touch import Touch
from fea.solid.inertia import EVEN_MOTIONS, ODD_MOTIONS, Inertia
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.instants import Instants


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

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:
        """Weights of the unit loads at n instants.

        Parameters
        ----------
        instants
            What acts.
        cycle
            The one that they belong to, where friction makes them depend on it; by default each of them
            follows on the rod as it was put together.
        """

    def contacts(self, weights: Weights, instants: Instants, cycle: CrankCycle) -> Contacts:
        """Contact at the instants of a cycle, whose weights are known."""


def inertial_fields(inertia: Inertia) -> tuple[list[Floats], list[Floats]]:
    """Nodal forces (n_nodes, 3) of the even and of the odd unit accelerations."""
    even, odd = ([inertia.forces(motion) for motion in motions] for motions in (EVEN_MOTIONS, ODD_MOTIONS))
    return [split.symmetric for split in even], [
        split.symmetric if split.antisymmetric is None else split.antisymmetric for split in odd
    ]
