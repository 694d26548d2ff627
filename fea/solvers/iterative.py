"""Conjugate gradients preconditioned by multigrid, for models whose factor does not fit into memory.

On second-order meshes: two-level p-multigrid. The coarse level consists of the linear functions on the same
curved cells, which the quadratic functions contain: its Galerkin matrix has an eighth of the degrees of
freedom and is factorised. Chebyshev polynomials smooth the error that linear functions cannot represent
(p-multigrid: Helenbrook, Mavriplis & Atkins 2003; smoother: Adams, Brezina, Hu & Tuminaro 2003). The number
of iterations does not grow with the mesh.

On first-order meshes, which have no such coarse level: smoothed aggregation (Vaněk, Mandel & Brezina 1996) by
pyamg, on 3×3 node blocks with the six rigid modes as near-null space. On second-order meshes of 93 000 and
166 000 degrees of freedom it took four and seven times as long as p-multigrid and three times the memory.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, cg

from fea.base.material import Material, Materials
from fea.solid.assembly import SymmetricMatrix, linear_stiffness
from fea.solid.element import linear_interpolation
from fea.solid.errors import StagnationError
from fea.solid.supports import rigid_modes
from fea.solvers.direct import factorise
from fea.solvers.linear_solver import LinearSolver, Operator
from geometry.arrays import Floats, Mask
from mesh.tetmesh import TetMesh

# Of stiffness matrices: far below any discretisation error.
TOLERANCE = 1e-8
MOST_ITERATIONS = 300


def stacked(operator: Operator, shape: tuple[int, ...]) -> LinearOperator:
    """Return an operator on blocks of vectors (n, k) as one on their n k entries.

    Its spectrum is that of the operator, so that a Krylov method takes about as many steps, each of which
    serves all columns at once.
    """
    size = int(np.prod(shape))
    return LinearOperator((size, size), lambda v: operator(v.reshape(shape)).ravel(), dtype=np.float64)


def conjugate_gradients(
    operator: Operator, precondition: Operator, right_hand_sides: Floats, *, tolerance: float, remedy: str
) -> Floats:
    """Solve A x = b for (n, k) right-hand sides, each scaled to unit length (Hestenes & Stiefel 1952).

    The operator and its approximate inverse are symmetric and positive definite. The tolerance is that of the
    residual relative to b. Raises `StagnationError`: a residual did not reach the tolerance; the message ends
    with the remedy.
    """
    sizes = np.linalg.norm(right_hand_sides, axis=0)
    loaded = sizes > 0
    scaled, solution = right_hand_sides[:, loaded] / sizes[loaded], np.zeros_like(right_hand_sides)
    if not scaled.size:
        return solution
    preconditioner = stacked(precondition, scaled.shape)
    limits = {"rtol": tolerance, "maxiter": MOST_ITERATIONS}
    x, failed = cg(stacked(operator, scaled.shape), scaled.ravel(), M=preconditioner, **limits)
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
        self._mesh = mesh
        self._preconditioners: dict[int, tuple[SymmetricMatrix, Operator]] = {}
        if mesh.order == 2:
            self._vertices, self._interpolation = linear_interpolation(mesh.tets, len(mesh.points))
            self._coarse = linear_stiffness(mesh, material)

    def factorise(self, slot: int, matrix: SymmetricMatrix) -> None:
        """Prepare to solve. Raises `SingularMatrixError`: the coarse matrix is not positive definite."""
        free = matrix.row_sums != matrix.diagonal()  # other rows have only their diagonal entry
        levels = self._two_levels(matrix, free).precondition if self._mesh.order == 2 else None
        self._preconditioners[slot] = matrix, levels or _aggregation(self._mesh.points, matrix, free)

    def _two_levels(self, matrix: SymmetricMatrix, free: Mask) -> "_TwoLevels":
        coarse_free = free.reshape(-1, 3)[self._vertices].ravel()
        solve = factorise(self._coarse.constrained(~coarse_free))
        # Constrained degrees of freedom stay zero.
        kept, coarse = (sparse.diags_array(mask.astype(float)) for mask in (free, coarse_free))
        prolong = sparse.csr_array(kept @ sparse.kron(self._interpolation, np.eye(3)) @ coarse)
        return _TwoLevels(matrix, prolong, matrix.diagonal(), solve, _largest_eigenvalue(matrix))

    def solve(self, slot: int, right_hand_sides: Floats) -> Floats:
        """Solve for (n, k) right-hand sides. Raises `StagnationError`: the residual exceeds `TOLERANCE`."""
        matrix, precondition = self._preconditioners[slot]
        return conjugate_gradients(
            matrix.__matmul__,
            precondition,
            right_hand_sides,
            tolerance=TOLERANCE,
            remedy="Choose --solver pardiso, or a mesh with better elements",
        )

    def precondition(self, slot: int, residual: Floats) -> Floats:
        """Apply the approximate inverse of the matrix in a slot to (n, k) residuals."""
        return self._preconditioners[slot][1](residual)


def _aggregation(points: Floats, matrix: SymmetricMatrix, free: Mask) -> Operator:
    """Return a cycle of smoothed aggregation on the rigid modes of points (n_nodes, 3)."""
    from pyamg import smoothed_aggregation_solver  # noqa: PLC0415 - only large models need it

    smoother = ("block_gauss_seidel", {"sweep": "symmetric"})
    hierarchy = smoothed_aggregation_solver(
        sparse.bsr_matrix(matrix.full()),
        B=np.where(free[:, None], rigid_modes(points).reshape(-1, 6), 0.0),
        strength=("symmetric", {"theta": 0.02}),
        smooth=("jacobi", {"omega": 4.0 / 3.0}),
        improve_candidates=None,
        presmoother=smoother,
        postsmoother=smoother,
        max_coarse=300,
        symmetry="symmetric",
    )
    cycle: Operator = hierarchy.aspreconditioner().matmat
    return cycle


# The Chebyshev polynomial damps the upper part of the spectrum of D⁻¹K; the coarse level handles the rest.
_STEPS = 2
_DAMPED_SHARE = 1 / 8
_POWER_STEPS = 15
_SAFETY = 1.1  # power iteration approaches the largest eigenvalue from below


@dataclass(frozen=True)
class _TwoLevels:
    matrix: SymmetricMatrix
    prolong: sparse.csr_array  #: from linear functions to quadratic ones
    diagonal: Floats  #: of the matrix
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
        return chebyshev(self.matrix.__matmul__, self.diagonal, residual, bounds, _STEPS)


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
    """Largest eigenvalue of D⁻¹K, by power iteration on its symmetric form."""
    root = np.sqrt(matrix.diagonal())
    vector = np.random.default_rng(0).standard_normal(matrix.size)
    value = 1.0
    for _ in range(_POWER_STEPS):
        image = (matrix @ (vector / root)) / root
        value = float(np.linalg.norm(image) / np.linalg.norm(vector))
        vector = image / value
    return value
