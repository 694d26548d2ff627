"""Conjugate gradients preconditioned by smoothed aggregation, for first-order models too large to factorise.

Vaněk, Mandel & Brezina (1996) through pyamg, on 3×3 node blocks with the six rigid modes as near-null space.
"""

from typing import Any

import numpy as np
from scipy import sparse

from fea.solid.assembly import SymmetricMatrix
from fea.solid.errors import StagnationError
from fea.solid.supports import rigid_modes
from fea.solvers.linear.solver import LinearSolver, Operator
from geometry.arrays import Floats

# For stiffness matrices: far below any discretisation error.
TOLERANCE = 1e-8
MOST_ITERATIONS = 300


def conjugate_gradients(
    operator: Operator, precondition: Operator, right_hand_sides: Floats, *, tolerance: float, remedy: str
) -> Floats:
    """Solve A x = b for (n, k) right-hand sides (Hestenes & Stiefel 1952), iterated independently.

    The operator is applied to all vectors that have not converged together, so that a matrix is read from
    memory once per iteration. It and its approximate inverse are symmetric and positive definite. The
    tolerance is that of the residual in the preconditioner's norm, relative to that of b: roughly the error
    in energy. Raises `StagnationError`: a residual did not reach the tolerance; the message ends with the
    remedy.
    """
    x = np.zeros_like(right_hand_sides)
    active = np.flatnonzero(right_hand_sides.any(axis=0))
    residual = right_hand_sides[:, active].copy()
    direction = np.zeros_like(residual)
    energy, goal = np.ones(len(active)), np.zeros(len(active))
    for iteration in range(MOST_ITERATIONS + 1):
        preconditioned = precondition(residual) if active.size else residual
        last, energy = energy, (residual * preconditioned).sum(axis=0)
        if iteration == 0:
            goal = tolerance**2 * energy
        going = ~(energy <= goal)
        if not going.any():
            return x
        if iteration == MOST_ITERATIONS:
            break
        active, goal, last, energy = active[going], goal[going], last[going], energy[going]
        vectors = residual, direction, preconditioned
        residual, direction, preconditioned = (each[:, going] for each in vectors)
        direction = preconditioned + direction * (energy / last)
        image = operator(direction)
        step = energy / (direction * image).sum(axis=0)
        x[:, active] += step * direction
        residual -= step * image
    reached = tolerance * float(np.sqrt((energy / goal).max()))
    at = f"at a relative residual of {reached:.1e} after {iteration} steps"
    raise StagnationError(f"conjugate gradients stagnated {at}. {remedy}")


class SmoothedAggregation(LinearSolver):
    """Preconditioned conjugate gradients as a solver; the rigid modes are those of points (n_nodes, 3)."""

    name = "amg"

    def __init__(self, points: Floats) -> None:
        self._modes = rigid_modes(points).reshape(-1, 6)
        self._hierarchies: dict[int, Any] = {}

    def factorise(self, slot: int, matrix: SymmetricMatrix) -> None:
        """Build the hierarchy of `matrix` in a slot."""
        from pyamg import smoothed_aggregation_solver  # noqa: PLC0415 - only large models need it

        full = sparse.bsr_matrix(matrix.full())
        fixed = np.equal(matrix.row_sums, matrix.diagonal())  # rows that have their diagonal entry alone
        modes = np.where(fixed[:, None], 0.0, self._modes)
        self._hierarchies[slot] = smoothed_aggregation_solver(
            full,
            B=modes,
            strength=("symmetric", {"theta": 0.02}),
            smooth=("jacobi", {"omega": 4.0 / 3.0}),
            improve_candidates=None,
            presmoother=("block_gauss_seidel", {"sweep": "symmetric"}),
            postsmoother=("block_gauss_seidel", {"sweep": "symmetric"}),
            max_coarse=300,
            symmetry="symmetric",
        )

    def solve(self, slot: int, right_hand_sides: Floats) -> Floats:
        """Solve for (n, k) right-hand sides in a slot. Raises `StagnationError`: above `TOLERANCE`."""
        return np.stack([self._solved(slot, f) for f in right_hand_sides.T], axis=1)

    def _solved(self, slot: int, f: Floats) -> Floats:
        if not f.any():
            return np.zeros_like(f)
        residuals: list[float] = []
        limits = {"tol": TOLERANCE, "maxiter": MOST_ITERATIONS}
        u = self._hierarchies[slot].solve(f, **limits, accel="cg", residuals=residuals)
        reached = residuals[-1] / residuals[0]
        if not reached <= TOLERANCE * 10:
            message = (
                f"the iterative solver stagnated at a relative residual of {reached:.1e} after "
                f"{len(residuals) - 1} iterations. Choose --solver pardiso, or a mesh with better elements"
            )
            raise StagnationError(message)
        return np.asarray(u)
