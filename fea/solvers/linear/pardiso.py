"""Cholesky factors by MKL Pardiso (Schenk & Gärtner 2004), loaded through pypardiso."""

import ctypes
import importlib.metadata
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fea.solid.assembly import SymmetricMatrix
from fea.solid.errors import SingularMatrixError
from geometry.arrays import Floats

_BLOCK = 3
_ANALYSE, _FACTORISE, _SOLVE, _FORWARD, _RELEASE = 11, 22, 33, 331, -1
_POSITIVE_DEFINITE = 2  # mtype: real, symmetric, upper triangle only
_NOT_POSITIVE_DEFINITE, _NO_MEMORY = -4, (-2, -9)


class PardisoCholesky:
    """Cholesky factors of matrices with the same sparsity, which is analysed only once.

    pypardiso's own functions keep one factor and copy its matrix; this class keeps several without copies.

    Parameters
    ----------
    slots
        How many factors to keep.

    Raises
    ------
    ImportError
        pypardiso or MKL is not installed.
    """

    name = "pardiso"

    def __init__(self, slots: int) -> None:
        self._pardiso = _library()
        self._slots = slots
        self._matrices: dict[int, Any] = {}
        self._handle = np.zeros(64, dtype=np.int64)
        self._options = np.zeros(64, dtype=np.int32)
        self._options[0] = 1  # these options, not the defaults
        self._options[1] = 3  # nested dissection in parallel
        self._options[17] = -1  # count the entries of the factor
        self._options[23] = 1  # two-level scheduling
        self._options[34] = 1  # indices from zero
        self._options[36] = _BLOCK  # ordering and analysis work on nodes: a ninth of the graph

    def factorise(self, slot: int, matrix: SymmetricMatrix) -> None:
        """Put the factor of `matrix` into a slot (0…slots − 1).

        Raises
        ------
        SingularMatrixError
            It is not positive definite.
        MemoryError
            MKL could not allocate the factor.
        """
        empty = np.zeros((matrix.size, 1))
        if not self._matrices:
            self._call(_ANALYSE, slot, matrix.upper, empty)
        self._matrices[slot] = matrix.upper
        self._call(_FACTORISE, slot, matrix.upper, empty)

    def solve(self, slot: int, right_hand_sides: Floats) -> Floats:
        """Solve for (n, k) right-hand sides with the factor in a slot."""
        return self._call(_SOLVE, slot, self._matrices[slot], np.asfortranarray(right_hand_sides))

    def half_solve(self, slot: int, right_hand_sides: Floats) -> Floats:
        """Return L⁻¹ P b of right-hand sides (n, k), with A = Pᵀ L Lᵀ P: its scalar products are bᵀA⁻¹b."""
        return self._call(_FORWARD, slot, self._matrices[slot], np.asfortranarray(right_hand_sides))

    def _call(self, phase: int, slot: int, upper: Any, right_hand_sides: Floats) -> Floats:
        solution = np.zeros_like(right_hand_sides)
        status = ctypes.c_int32(0)

        def integer(value: int) -> Any:
            return ctypes.byref(ctypes.c_int32(value))

        def integers(array: npt.NDArray[np.int32]) -> Any:
            return array.ctypes.data_as(ctypes.POINTER(ctypes.c_int32))

        def doubles(array: Floats) -> Any:
            return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))

        self._pardiso(
            self._handle.ctypes.data_as(ctypes.POINTER(ctypes.c_int64)),
            integer(self._slots),
            integer(slot + 1),
            integer(_POSITIVE_DEFINITE),
            integer(phase),
            integer(upper.shape[0] // _BLOCK),
            doubles(upper.data),
            integers(upper.indptr),
            integers(upper.indices),
            integers(np.zeros(1, dtype=np.int32)),
            integer(right_hand_sides.shape[1]),
            integers(self._options),
            integer(0),
            doubles(right_hand_sides),
            doubles(solution),
            ctypes.byref(status),
        )
        if status.value == _NOT_POSITIVE_DEFINITE:
            message = (
                "the stiffness matrix is not positive definite: the model is under-constrained or has faulty "
                "elements. Check the supports and the mesh"
            )
            raise SingularMatrixError(message)
        if status.value in _NO_MEMORY:
            message = (
                f"Pardiso ran out of memory with {upper.shape[0]} degrees of freedom. Use a larger --size or "
                "--solver amg"
            )
            raise MemoryError(message)
        if status.value != 0:
            message = f"Pardiso failed in phase {phase} with error {status.value}"
            raise RuntimeError(message)
        return solution

    def __del__(self) -> None:
        """Release MKL's memory."""
        if getattr(self, "_matrices", None) and not sys.is_finalizing():
            upper = next(iter(self._matrices.values()))
            self._call(_RELEASE, 0, upper, np.zeros((upper.shape[0], 1)))


def is_installed() -> bool:
    """Whether pypardiso is installed (nothing is loaded)."""
    try:
        importlib.metadata.version("pypardiso")
    except importlib.metadata.PackageNotFoundError:
        return False
    return True


def _library() -> Any:
    _point_at_mkl()
    from pypardiso.pardiso_wrapper import PyPardisoSolver  # noqa: PLC0415 - MKL is heavy and optional

    return PyPardisoSolver(mtype=_POSITIVE_DEFINITE)._mkl_pardiso  # noqa: SLF001 - its typed entry point


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
