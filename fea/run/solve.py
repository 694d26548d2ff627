"""From load cases to equilibrium: how the pins load the rod, and the displacement that follows."""

from collections.abc import Callable
from dataclasses import dataclass

from fea.pins.case_forces import CaseForces
from fea.solvers.static import Model, Solution
from loads.instants import Instants


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

    cases: Instants
    forces: tuple[CaseForces, ...]
    solution: Solution


@dataclass(frozen=True)
class PinModel:
    """How the pins load the rod: their pressure on the bores is prescribed, or follows from contact.

    Attributes
    ----------
    forces
        Turns a load case into nodal forces of everything that acts.
    model
        The stiffness of the cell.
    """

    forces: Callable[[Instants], CaseForces]
    model: Model

    def equilibrium(self, cases: Instants) -> Equilibrium:
        """Solve load cases, all with one factorisation per parity.

        Raises
        ------
        UnderconstrainedError
            A rigid motion is left free.
        SingularMatrixError
            The factorisation broke down.
        ContactError
            No pressure on a bore has the force of its pin.
        """
        forces = tuple(self.forces(case) for case in cases)
        solution = self.model.solve([case.forces for case in forces])
        shifts = [case.shift for case in forces if case.shift is not None]
        if shifts:
            solution = solution.moved(shifts)
        return Equilibrium(cases, forces, solution)
