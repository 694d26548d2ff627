"""Estimate the condition number of a stiffness matrix from solutions that are computed anyway.

It is the condition number of D⁻¹ K with D the diagonal of K: Jacobi scaling removes units and differences in
stiffness between places (van der Sluis 1969: no other diagonal does much better); the rest amplifies the
backward error.

The largest eigenvalue does not exceed the largest sum of magnitudes in a row (Gershgorin 1931), which is two
to four times too large. The smallest does not exceed the Rayleigh quotient uᵀ K u / uᵀ D u of any u; a
solution of K u = f contains mostly the softest modes, provided that f excites them.
"""

import numpy as np

from fea.solid.assembly import SymmetricMatrix
from fea.solvers.linear.choice import Factor
from geometry.arrays import Floats


def probe(matrix: SymmetricMatrix) -> Floats:
    """Right-hand side (n, 1) that excites every mode: a uniform translation plus noise.

    Solved together with the loads it costs little; without it, loads that do not excite the softest modes
    would hide them.
    """
    random = np.random.default_rng(0)
    shift = np.tile(random.standard_normal(3), matrix.size // 3)
    return (matrix.diagonal() * (shift + random.standard_normal(matrix.size)))[:, None]


def condition_of(matrix: SymmetricMatrix, u: Floats, f: Floats) -> float:
    """Estimate the condition number from solutions, usually between half and four times the true one.

    Parameters
    ----------
    matrix
        K, with or without the supports.
    u, f
        (n, k) solutions and right-hand sides, both zero at constrained degrees of freedom.

    Returns
    -------
    float
        Infinite if a solution shows that the matrix is not positive definite; 1 without any load.
    """
    diagonal = matrix.diagonal()
    loaded = f.any(axis=0)
    if not loaded.any():
        return 1.0
    work = (u * f).sum(axis=0)[loaded]
    if not (np.isfinite(work).all() and (work > 0).all()):
        return float("inf")
    longest = (diagonal @ (u**2))[loaded] / work
    return float((matrix.row_sums / diagonal).max() * longest.max())


def condition_estimate(matrix: SymmetricMatrix, factor: Factor) -> float:
    """Estimate the condition number by two successive solutions that start from the probe.

    Parameters
    ----------
    matrix
        K with the supports (`SymmetricMatrix.constrained`), hence positive definite.
    factor
        Factor of the same matrix.
    """
    f = matrix.diagonal()[:, None] * factor.solve(probe(matrix))
    return condition_of(matrix, factor.solve(f), f)
