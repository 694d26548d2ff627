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
# Values, starts of the rows and columns of a sparse matrix.
Parts = tuple[Floats, npt.NDArray[np.int32], npt.NDArray[np.int32]]


class PardisoCholesky:
    """Cholesky factors of `slots` matrices with the same sparsity, which is analysed only once.

    pypardiso's own functions keep one factor and copy its matrix; this class keeps several without copies.
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

    def _call(self, phase: int, slot: int, upper: Any, right_hand_sides: Floats) -> Floats:
        solution = np.empty_like(right_hand_sides)
        _call(
            (self._pardiso, self._handle, self._options),
            phase,
            kind=_POSITIVE_DEFINITE,
            slots=(self._slots, slot + 1),
            rows=upper.shape[0] // _BLOCK,
            parts=(upper.data, upper.indptr, upper.indices),
            right_hand_sides=right_hand_sides,
            solution=solution,
        )
        return solution

    def __del__(self) -> None:
        """Release MKL's memory."""
        if getattr(self, "_matrices", None) and not sys.is_finalizing():
            upper = next(iter(self._matrices.values()))
            self._call(_RELEASE, 0, upper, np.zeros((upper.shape[0], 1)))


class PardisoSchur:
    """Schur complements FᵀA⁻¹F of positive definite matrices A; the same sparsity is analysed once.

    A factorisation that leaves the columns of sparse F to the end gives them at a fraction of the cost of
    solutions for all columns, because it exploits what each of them does not reach.
    """

    def __init__(self) -> None:
        self._pardiso = _library()
        self._handle = np.zeros(64, dtype=np.int64)
        self._options = np.zeros(64, dtype=np.int32)
        self._options[0] = 1  # these options, not the defaults
        self._options[1] = 3  # nested dissection in parallel
        self._options[9] = 8  # pivots below 1e-8 of the norm are perturbed
        self._options[20] = 1  # pivots of order two
        self._options[34] = 1  # indices from zero
        self._options[35] = 1  # return the Schur complement
        self._known: tuple[Parts, npt.NDArray[np.int32]] | None = None

    def __call__(self, matrix: SymmetricMatrix, forces: sparse.csc_array) -> Floats:
        """Return FᵀA⁻¹F (k, k) of a matrix (n, n) and forces (n, k).

        Raises
        ------
        MemoryError
            MKL could not allocate the factor.
        """
        own, size = matrix.size, forces.shape[1]
        upper, beside = matrix.scalar_upper(), sparse.csr_array(forces)
        upper.sort_indices()
        beside.sort_indices()
        ends = np.repeat(upper.indptr[1:], np.diff(beside.indptr))
        # Behind the rows of both, zeros on the diagonal.
        values = np.append(np.insert(upper.data, ends, beside.data), np.zeros(size))
        columns = np.append(np.insert(upper.indices, ends, own + beside.indices), own + np.arange(size))
        starts = np.append(upper.indptr + beside.indptr, len(values) - size + 1 + np.arange(size))
        parts = (values, starts.astype(np.int32), columns.astype(np.int32))
        last = np.zeros(own + size, dtype=np.int32)
        last[own:] = 1
        found = np.zeros((size, size))
        for phase in (_FACTORISE,) if self._is_known(parts) else (_ANALYSE, _FACTORISE):
            self._run(phase, parts, last, found)
        self._known = (parts, last)
        return -(found + found.T) / 2

    def _is_known(self, parts: Parts) -> bool:
        """Whether a matrix has the sparsity that was analysed; another one's analysis is released."""
        if self._known is None:
            return False
        known, last = self._known
        if all(np.array_equal(own, other) for own, other in zip(parts[1:], known[1:], strict=True)):
            return True
        self._run(_RELEASE, known, last, np.zeros((len(last), 1)))
        self._known = None
        return False

    def _run(self, phase: int, parts: Parts, last: npt.NDArray[np.int32], found: Floats) -> None:
        _call(
            (self._pardiso, self._handle, self._options),
            phase,
            kind=_INDEFINITE,
            slots=(1, 1),
            rows=len(last),
            parts=parts,
            right_hand_sides=np.zeros((len(last), 1)),
            solution=found,
            last=last,
        )

    def __del__(self) -> None:
        """Release MKL's memory."""
        known = getattr(self, "_known", None)
        if known and not sys.is_finalizing():
            parts, last = known
            self._run(_RELEASE, parts, last, np.zeros((len(last), 1)))


def _call(
    handles: tuple[Any, npt.NDArray[np.int64], npt.NDArray[np.int32]],
    phase: int,
    *,
    kind: int,
    slots: tuple[int, int],
    rows: int,
    parts: Parts,
    right_hand_sides: Floats,
    solution: Floats,
    last: npt.NDArray[np.int32] | None = None,
) -> None:
    """Run a phase of MKL's `pardiso`.

    Parameters
    ----------
    handles
        The library, its handle and options.
    phase, kind
        What to do, and the type of the matrix.
    slots
        How many factors there are, and which one is meant.
    rows, parts
        Number of (block) rows, and the matrix: values, starts of the rows, columns.
    right_hand_sides, solution
        (n, k); a Schur complement takes the place of the solution.
    last
        (rows,) 1 for the rows of the Schur complement.
    """
    library, handle, options = handles
    status = ctypes.c_int32(0)

    def integer(value: int) -> Any:
        return ctypes.byref(ctypes.c_int32(value))

    def integers(array: npt.NDArray[np.int32]) -> Any:
        return array.ctypes.data_as(ctypes.POINTER(ctypes.c_int32))

    def doubles(array: Floats) -> Any:
        return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))

    values, starts, columns = parts
    library(
        handle.ctypes.data_as(ctypes.POINTER(ctypes.c_int64)),
        integer(slots[0]),
        integer(slots[1]),
        integer(kind),
        integer(phase),
        integer(rows),
        doubles(values),
        integers(starts),
        integers(columns),
        integers(np.zeros(1, dtype=np.int32) if last is None else last),
        integer(right_hand_sides.shape[1]),
        integers(options),
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
            f"Pardiso ran out of memory with {len(starts) - 1} rows. Use a larger --size or --solver amg"
        )
        raise MemoryError(message)
    if status.value != 0:
        message = f"Pardiso failed in phase {phase} with error {status.value}"
        raise RuntimeError(message)


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
