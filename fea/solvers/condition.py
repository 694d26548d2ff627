"""How well conditioned a stiffness matrix is, from solutions with it that are at hand anyway.

Of D⁻¹ K with D the diagonal of K: Jacobi's scaling takes out units and stiffness that merely differ from
place to place (van der Sluis 1969: no other diagonal does much better); what is left amplifies the backward
error.
The largest eigenvalue is no larger than the largest sum of magnitudes in a row (Gershgorin 1931), two to four
times too much. The least one is no larger than Rayleigh's quotient uᵀ K u / uᵀ D u of any u; a solution of
K u = f is rich in the softest modes, and the better the more f has of all.
"""

import numpy as np

from fea.solid.assembly import SymmetricMatrix
from fea.solvers.linear.choice import Factor
from geometry.arrays import Floats


def probe(matrix: SymmetricMatrix) -> Floats:
    """Right-hand side (n, 1) that has of every mode: a shift of the whole, and noise.

    Solved beside the loads it costs a small share of their time; without it loads that leave the softest
    modes in peace would hide them.
    """
    random = np.random.default_rng(0)
    shift = np.tile(random.standard_normal(3), matrix.size // 3)
    return (matrix.diagonal() * (shift + random.standard_normal(matrix.size)))[:, None]


def condition_of(matrix: SymmetricMatrix, u: Floats, f: Floats) -> float:
    """Estimate the condition from solutions, mostly between half and four times the true one.

    Parameters
    ----------
    matrix
        K, whether the supports are in it or not.
    u, f
        (n, k) solutions and right-hand sides, both zero where displacements are held.

    Returns
    -------
    float
        Infinite where a solution contradicts a positive definite matrix; 1 where there is no load.
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
    """Estimate the condition by two solutions with the probe, each the start of the next.

    Parameters
    ----------
    matrix
        K, positive definite: supports are in it (`SymmetricMatrix.constrained`).
    factor
        Of the same matrix.
    """
    f = matrix.diagonal()[:, None] * factor.solve(probe(matrix))
    return condition_of(matrix, factor.solve(f), f)
