"""The interface of linear solvers, and direct ones.

MKL Pardiso through pypardiso, and CHOLMOD through cvxopt on a METIS order of the nodes (Schenk & Gärtner
2004; Chen, Davis, Hager & Rajamanickam 2008; Karypis & Kumar 1998).
"""

import ctypes
import importlib.metadata
import importlib.util
import os
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse

from fea.base.choices import SolverName
from fea.solid.assembly import SymmetricMatrix
from fea.solid.errors import SingularMatrixError, SolverUnavailableError
from geometry.arrays import Floats, Ints

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


_BLOCK = 3
_ANALYSE, _FACTORISE, _SOLVE, _RELEASE = 11, 22, 33, -1
# With a Schur block, forward and backward substitution by the factor of the leading block alone: the step
# between them, which solves with the Schur complement, is left out.
_FORWARD, _BACKWARD = 331, 333
_POSITIVE_DEFINITE = 2  # mtype: real, symmetric, upper triangle only
_NOT_POSITIVE_DEFINITE, _NO_MEMORY = -4, (-2, -9)
# MKL's options by place: these in place of the defaults, nested dissection in parallel, indices from zero.
_OPTIONS = {0: 1, 1: 3, 34: 1}
# Entries are counted; scheduling is on two levels; analysis works on nodes: a ninth of the graph.
_BY_NODES = {17: -1, 23: 1, 36: _BLOCK}
# The Schur complement, which need not be positive definite, is returned but not factorised.
_WITH_SCHUR = {35: 1}
# Right-hand sides that are solved for at once with a Schur block; new pages for more cost as much as is won.
_AT_ONCE = 32
# Values, starts of the rows and columns of a sparse matrix.
Parts = tuple[Floats, npt.NDArray[np.int32], npt.NDArray[np.int32]]


class _Handle:
    """MKL's `pardiso` for matrices of one sparsity, which is analysed once.

    It keeps `slots` factors without copies of the matrices, pypardiso's own functions keep one with a copy.
    `last` (n_rows,) is 1 for the rows of a Schur block.
    """

    def __init__(
        self,
        slots: int,
        options: dict[int, int],
        parts: Parts,
        last: npt.NDArray[np.int32] | None = None,
    ) -> None:
        self._library, self._slots = _library(), slots
        self._handle = np.zeros(64, dtype=np.int64)
        self._options = np.zeros(64, dtype=np.int32)
        for place, value in {**_OPTIONS, **options}.items():
            self._options[place] = value
        values, self._starts, self._columns = parts
        self._last = np.zeros(1, dtype=np.int32) if last is None else last
        self(_ANALYSE, 0, values)

    def __len__(self) -> int:
        """Number of rows, of blocks where the matrix has these."""
        return len(self._starts) - 1

    def has(self, parts: Parts) -> bool:
        """Whether a matrix has the sparsity that was analysed."""
        return np.array_equal(parts[1], self._starts) and np.array_equal(parts[2], self._columns)

    def __call__(
        self,
        phase: int,
        slot: int,
        values: Floats,
        right_hand_sides: Floats | None = None,
        solution: Floats | None = None,
    ) -> None:
        """Run a phase with (n, k) sides and solution; a Schur complement (k, k) replaces the latter."""
        status, nothing, rows = ctypes.c_int32(0), np.zeros((1, 1)), len(self)
        sides = nothing if right_hand_sides is None else right_hand_sides
        self._library.pardiso(
            _pointer(self._handle),
            *(_integer(value) for value in (self._slots, slot + 1, _POSITIVE_DEFINITE, phase, rows)),
            _pointer(values),
            *(_pointer(array) for array in (self._starts, self._columns, self._last)),
            _integer(sides.shape[1]),
            _pointer(self._options),
            _integer(0),
            _pointer(sides),
            _pointer(nothing if solution is None else solution),
            ctypes.byref(status),
        )
        if status.value == _NOT_POSITIVE_DEFINITE:
            raise SingularMatrixError(NOT_POSITIVE_DEFINITE)
        if status.value in _NO_MEMORY:
            message = f"Pardiso ran out of memory with {rows} rows. Use a larger --size or --solver amg"
            raise MemoryError(message)
        if status.value != 0:
            raise RuntimeError(f"Pardiso failed in phase {phase} with error {status.value}")

    def __del__(self) -> None:
        if hasattr(self, "_last") and not sys.is_finalizing():
            self(_RELEASE, 0, np.zeros(1))


def _pointer(array: npt.NDArray[Any]) -> Any:
    return array.ctypes.data_as(ctypes.POINTER(np.ctypeslib.as_ctypes_type(array.dtype)))


def _integer(value: int) -> Any:
    return ctypes.byref(ctypes.c_int32(value))


class Pardiso(LinearSolver):
    """Pardiso's factors of `slots` matrices with the same sparsity, which is analysed only once."""

    name = "pardiso"

    def __init__(self, slots: int) -> None:
        _library()
        self._slots = slots
        self._by_nodes: _Handle | None = None
        self._with_schur: _Handle | None = None
        self._solve: dict[int, Operator] = {}
        self._within: dict[int, tuple[_Handle, int, Floats, int]] = {}  # where the factor has a Schur block

    def factorise(self, slot: int, matrix: SymmetricMatrix) -> None:
        """Factorise into a slot (0…slots − 1). Raises `SingularMatrixError`; `MemoryError`: by MKL."""
        upper = matrix.upper
        if self._by_nodes is None:
            parts = (upper.data, upper.indptr, upper.indices)
            self._by_nodes = _Handle(self._slots, _BY_NODES, parts)
        self._by_nodes(_FACTORISE, slot, upper.data)
        self._solve[slot] = partial(_solved, self._by_nodes, slot, upper.data)
        self._within.pop(slot, None)

    def condense(self, slot: int, matrix: SymmetricMatrix, forces: sparse.csc_array) -> Floats:
        """Put a factor into a slot that leaves the columns of sparse forces to the end: see `LinearSolver`.

        It gives the Schur complement of [A F; Fᵀ 0] at a fraction of the cost of solutions for all columns,
        and solves with A as a Cholesky factor does. Raises the same errors as `factorise`.
        """
        n, size = forces.shape
        parts = _bordered(matrix, forces)
        if self._with_schur is None or not self._with_schur.has(parts):
            last = (np.arange(n + size) >= n).astype(np.int32)
            self._with_schur = _Handle(self._slots, _WITH_SCHUR, parts, last)
        complement = np.zeros((size, size))
        self._with_schur(_FACTORISE, slot, parts[0], solution=complement)
        within = self._within[slot] = self._with_schur, slot, parts[0], n
        self._solve[slot] = partial(_solved_within, *within)
        return -(complement + complement.T) / 2

    def solve(self, slot: int, right_hand_sides: Floats) -> Floats:
        """Solve for (n, k) right-hand sides with the factor in a slot."""
        return self._solve[slot](right_hand_sides)

    def solve_sums(self, slot: int, forces: sparse.csc_array, columns: Floats) -> Floats:
        """Solve for sums of condensed forces in half the time: see `LinearSolver`."""
        if slot not in self._within:
            return super().solve_sums(slot, forces, columns)
        return _solved_within(*self._within[slot], columns, summed=True)

    def work(self, slot: int, forces: Floats) -> Floats:
        """Work of forces in half the time of their solution: see `LinearSolver`."""
        within = self._within.get(slot)
        return super().work(slot, forces) if within is None else _work_within(*within, forces)


def _bordered(matrix: SymmetricMatrix, forces: sparse.csc_array) -> Parts:
    """The upper triangle of [A F; Fᵀ 0], with the zeros of its last diagonal."""
    n, size = forces.shape
    above, beside = matrix.scalar_upper(), sparse.csr_array(forces)
    beside.sort_indices()
    ends = np.append(np.repeat(above.indptr[1:], np.diff(beside.indptr)), np.full(size, above.nnz))
    values = np.insert(above.data, ends, np.append(beside.data, np.zeros(size)))
    columns = np.insert(above.indices, ends, n + np.append(beside.indices, np.arange(size)))
    starts = np.append(above.indptr + beside.indptr, len(values) - size + 1 + np.arange(size))
    return values, starts.astype(np.int32), columns.astype(np.int32)


def _solved(handle: _Handle, slot: int, values: Floats, right_hand_sides: Floats) -> Floats:
    sides = np.asfortranarray(right_hand_sides)
    solution = np.empty_like(sides)
    handle(_SOLVE, slot, values, sides, solution)
    return solution


def _solved_within(
    handle: _Handle, slot: int, values: Floats, n: int, columns: Floats, *, summed: bool = False
) -> Floats:
    """Solve A u = f with the leading block A (n, n) of the factor of [A F; Fᵀ 0].

    `columns` (n, k) are f; or with `summed` c (m, k) of f = F c, by backward substitution alone.
    """
    count = columns.shape[1]
    solution = np.empty((n, count), order="F")
    both = np.zeros((2, min(count, _AT_ONCE), len(handle))).swapaxes(1, 2)
    for start in range(0, count, _AT_ONCE):
        block = columns[:, start : start + _AT_ONCE]
        result, sides = both[..., : block.shape[1]]
        if summed:
            sides[n:] = -block
        else:
            result[:n], result[n:] = block, 0.0
            handle(_FORWARD, slot, values, result, sides)
            sides[n:] = 0.0
        handle(_BACKWARD, slot, values, sides, result)
        solution[:, start : start + _AT_ONCE] = result[:n]
    return solution


def _work_within(handle: _Handle, slot: int, values: Floats, n: int, forces: Floats) -> Floats:
    """FᵀA⁻¹F (k, k) of F (n, k), A = L Lᵀ, by forward substitution L⁻¹F."""
    halves = np.empty((forces.shape[1], n))
    for start in range(0, len(halves), _AT_ONCE):
        block = np.pad(forces[:, start : start + _AT_ONCE].T, [(0, 0), (0, len(handle) - n)]).T
        result = np.empty_like(block)
        handle(_FORWARD, slot, values, block, result)
        halves[start : start + _AT_ONCE] = result[:n].T
    return np.asarray(halves @ halves.T)


def _library() -> Any:
    _point_at_mkl()
    from pypardiso.pardiso_wrapper import PyPardisoSolver  # noqa: PLC0415 - MKL is heavy and optional

    return PyPardisoSolver(mtype=_POSITIVE_DEFINITE).libmkl


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


_SUPERNODAL = 2


class Cholmod(LinearSolver):
    """CHOLMOD's factors of matrices of one sparsity. Raises `ImportError`: cvxopt or pymetis is missing."""

    name = "cholmod"

    def __init__(self) -> None:
        import cvxopt.cholmod  # noqa: PLC0415 - optional

        self._cvxopt = cvxopt
        cvxopt.cholmod.options["supernodal"] = _SUPERNODAL
        self._order: Any = None
        self._factors: dict[int, Any] = {}

    def factorise(self, slot: int, matrix: SymmetricMatrix) -> None:
        """Factorise `matrix` into a slot. Raises `SingularMatrixError`: it is not positive definite."""
        dense = self._cvxopt.matrix
        if self._order is None:
            self._order = dense(node_order(matrix))
        upper = matrix.scalar_upper()
        # The upper triangle by rows is the lower one by columns.
        columns = np.repeat(np.arange(matrix.size), np.diff(upper.indptr))
        parts = upper.data, upper.indices.astype(np.int64), columns
        lower = self._cvxopt.spmatrix(*map(dense, parts), upper.shape)
        factor = self._cvxopt.cholmod.symbolic(lower, p=self._order, uplo="L")
        try:
            self._cvxopt.cholmod.numeric(lower, factor)
        except ArithmeticError as error:
            raise SingularMatrixError(NOT_POSITIVE_DEFINITE) from error
        self._factors[slot] = factor

    def solve(self, slot: int, right_hand_sides: Floats) -> Floats:
        """Solve for (n, k) right-hand sides with the factor in a slot."""
        solution = self._cvxopt.matrix(np.asfortranarray(right_hand_sides))
        self._cvxopt.cholmod.solve(self._factors[slot], solution)
        return np.array(solution)


def node_order(matrix: SymmetricMatrix) -> Ints:
    """Nested-dissection order (n_dofs,) of a matrix, from METIS.

    Ordering nodes instead of degrees of freedom works on a graph with a ninth of the edges.
    """
    from pymetis import CSRAdjacency, nested_dissection  # noqa: PLC0415 - optional

    upper = matrix.upper
    n_nodes = matrix.size // 3
    ones = np.ones(upper.indices.size, dtype=np.int8)
    blocks = sparse.csr_array((ones, upper.indices, upper.indptr), shape=(n_nodes, n_nodes))
    graph = sparse.csr_array(blocks + blocks.T)
    graph.setdiag(0)
    graph.eliminate_zeros()
    order, _ = nested_dissection(CSRAdjacency(graph.indptr.astype(np.int32), graph.indices.astype(np.int32)))
    return (3 * np.asarray(order)[:, None] + np.arange(3)).ravel().astype(np.int64)


_PACKAGES = {SolverName.PARDISO: ("pypardiso",), SolverName.CHOLMOD: ("cvxopt", "pymetis")}


def direct() -> SolverName:
    """Return the name of the direct solver available on this machine."""
    return SolverName.PARDISO if importlib.util.find_spec("pypardiso") else SolverName.CHOLMOD


def direct_solver(slots: int, choice: SolverName = SolverName.AUTO) -> LinearSolver:
    """Return the named direct solver, or this machine's. Raises `SolverUnavailableError`: not installed."""
    choice = choice if choice in _PACKAGES else direct()
    for package in _PACKAGES[choice]:
        if importlib.util.find_spec(package) is None:
            message = (
                f"solver {choice} is not available, because the package {package} is not installed. "
                f"Install it (pip install {package}) or choose another --solver"
            )
            raise SolverUnavailableError(message)
    return Pardiso(slots) if choice is SolverName.PARDISO else Cholmod()


def factorise(matrix: SymmetricMatrix, choice: SolverName = SolverName.AUTO) -> Operator:
    """Factorise by `direct_solver` for (n, k) sides; `SingularMatrixError`: not positive definite."""
    solver = direct_solver(1, choice)
    solver.factorise(0, matrix)
    return partial(solver.solve, 0)
