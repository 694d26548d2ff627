"""Small dense systems, solved again and again while their matrix changes little."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from geometry.arrays import Floats, Ints

# Reciprocal condition number, of a scaled matrix, below which a motion counts as free; smallest over largest
# pivot above which the condition need not be known.
_SINGULAR, _SAFE = 1e-12, 1e-8
# Steps of iterative refinement with the factor of another matrix, what they must leave of the residual, and
# by how much each must reduce it.
_STEPS, _EXACT, _ENOUGH = 8, 1e-14, 0.1


@dataclass(frozen=True)
class Factor:
    """Triangular factors of the transpose of a matrix (n, n) and their pivots (n,), as LAPACK has them."""

    triangles: Floats
    pivots: Ints

    def solve(self, side: Floats) -> Floats:
        """Solve for one right-hand side (n,)."""
        return np.asarray(lapack.dgetrs(self.triangles, self.pivots, side, trans=1)[0])

    def refined(self, matrix: Floats, side: Floats) -> Floats | None:
        """Solve with another matrix that is nearly the same; None if that takes too long."""
        found = self.solve(side)
        before = np.inf
        for _ in range(_STEPS):
            left = side - matrix @ found
            size = float(np.abs(left).max())
            if size <= _EXACT * max(np.abs(found).max(), np.abs(side).max()):
                return found
            if size > _ENOUGH * before:
                return None
            found, before = found + self.solve(left), size
        return None


def solved(matrix: Floats, side: Floats, near: Factor | None = None) -> tuple[Floats, Factor | None]:
    """Solve; a motion that nothing resists, as that of a part that has come off, stays zero.

    Parameters
    ----------
    matrix, side
        (n, n) with a diagonal near one, and (n,).
    near
        Factor of a matrix that may be nearly the same.

    Returns
    -------
    ndarray, Factor or None
        (n,) and a factor of use for a matrix that is nearly the same, unless this one is singular.
    """
    if not len(side):
        return side, None
    found = None if near is None else near.refined(matrix, side)
    if found is not None:
        return found, near
    triangles, pivots, broken = lapack.dgetrf(matrix.T)
    if broken == 0 and _conditioned(matrix, triangles):
        factor = Factor(triangles, pivots)
        return factor.solve(side), factor
    return np.asarray(np.linalg.lstsq(matrix, side, rcond=_SINGULAR)[0]), None


def _conditioned(matrix: Floats, triangles: Floats) -> bool:
    """Whether every motion is resisted."""
    pivot = np.abs(np.diag(triangles))
    if pivot.min() > _SAFE * pivot.max():
        return True
    return bool(lapack.dgecon(triangles, np.abs(matrix).sum(axis=1).max())[0] > _SINGULAR)
