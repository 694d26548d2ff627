"""The common interface of the linear solvers."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import partial

import numpy as np
from scipy import sparse

from fea.solid.assembly import SymmetricMatrix
from geometry.arrays import Floats

# From right-hand sides (n, k) to solutions.
Operator = Callable[[Floats], Floats]

NOT_POSITIVE_DEFINITE = (
    "the stiffness matrix is not positive definite: the model is under-constrained or has faulty elements. "
    "Check the supports and the mesh"
)
# Columns of forces that are solved for at once.
_COLUMNS = 128


class LinearSolver(ABC):
    """Solves with symmetric positive definite matrices A of one sparsity, each kept in a slot."""

    name: str

    @abstractmethod
    def factorise(self, slot: int, matrix: SymmetricMatrix) -> None:
        """Prepare to solve with `matrix`; raises `SingularMatrixError`."""

    @abstractmethod
    def solve(self, slot: int, right_hand_sides: Floats) -> Floats:
        """Solve for (n, k) right-hand sides with the matrix in a slot."""

    def condense(self, slot: int, matrix: SymmetricMatrix, forces: sparse.csc_array) -> Floats:
        """Prepare to solve with `matrix`, and return FᵀA⁻¹F (k, k) of sparse forces F (n, k).

        Raises `SingularMatrixError`. Here, all columns are solved for; a factorisation may give it for less.
        """
        self.factorise(slot, matrix)
        return work(forces, partial(self.solve, slot))

    def solve_sums(self, slot: int, forces: sparse.csc_array, columns: Floats) -> Floats:
        """Solve for sums F c of the sparse forces that were condensed, with columns c (k, m)."""
        return self.solve(slot, forces @ columns)

    def work(self, slot: int, forces: Floats) -> Floats:
        """Work FᵀA⁻¹F (k, k) of forces F (n, k) with the matrix in a slot."""
        return np.asarray(forces.T @ self.solve(slot, forces))


def work(forces: sparse.csc_array, solve: Operator) -> Floats:
    """Work FᵀA⁻¹F (k, k) of sparse forces F (n, k) with a solver of A u = f, some columns at a time."""
    blocks = [forces[:, start : start + _COLUMNS].toarray() for start in range(0, forces.shape[1], _COLUMNS)]
    return np.hstack([forces.T @ solve(block) for block in blocks])
