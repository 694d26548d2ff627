"""Direct solvers behind one small protocol, and the choice among them."""

import importlib.util
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from fea.choices import SolverName
from fea.solid import pardiso
from fea.solid.assembly import SymmetricMatrix
from fea.solid.errors import SolverUnavailableError

Floats = npt.NDArray[np.float64]


class DirectSolver(Protocol):
    """Holds factors of symmetric positive definite matrices with one sparsity, each in a slot."""

    name: str

    def factorise(self, slot: int, matrix: SymmetricMatrix) -> None:
        """Put the factor of `matrix` into a slot; raises `SingularMatrixError`."""

    def solve(self, slot: int, right_hand_sides: Floats) -> Floats:
        """Solve for (n, k) right-hand sides with the factor in a slot."""


def direct_solver(choice: SolverName, slots: int) -> DirectSolver:
    """Return the solver named; `AUTO` takes Pardiso where it is installed, else CHOLMOD.

    Raises
    ------
    SolverUnavailableError
        The named solver is not installed.
    """
    if choice is SolverName.AUTO:
        choice = SolverName.PARDISO if pardiso.is_installed() else SolverName.CHOLMOD
    if choice is SolverName.PARDISO:
        _require("pypardiso", choice)
        return pardiso.PardisoCholesky(slots)
    _require("cvxopt", choice)
    _require("pymetis", choice)
    from fea.solid.cholmod import CholmodCholesky  # noqa: PLC0415 - loads only what is used

    return CholmodCholesky()


@dataclass(frozen=True)
class Factor:
    """One factorised matrix."""

    solver: DirectSolver

    def solve(self, right_hand_sides: Floats) -> Floats:
        """Solve for (n, k) right-hand sides at once."""
        return self.solver.solve(0, right_hand_sides)


def factorise(matrix: SymmetricMatrix, choice: SolverName = SolverName.AUTO) -> Factor:
    """Factorise one matrix.

    Raises
    ------
    SingularMatrixError
        It is not positive definite.
    SolverUnavailableError
        The named solver is not installed.
    """
    solver = direct_solver(choice, slots=1)
    solver.factorise(0, matrix)
    return Factor(solver)


def _require(package: str, choice: SolverName) -> None:
    if importlib.util.find_spec(package) is None:
        message = (
            f"solver {choice} is not available: package {package} is not installed. "
            f"Install it (pip install {package}) or choose another --solver"
        )
        raise SolverUnavailableError(message)
