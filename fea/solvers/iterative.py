"""Conjugate gradients preconditioned by multigrid, for models whose factor does not fit into memory.

Two-level p-multigrid on second-order meshes. The coarse level consists of the linear functions on the same
curved cells, which the quadratic functions contain: its Galerkin matrix has an eighth of the degrees of
freedom and is factorised. Chebyshev polynomials smooth the error that linear functions cannot represent
(p-multigrid: Helenbrook, Mavriplis & Atkins 2003; smoother: Adams, Brezina, Hu & Tuminaro 2003). The number
of iterations does not grow with the mesh.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, cg, eigsh

from fea.base.material import Material, Materials
from fea.solid.assembly import SymmetricMatrix, linear_interpolation, linear_stiffness
from fea.solid.errors import StagnationError
from fea.solvers.direct import LinearSolver, Operator, factorise
from geometry.arrays import Floats
from mesh.tetmesh import TetMesh

# Of stiffness matrices: far below any discretisation error.
TOLERANCE = 1e-8
MOST_ITERATIONS = 300


def conjugate_gradients(
    operator: Operator, precondition: Operator, right_hand_sides: Floats, *, tolerance: float, remedy: str
) -> Floats:
    """Solve A x = b for (n, k) right-hand sides, each scaled to unit length (Hestenes & Stiefel 1952).

    The operator and its approximate inverse are symmetric and positive definite. All columns are one system
    of n k unknowns, which has the spectrum of the operator: it takes about as many steps, each of which
    serves all columns. The tolerance is that of the residual relative to b. Raises `StagnationError`: a
    residual did not reach the tolerance; the message ends with the remedy.
    """
    sizes = np.linalg.norm(right_hand_sides, axis=0)
    loaded = sizes > 0
    scaled, solution = right_hand_sides[:, loaded] / sizes[loaded], np.zeros_like(right_hand_sides)
    if not scaled.size:
        return solution
    A, M = (
        LinearOperator((scaled.size,) * 2, lambda v, of=of: of(v.reshape(scaled.shape)).ravel(), dtype=float)
        for of in (operator, precondition)
    )
    x, failed = cg(A, scaled.ravel(), M=M, rtol=tolerance, maxiter=MOST_ITERATIONS)
    x = x.reshape(scaled.shape)
    if failed:
        residual = np.linalg.norm(scaled - operator(x)) / np.linalg.norm(scaled)
        at = f"at a relative residual of {residual:.1e} after {MOST_ITERATIONS} steps"
        raise StagnationError(f"conjugate gradients stagnated {at}. {remedy}")
    solution[:, loaded] = x * sizes[loaded]
    return solution


class Multigrid(LinearSolver):
    """Preconditioned conjugate gradients with the interface of the direct solvers."""

    name = "amg"

    def __init__(self, mesh: TetMesh, material: Material | Materials) -> None:
        self._vertices, self._interpolation = linear_interpolation(mesh.tets, len(mesh.points))
        self._coarse = linear_stiffness(mesh, material)
        self._levels: dict[int, _TwoLevels] = {}

    def factorise(self, slot: int, matrix: SymmetricMatrix) -> None:
        """Prepare to solve. Raises `SingularMatrixError`: the coarse matrix is not positive definite."""
        free = matrix.row_sums != matrix.diagonal()  # other rows have only their diagonal entry
        coarse_free = free.reshape(-1, 3)[self._vertices].ravel()
        solve = factorise(self._coarse.constrained(~coarse_free))
        # Constrained degrees of freedom stay zero.
        kept, coarse = (sparse.diags_array(mask.astype(float)) for mask in (free, coarse_free))
        prolong = sparse.csr_array(kept @ sparse.kron(self._interpolation, np.eye(3)) @ coarse)
        self._levels[slot] = _TwoLevels(matrix, prolong, solve, _largest_eigenvalue(matrix))

    def solve(self, slot: int, right_hand_sides: Floats) -> Floats:
        """Solve for (n, k) right-hand sides. Raises `StagnationError`: the residual exceeds `TOLERANCE`."""
        levels, remedy = self._levels[slot], "Choose --solver pardiso, or a mesh with better elements"
        K, precondition = levels.matrix.__matmul__, levels.precondition
        return conjugate_gradients(K, precondition, right_hand_sides, tolerance=TOLERANCE, remedy=remedy)


# The Chebyshev polynomial damps the upper part of the spectrum of D⁻¹K; the coarse level handles the rest.
_STEPS = 2
_DAMPED_SHARE = 1 / 8
_ACCURACY, _SAFETY = 0.05, 1.1  # Lanczos' method approaches the largest eigenvalue from below


@dataclass(frozen=True)
class _TwoLevels:
    matrix: SymmetricMatrix
    prolong: sparse.csr_array  #: from linear functions to quadratic ones
    coarse_solve: Operator
    largest: float  #: eigenvalue of the matrix scaled by its diagonal

    def precondition(self, residual: Floats) -> Floats:
        """Smooth, correct on the coarse level, smooth: symmetric, as conjugate gradients require."""
        u = self._smoothed(residual)
        left = self.prolong.T @ (residual - self.matrix @ u)
        u += self.prolong @ self.coarse_solve(left)
        return u + self._smoothed(residual - self.matrix @ u)

    def _smoothed(self, residual: Floats) -> Floats:
        bounds = _DAMPED_SHARE * self.largest, _SAFETY * self.largest
        return chebyshev(self.matrix.__matmul__, self.matrix.diagonal(), residual, bounds, _STEPS)


def chebyshev(
    operator: Operator,
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


def _largest_eigenvalue(matrix: SymmetricMatrix) -> float:
    """Largest eigenvalue of D⁻¹K, of its symmetric form."""
    root = np.sqrt(matrix.diagonal())
    scaled = LinearOperator((matrix.size,) * 2, lambda v: (matrix @ (v / root)) / root, dtype=float)
    start = np.random.default_rng(0).standard_normal(matrix.size)
    return float(eigsh(scaled, 1, which="LA", v0=start, tol=_ACCURACY, return_eigenvectors=False)[0])
