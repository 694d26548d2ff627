"""From load cases to equilibrium: how the pins load the rod, and the displacement that follows."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from fea.rod.case_forces import CaseForces, NodalForces
from fea.solvers.static import Model, Solution
from loads.cases import LoadCase


@dataclass(frozen=True)
class Equilibrium:
    """Load cases in equilibrium.

    Attributes
    ----------
    cases
        What acts.
    forces
        Nodal forces of each case on the solved cell.
    solution
        The displacement under them, a column per case.
    """

    cases: tuple[LoadCase, ...]
    forces: tuple[CaseForces, ...]
    solution: Solution


class PinModel(Protocol):
    """How the pins load the rod.

    The forces of a pin may depend on the displacement that they cause, as those of contact do: a pin model
    therefore returns forces and displacement together, and nothing downstream assumes that the one is linear
    in the other.
    """

    def equilibrium(self, cases: Sequence[LoadCase]) -> Equilibrium:
        """Solve load cases."""


@dataclass(frozen=True)
class PrescribedPressure:
    """Pins whose pressure on the bores is prescribed: the forces are known before anything is solved.

    Attributes
    ----------
    nodal_forces
        Turns a load case into nodal forces.
    model
        The stiffness of the cell.
    """

    nodal_forces: NodalForces
    model: Model

    def equilibrium(self, cases: Sequence[LoadCase]) -> Equilibrium:
        """Solve load cases, all with one factorisation per parity.

        Raises
        ------
        UnderconstrainedError
            A rigid motion is left free.
        SingularMatrixError
            The factorisation broke down.
        """
        forces = tuple(self.nodal_forces(case) for case in cases)
        return Equilibrium(tuple(cases), forces, self.model.solve([case.forces for case in forces]))
