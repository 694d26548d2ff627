"""Direct solvers behind one small protocol."""

import importlib.metadata
import os
import sys
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt
from scipy.sparse.linalg import splu

from fea.choices import SolverName
from fea.solid.assembly import SymmetricMatrix
from fea.solid.errors import SingularMatrixError, SolverUnavailableError

Floats = npt.NDArray[np.float64]


class Factor(Protocol):
    """A factorised symmetric positive definite matrix."""

    name: str

    def solve(self, right_hand_sides: Floats) -> Floats:
        """Solve for (n, k) right-hand sides at once."""


class PardisoFactor:
    """Cholesky factor by MKL Pardiso (Schenk & Gärtner 2004) through pypardiso.

    Raises
    ------
    SingularMatrixError
        When the matrix is not positive definite.
    """

    name = "pardiso"

    def __init__(self, matrix: SymmetricMatrix) -> None:
        from pypardiso.pardiso_wrapper import PyPardisoError  # noqa: PLC0415 - MKL is heavy and optional

        self._matrix = matrix.upper
        self._solver = _pardiso_solver()
        self._solver.set_phase(12)
        try:
            self._call(np.zeros((matrix.size, 1)))
        except PyPardisoError as error:
            if error.value == -4:
                message = "the stiffness matrix is not positive definite"
                raise SingularMatrixError(message) from error
            if error.value in (-2, -9):
                message = f"Pardiso ran out of memory on {matrix.size} degrees of freedom"
                raise MemoryError(message) from error
            raise
        self._solver.set_phase(33)

    def _call(self, right_hand_sides: Floats) -> Floats:
        # pypardiso's own factorize() copies the matrix and compares it at every solve.
        return np.asarray(self._solver._call_pardiso(self._matrix, right_hand_sides))  # noqa: SLF001

    def solve(self, right_hand_sides: Floats) -> Floats:
        """Solve for (n, k) right-hand sides at once."""
        return self._call(np.asfortranarray(right_hand_sides))

    def __del__(self) -> None:
        """Give MKL's memory back."""
        solver = getattr(self, "_solver", None)
        if solver is not None and not sys.is_finalizing():
            solver.free_memory()


class SuperLUFactor:
    """LU factor by SciPy's SuperLU (Demmel et al. 1999) in symmetric mode; slow, but everywhere.

    Raises
    ------
    SingularMatrixError
        When a pivot is zero.
    """

    name = "superlu"

    def __init__(self, matrix: SymmetricMatrix) -> None:
        upper = matrix.upper
        full = (upper + upper.T).tocsc()
        full.setdiag(matrix.diagonal())
        try:
            self._lu = splu(
                full, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0
            )
        except RuntimeError as error:
            message = "the stiffness matrix is singular"
            raise SingularMatrixError(message) from error

    def solve(self, right_hand_sides: Floats) -> Floats:
        """Solve for (n, k) right-hand sides at once."""
        return np.asarray(self._lu.solve(right_hand_sides))


def factorise(matrix: SymmetricMatrix, solver: SolverName = SolverName.AUTO) -> Factor:
    """Factorise with the named solver; `AUTO` takes Pardiso where it is installed.

    Raises
    ------
    SingularMatrixError
        The matrix is not positive definite.
    SolverUnavailableError
        The named solver is not installed.
    """
    if solver is SolverName.SUPERLU or (solver is SolverName.AUTO and not has_pardiso()):
        return SuperLUFactor(matrix)
    if not has_pardiso():
        message = (
            f"solver {solver} is not available: package pypardiso is not installed. "
            "Install it (pip install pypardiso) or choose --solver superlu"
        )
        raise SolverUnavailableError(message)
    return PardisoFactor(matrix)


def has_pardiso() -> bool:
    """Whether pypardiso is installed (nothing is loaded)."""
    try:
        importlib.metadata.version("pypardiso")
    except importlib.metadata.PackageNotFoundError:
        return False
    return True


def _pardiso_solver() -> Any:
    _point_at_mkl()
    from pypardiso.pardiso_wrapper import PyPardisoSolver  # noqa: PLC0415 - MKL is heavy and optional

    solver = PyPardisoSolver(mtype=2)  # real, symmetric positive definite: upper triangle only
    solver.set_iparm(1, 1)  # the values below, not the defaults
    solver.set_iparm(2, 3)  # nested dissection in parallel
    solver.set_iparm(24, 1)  # two-level scheduling of the factorisation
    return solver


def _point_at_mkl() -> None:
    # pypardiso searches the whole environment for the library unless this variable names it.
    if "PYPARDISO_MKL_RT" in os.environ:
        return
    try:
        files = importlib.metadata.files("mkl") or []
    except importlib.metadata.PackageNotFoundError:
        return
    for file in files:
        if file.name.startswith(("libmkl_rt.so", "mkl_rt")) and Path(str(file.locate())).exists():
            os.environ["PYPARDISO_MKL_RT"] = str(Path(str(file.locate())).resolve())
            return
