"""Cholesky factors by MKL Pardiso (Schenk & Gärtner 2004), loaded through pypardiso."""

import ctypes
import importlib.metadata
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse

from fea.solid.assembly import SymmetricMatrix
from fea.solid.errors import SingularMatrixError
from geometry.arrays import Floats

_BLOCK = 3
_ANALYSE, _FACTORISE, _SOLVE, _RELEASE = 11, 22, 33, -1
_POSITIVE_DEFINITE, _INDEFINITE = 2, -2  # mtype: real, symmetric, upper triangle only
_NOT_POSITIVE_DEFINITE, _NO_MEMORY = -4, (-2, -9)
# MKL's options by place: these in place of the defaults, nested dissection in parallel, indices from zero.
_OPTIONS = {0: 1, 1: 3, 34: 1}
# Values, starts of the rows and columns of a sparse matrix.
Parts = tuple[Floats, npt.NDArray[np.int32], npt.NDArray[np.int32]]


class _Pardiso:
    """A handle of MKL's `pardiso` for matrices of one kind and sparsity, `slots` of which it keeps.

    pypardiso's own functions keep one factor and copy its matrix; a handle keeps several without copies.
    """

    def __init__(self, kind: int, slots: int, options: dict[int, int]) -> None:
        self._library, self._kind, self._slots = _library(), kind, slots
        self._handle = np.zeros(64, dtype=np.int64)
        self._options = np.zeros(64, dtype=np.int32)
        for place, value in {**_OPTIONS, **options}.items():
            self._options[place] = value

    def __call__(
        self,
        phase: int,
        rows: int,
        parts: Parts,
        right_hand_sides: Floats,
        solution: Floats,
        *,
        slot: int = 0,
        last: npt.NDArray[np.int32] | None = None,
    ) -> None:
        """Run a phase for a matrix of `rows` (block) rows, with right-hand sides and solution (n, k).

        A Schur complement takes the place of the solution; `last` (rows,) is 1 for its rows.
        """
        status = ctypes.c_int32(0)
        values, starts, columns = parts
        permutation = np.zeros(1, dtype=np.int32) if last is None else last
        self._library(
            self._handle.ctypes.data_as(ctypes.POINTER(ctypes.c_int64)),
            *(_integer(value) for value in (self._slots, slot + 1, self._kind, phase, rows)),
            _doubles(values),
            *(_integers(array) for array in (starts, columns, permutation)),
            _integer(right_hand_sides.shape[1]),
            _integers(self._options),
            _integer(0),
            _doubles(right_hand_sides),
            _doubles(solution),
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
                f"Pardiso ran out of memory with {len(starts) - 1} rows. Use a larger --size or --solver amg"
            )
            raise MemoryError(message)
        if status.value != 0:
            raise RuntimeError(f"Pardiso failed in phase {phase} with error {status.value}")


def _integer(value: int) -> Any:
    return ctypes.byref(ctypes.c_int32(value))


def _integers(array: npt.NDArray[np.int32]) -> Any:
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_int32))


def _doubles(array: Floats) -> Any:
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


class PardisoCholesky:
    """Cholesky factors of `slots` matrices with the same sparsity, which is analysed only once."""

    name = "pardiso"

    def __init__(self, slots: int) -> None:
        # The entries of the factor are counted; scheduling is on two levels; ordering and analysis work on
        # nodes: a ninth of the graph.
        self._pardiso = _Pardiso(_POSITIVE_DEFINITE, slots, {17: -1, 23: 1, 36: _BLOCK})
        self._matrices: dict[int, Any] = {}

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
            self._run(_ANALYSE, slot, matrix.upper, empty)
        self._matrices[slot] = matrix.upper
        self._run(_FACTORISE, slot, matrix.upper, empty)

    def solve(self, slot: int, right_hand_sides: Floats) -> Floats:
        """Solve for (n, k) right-hand sides with the factor in a slot."""
        return self._run(_SOLVE, slot, self._matrices[slot], np.asfortranarray(right_hand_sides))

    def _run(self, phase: int, slot: int, upper: Any, right_hand_sides: Floats) -> Floats:
        solution, parts = np.empty_like(right_hand_sides), (upper.data, upper.indptr, upper.indices)
        self._pardiso(phase, upper.shape[0] // _BLOCK, parts, right_hand_sides, solution, slot=slot)
        return solution

    def __del__(self) -> None:
        """Release MKL's memory."""
        if getattr(self, "_matrices", None) and not sys.is_finalizing():
            upper = next(iter(self._matrices.values()))
            self._run(_RELEASE, 0, upper, np.zeros((upper.shape[0], 1)))


class PardisoSchur:
    """Schur complements FᵀA⁻¹F of positive definite matrices A; the same sparsity is analysed once.

    A factorisation that leaves the columns of sparse F to the end gives them at a fraction of the cost of
    solutions for all columns, because it exploits what each of them does not reach.
    """

    def __init__(self) -> None:
        # Pivots below 1e-8 of the norm are perturbed; some are of order two; the complement is returned.
        self._pardiso = _Pardiso(_INDEFINITE, 1, {9: 8, 20: 1, 35: 1})
        self._known: tuple[Parts, npt.NDArray[np.int32]] | None = None

    def __call__(self, matrix: SymmetricMatrix, forces: sparse.csc_array) -> Floats:
        """Return FᵀA⁻¹F (k, k) of a matrix (n, n) and forces (n, k).

        Raises
        ------
        MemoryError
            MKL could not allocate the factor.
        """
        rows, size = matrix.size, forces.shape[1]
        upper, beside = matrix.scalar_upper(), sparse.csr_array(forces)
        upper.sort_indices()
        beside.sort_indices()
        ends = np.repeat(upper.indptr[1:], np.diff(beside.indptr))
        # Behind the rows of both, zeros on the diagonal.
        values = np.append(np.insert(upper.data, ends, beside.data), np.zeros(size))
        columns = np.append(np.insert(upper.indices, ends, rows + beside.indices), rows + np.arange(size))
        starts = np.append(upper.indptr + beside.indptr, len(values) - size + 1 + np.arange(size))
        parts = (values, starts.astype(np.int32), columns.astype(np.int32))
        last = np.zeros(rows + size, dtype=np.int32)
        last[rows:] = 1
        complement = np.zeros((size, size))
        for phase in (_FACTORISE,) if self._is_known(parts) else (_ANALYSE, _FACTORISE):
            self._run(phase, parts, last, complement)
        self._known = (parts, last)
        return -(complement + complement.T) / 2

    def _is_known(self, parts: Parts) -> bool:
        """Whether a matrix has the sparsity that was analysed; another one's analysis is released."""
        if self._known is None:
            return False
        if all(map(np.array_equal, parts[1:], self._known[0][1:])):
            return True
        self._release()
        return False

    def _release(self) -> None:
        if self._known is not None:
            parts, last = self._known
            self._run(_RELEASE, parts, last, np.zeros((len(last), 1)))
            self._known = None

    def _run(self, phase: int, parts: Parts, last: npt.NDArray[np.int32], complement: Floats) -> None:
        self._pardiso(phase, len(last), parts, np.zeros((len(last), 1)), complement, last=last)

    def __del__(self) -> None:
        """Release MKL's memory."""
        if hasattr(self, "_known") and not sys.is_finalizing():
            self._release()


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
