"""Solve for displacement and pressure with solvers for positive definite matrices.

The equations A u + Dᵀ p = f, D u − C p = g are symmetric but indefinite. Their Schur complement
S = D A⁻¹ Dᵀ + C is positive definite. As A does not contain λ, and if the elements are stable, a mass matrix
over the shear modulus is spectrally equivalent to S for every mesh size and Poisson's ratio. Conjugate
gradients need about twenty steps, each with one solution by the factor of A (Verfürth 1984; Benzi, Golub &
Liesen 2005, sections 5 and 10.1). Without a factor they would be nested iterations; instead, MINRES on the
whole system with a block preconditioner takes about sixty steps (Silvester & Wathen 1994).
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, minres

from fea.solid.errors import StagnationError
from fea.solvers.linear.amg import conjugate_gradients
from fea.solvers.linear.multigrid import chebyshev
from fea.solvers.linear.solver import Operator
from geometry.arrays import Floats

# Of the residual, in the norm of the preconditioner. Iterative refinement then improves the solution.
TOLERANCE = 1e-7
MOST_ITERATIONS = 600
_REMEDY = (
    "Use a smaller --size, so that the nearly incompressible part has at least two elements through its "
    "thickness"
)
# Eigenvalue bounds of the Jacobi-scaled mass matrix of linear tetrahedra (Wathen 1987), and the number of
# Chebyshev steps that reduce its condition number from 5 to 1.02.
_MASS_BOUNDS = (0.5, 2.5)
_MASS_STEPS = 5


@dataclass(frozen=True)
class Constraint:
    """The matrices that couple displacement and pressure."""

    #: D (n_pressures, n_displacements), without the columns of constrained displacements
    divergence: sparse.csr_array
    mass: sparse.csr_array  #: M (n_pressures, n_pressures)
    compliance: Floats  #: (n_pressures,) 1/λ: C = compliance · M; constant among coupled pressures
    scale: Floats  #: (n_pressures,) 1/(2 μ) + 1/λ: scale · M preconditions S

    def compressed(self, p: Floats) -> Floats:
        """C p."""
        return np.asarray(self.compliance[:, None] * (self.mass @ p))

    def decompressed(self, widths: Floats) -> Floats:
        """Approximate C⁻¹ times a residual of D u = C p: the pressures that cause it."""
        return np.asarray(self._over_mass(widths) / self.compliance[:, None])

    def precondition(self, residual: Floats) -> Floats:
        """Approximate (scale · M)⁻¹."""
        return np.asarray(self._over_mass(residual) / self.scale[:, None])

    def _over_mass(self, right: Floats) -> Floats:
        """M⁻¹ by a fixed number of Chebyshev steps (Wathen & Rees 2009)."""
        return chebyshev(self.mass.__matmul__, self.mass.diagonal(), right, _MASS_BOUNDS, _MASS_STEPS)


def solve_saddle(solve: Operator, constraint: Constraint, f: Floats, g: Floats) -> tuple[Floats, Floats]:
    """Solve A u + Dᵀ p = f, D u − C p = g with a factor of A, to the accuracy `TOLERANCE`.

    f (n_displacements, n_cases) is zero at constrained displacements; g is (n_pressures, n_cases). Raises
    `StagnationError`: the iteration does not converge: the mesh does not allow a stable pressure.
    """
    D = constraint.divergence

    def schur(p: Floats) -> Floats:
        return np.asarray(D @ solve(D.T @ p) + constraint.compressed(p))

    right = D @ solve(f) - g
    p = conjugate_gradients(schur, constraint.precondition, right, tolerance=TOLERANCE, remedy=_REMEDY)
    return solve(f - D.T @ p), p


def iterate_saddle(
    stiffness: Operator, precondition: Operator, constraint: Constraint, f: Floats, g: Floats
) -> tuple[Floats, Floats]:
    """Solve as `solve_saddle`, with A and an approximation of A⁻¹ in place of a factor.

    Both operators ignore constrained displacements.
    """
    D, n, right = constraint.divergence, len(f), np.concatenate([f, g])

    def whole(both: Floats) -> Floats:
        u, p = both[:n], both[n:]
        return np.concatenate([stiffness(u) + D.T @ p, D @ u - constraint.compressed(p)])

    def blocks(both: Floats) -> Floats:
        return np.concatenate([precondition(both[:n]), constraint.precondition(both[n:])])

    both = _minimal_residuals(whole, blocks, right)
    return both[:n], both[n:]


def _minimal_residuals(operator: Operator, precondition: Operator, right: Floats) -> Floats:
    """Solve for (n, k) right-hand sides (Paige & Saunders 1975) as one system of n k unknowns.

    Its spectrum is that of each, so the steps are about as many, and operators serve all columns at once.
    """
    first = precondition(right)
    sizes = np.sqrt((right * first).sum(axis=0))
    live = sizes > 0
    scaled = right[:, live] / sizes[live]
    if not scaled.size:
        return np.zeros_like(right)

    def on_all(times: Operator) -> LinearOperator:
        return LinearOperator(
            (scaled.size,) * 2, matvec=lambda v: times(v.reshape(scaled.shape)).ravel(), dtype=np.float64
        )

    # SciPy compares the residual's norm, that of the preconditioner, with the plain one of the solution, of
    # which the first step tells the size: so the tolerance is that of the residual in any units.
    tolerance = TOLERANCE * np.sqrt(scaled.shape[1]) / np.linalg.norm(first[:, live] / sizes[live])
    x, failed = minres(
        on_all(operator), scaled.ravel(), M=on_all(precondition), rtol=tolerance, maxiter=MOST_ITERATIONS
    )
    if failed:
        raise StagnationError(f"minimal residuals stagnated after {MOST_ITERATIONS} steps. {_REMEDY}")
    solved = np.zeros_like(right)
    solved[:, live] = x.reshape(scaled.shape) * sizes[live]
    return solved
