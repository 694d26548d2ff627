"""Cholesky factors by CHOLMOD (Chen et al. 2008) through cvxopt, on a METIS order of the nodes."""

from typing import Any

import numpy as np
from scipy import sparse

from fea.solid.assembly import SymmetricMatrix
from fea.solid.errors import SingularMatrixError
from fea.solvers.linear.solver import NOT_POSITIVE_DEFINITE, LinearSolver
from geometry.arrays import Floats, Ints

_SUPERNODAL = 2


class CholmodCholesky(LinearSolver):
    """Cholesky factors of matrices of one sparsity. Raises `ImportError`: cvxopt or pymetis is missing."""

    name = "cholmod"

    def __init__(self) -> None:
        from cvxopt import cholmod  # noqa: PLC0415 - optional

        self._cholmod = cholmod
        cholmod.options["supernodal"] = _SUPERNODAL
        self._order: Any = None
        self._factors: dict[int, Any] = {}

    def factorise(self, slot: int, matrix: SymmetricMatrix) -> None:
        """Factorise `matrix` into a slot. Raises `SingularMatrixError`: it is not positive definite."""
        from cvxopt import matrix as dense  # noqa: PLC0415
        from cvxopt import spmatrix  # noqa: PLC0415

        if self._order is None:
            self._order = dense(node_order(matrix))
        upper = matrix.scalar_upper()
        # The upper triangle by rows is the lower one by columns.
        columns = np.repeat(np.arange(matrix.size), np.diff(upper.indptr))
        lower = spmatrix(
            dense(upper.data), dense(upper.indices.astype(np.int64)), dense(columns), upper.shape
        )
        factor = self._cholmod.symbolic(lower, p=self._order, uplo="L")
        try:
            self._cholmod.numeric(lower, factor)
        except ArithmeticError as error:
            raise SingularMatrixError(NOT_POSITIVE_DEFINITE) from error
        self._factors[slot] = factor

    def solve(self, slot: int, right_hand_sides: Floats) -> Floats:
        """Solve for (n, k) right-hand sides with the factor in a slot."""
        from cvxopt import matrix as dense  # noqa: PLC0415

        solution = dense(np.asfortranarray(right_hand_sides))
        self._cholmod.solve(self._factors[slot], solution)
        return np.array(solution)


def node_order(matrix: SymmetricMatrix) -> Ints:
    """Nested-dissection order (n_dofs,) of a matrix, from METIS (Karypis & Kumar 1998).

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
