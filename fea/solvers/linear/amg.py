"""Conjugate gradients preconditioned by smoothed aggregation, for first-order models too large to factorise.

Vaněk, Mandel & Brezina (1996) through pyamg, on 3×3 node blocks with the six rigid modes as near-null space.
"""

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse

from fea.solid.assembly import SymmetricMatrix
from fea.solid.errors import StagnationError
from fea.solid.mechanism import rigid_modes
from fea.solvers.linear.conjugate_gradients import MOST_ITERATIONS, TOLERANCE
from geometry.arrays import Floats


class SmoothedAggregation:
    """Preconditioned conjugate gradients with the interface of the direct solvers.

    Parameters
    ----------
    points
        (n_nodes, 3), mm, from which the rigid modes are computed.

    Raises
    ------
    ImportError
        pyamg is not installed.
    """

    name = "amg"

    def __init__(self, points: Floats) -> None:
        self._modes = rigid_modes(points).reshape(-1, 6)
        self._hierarchies: dict[int, Any] = {}

    def factorise(self, slot: int, matrix: SymmetricMatrix) -> None:
        """Build the hierarchy of `matrix` in a slot."""
        from pyamg import smoothed_aggregation_solver  # noqa: PLC0415 - only large models need it

        full = sparse.bsr_matrix(matrix.full())
        modes = np.where(_fixed(matrix)[:, None], 0.0, self._modes)
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
        """Solve for (n, k) right-hand sides with the hierarchy in a slot.

        Raises
        ------
        StagnationError
            The residual did not reach `TOLERANCE`.
        """
        return np.stack([self._solved(slot, f) for f in right_hand_sides.T], axis=1)

    def _solved(self, slot: int, f: Floats) -> Floats:
        if not f.any():
            return np.zeros_like(f)
        residuals: list[float] = []
        u = self._hierarchies[slot].solve(
            f, tol=TOLERANCE, maxiter=MOST_ITERATIONS, accel="cg", residuals=residuals
        )
        reached = residuals[-1] / residuals[0]
        if not reached <= TOLERANCE * 10:
            message = (
                f"the iterative solver stagnated at a relative residual of {reached:.1e} after "
                f"{len(residuals) - 1} iterations. Choose --solver pardiso, or a mesh with better elements"
            )
            raise StagnationError(message)
        return np.asarray(u)


def _fixed(matrix: SymmetricMatrix) -> npt.NDArray[np.bool_]:
    """Degrees of freedom (n,) whose row has only its diagonal entry."""
    return np.equal(matrix.row_sums, matrix.diagonal())
