"""Small dense systems, solved again and again while their matrix changes little."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from scipy.linalg import get_lapack_funcs, lapack

from geometry.arrays import Floats, Ints, Reals

# Reciprocal condition number, of a scaled matrix, below which a motion counts as free; smallest over largest
# pivot above which the condition need not be known, in double and in single precision.
_SINGULAR, _SAFE, _SAFE_SINGLE = 1e-12, 1e-8, 1e-3
# Steps of iterative refinement with the factor of another matrix, what they must leave of the residual, and
# by how much each must reduce it.
_STEPS, _EXACT, _ENOUGH = 8, 1e-14, 0.1


@cache
def _lapack(name: str, precision: np.dtype[Any]) -> Callable[..., Any]:
    return get_lapack_funcs(name, dtype=precision)  # type: ignore[no-any-return]


@dataclass(frozen=True)
class Factor:
    """Triangular factors of the transpose of a matrix (n, n) and their pivots (n,), as LAPACK has them.

    Single precision takes little more than half the time; iterative refinement makes up for it.
    """

    triangles: Reals
    pivots: Ints

    @classmethod
    def of(cls, matrix: Reals, *, overwrite: bool = False) -> "Factor | None":
        """Factorise, in the precision of the matrix, which may be overwritten; None if a pivot is zero."""
        triangles, pivots, broken = _lapack("getrf", matrix.dtype)(matrix.T, overwrite_a=overwrite)
        return cls(triangles, pivots) if broken == 0 else None

    @property
    def least_pivot(self) -> float:
        """Smallest pivot over the largest."""
        pivot = np.abs(np.diag(self.triangles))
        return float(pivot.min() / pivot.max())

    def solve(self, side: Floats) -> Floats:
        """Solve for one right-hand side (n,)."""
        solve = _lapack("getrs", self.triangles.dtype)
        return np.asarray(solve(self.triangles, self.pivots, side, trans=1)[0], float)

    def refined(self, matrix: Floats, side: Floats) -> Floats | None:
        """Solve with another matrix that is nearly the same; None if that takes too long."""
        solution, given = self.solve(side), np.abs(side).max()
        before = np.inf
        for _ in range(_STEPS):
            left = side - matrix @ solution
            size = float(np.abs(left).max())
            if size <= _EXACT * given or size <= _EXACT * np.abs(solution).max():
                return solution
            if size > _ENOUGH * before:
                return None
            solution, before = solution + self.solve(left), size
        return None


def solved(matrix: Floats, side: Floats, near: Factor | None = None) -> tuple[Floats, Factor | None]:
    """Solve a matrix (n, n) with a diagonal near one; a motion that nothing resists stays zero.

    `near` factorises a matrix that may be nearly the same. Also returned is a factor of use for the next such
    matrix, unless this one is singular, as where a part has come off.
    """
    if not len(side):
        return side, None
    if near is not None and (solution := near.refined(matrix, side)) is not None:
        return solution, near
    single = Factor.of(matrix.astype(np.float32), overwrite=True)
    if single is not None and single.least_pivot > _SAFE_SINGLE:
        solution = single.refined(matrix, side)
        if solution is not None:
            return solution, single
    factor = Factor.of(matrix)
    if factor is not None:
        norm = np.abs(matrix).sum(axis=1).max()
        if factor.least_pivot > _SAFE or lapack.dgecon(factor.triangles, norm)[0] > _SINGULAR:
            return factor.solve(side), factor
    return np.asarray(np.linalg.lstsq(matrix, side, rcond=_SINGULAR)[0]), None
