"""Conjugate gradients with two-level p-multigrid, for models whose factor does not fit into memory.

The coarse level consists of the linear functions on the same curved cells, which the quadratic functions
contain: its Galerkin matrix has an eighth of the degrees of freedom and is factorised. Chebyshev polynomials
smooth the error that linear functions cannot represent (p-multigrid: Helenbrook, Mavriplis & Atkins 2003;
smoother: Adams, Brezina, Hu & Tuminaro 2003). The number of iterations does not grow with the mesh.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from fea.base.material import Material, Materials
from fea.solid.assembly import SymmetricMatrix, linear_stiffness
from fea.solvers.linear.amg import TOLERANCE, conjugate_gradients
from fea.solvers.linear.solver import LinearSolver
from geometry.arrays import Floats, Ints
from mesh.tetmesh import EDGES, TetMesh


def chebyshev(
    operator: Callable[[Floats], Floats],
    diagonal: Floats,
    right_hand_sides: Floats,
    bounds: tuple[float, float],
    steps: int,
) -> Floats:
    """Approximate A⁻¹ b, starting from zero, by a symmetric linear operator (Saad 2003, algorithm 12.1).

    A is scaled by its diagonal (n,), D; the eigenvalues of D⁻¹A within the bounds are damped by a polynomial
    of degree `steps` − 1. The right-hand sides are (n, k).
    """
    low, high = bounds
    middle, half = (high + low) / 2, (high - low) / 2
    inverse = 1 / diagonal[:, None]
    ratio = rho = half / middle
    step = inverse * right_hand_sides / middle
    x = step.copy()
    for _ in range(steps - 1):
        last, rho = rho, 1 / (2 / ratio - rho)
        step = rho * last * step + (2 * rho / half) * inverse * (right_hand_sides - operator(x))
        x += step
    return np.asarray(x)


# The Chebyshev polynomial damps the upper part of the spectrum of D⁻¹K; the coarse level handles the rest.
_STEPS = 2
_DAMPED_SHARE = 1 / 8
_POWER_STEPS = 15
_SAFETY = 1.1  # power iteration approaches the largest eigenvalue from below


class Multigrid(LinearSolver):
    """Conjugate gradients preconditioned on two levels, with the interface of the direct solvers.

    The mesh is of second order; `factorise` returns what solves directly on the coarse level.
    """

    name = "amg"

    def __init__(
        self,
        mesh: TetMesh,
        material: Material | Materials,
        factorise: Callable[[SymmetricMatrix], Callable[[Floats], Floats]],
    ) -> None:
        self._factorise = factorise
        self._vertices, self._interpolation = _interpolation(mesh.tets, len(mesh.points))
        self._coarse = linear_stiffness(mesh, material)
        self._levels: dict[int, _Levels] = {}

    def factorise(self, slot: int, matrix: SymmetricMatrix) -> None:
        """Prepare to solve. Raises `SingularMatrixError`: the coarse matrix is not positive definite."""
        free = (matrix.row_sums != matrix.diagonal()).reshape(-1, 3)
        held = ~free[self._vertices]
        solve = self._factorise(self._coarse.constrained(held.ravel()))
        # Constrained degrees of freedom stay zero.
        kept, coarse = (sparse.diags_array(mask.ravel().astype(float)) for mask in (free, ~held))
        prolong = sparse.csr_array(kept @ sparse.kron(self._interpolation, np.eye(3)) @ coarse)
        largest = _largest_eigenvalue(matrix)
        self._levels[slot] = _Levels(matrix, prolong, matrix.diagonal(), solve, largest)

    def solve(self, slot: int, right_hand_sides: Floats) -> Floats:
        """Solve for (n, k) right-hand sides. Raises `StagnationError`: the residual exceeds `TOLERANCE`."""
        levels = self._levels[slot]
        return conjugate_gradients(
            levels.matrix.__matmul__,
            levels.precondition,
            right_hand_sides,
            tolerance=TOLERANCE,
            remedy="Choose --solver pardiso, or a mesh with better elements",
        )

    def precondition(self, slot: int, residual: Floats) -> Floats:
        """Apply the approximate inverse of the matrix in a slot to (n, k) residuals."""
        return self._levels[slot].precondition(residual)


@dataclass(frozen=True)
class _Levels:
    matrix: SymmetricMatrix
    prolong: sparse.csr_array  #: from linear functions to quadratic ones
    diagonal: Floats
    coarse_solve: Callable[[Floats], Floats]
    largest: float

    def precondition(self, residual: Floats) -> Floats:
        """Smooth, correct on the coarse level, smooth: symmetric, as conjugate gradients require."""
        u = self._smoothed(residual)
        left = self.prolong.T @ (residual - self.matrix @ u)
        u += self.prolong @ self.coarse_solve(left)
        return u + self._smoothed(residual - self.matrix @ u)

    def _smoothed(self, residual: Floats) -> Floats:
        bounds = _DAMPED_SHARE * self.largest, _SAFETY * self.largest
        return chebyshev(self.matrix.__matmul__, self.diagonal, residual, bounds, _STEPS)


def _interpolation(tets: Ints, n_points: int) -> tuple[Ints, sparse.csr_array]:
    """Vertex nodes, and the weights (n_nodes, n_vertices) of linear functions at all nodes."""
    vertices = np.unique(tets[:, :4])
    number = np.zeros(n_points, dtype=np.int64)
    number[vertices] = np.arange(len(vertices))
    middles, first = np.unique(tets[:, 4:], return_index=True)
    ends = number[tets[:, EDGES].reshape(-1, 2)[first]]
    rows = np.concatenate([vertices, np.repeat(middles, 2)])
    columns = np.concatenate([number[vertices], ends.ravel()])
    weights = np.concatenate([np.ones(len(vertices)), np.full(ends.size, 0.5)])
    shape = (n_points, len(vertices))
    return vertices, sparse.csr_array(sparse.coo_array((weights, (rows, columns)), shape=shape))


def _largest_eigenvalue(matrix: SymmetricMatrix) -> float:
    """Largest eigenvalue of D⁻¹K, by power iteration on its symmetric form."""
    root = np.sqrt(matrix.diagonal())
    vector = np.random.default_rng(0).standard_normal(matrix.size)
    value = 1.0
    for _ in range(_POWER_STEPS):
        image = (matrix @ (vector / root)) / root
        value = float(np.linalg.norm(image) / np.linalg.norm(vector))
        vector = image / value
    return value
