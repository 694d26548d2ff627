"""How well conditioned a stiffness matrix is, from the factor that solves with it."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from fea.solid.assembly import SymmetricMatrix
from fea.solid.solvers import Factor

Floats = npt.NDArray[np.float64]
Operator = Callable[[Floats], Floats]

# A few steps give each end of the spectrum to some ten per cent, from the safe side of neither; the
# estimate is for its order of magnitude.
_POWER_STEPS, _INVERSE_STEPS = 20, 6


def condition_estimate(matrix: SymmetricMatrix, factor: Factor) -> float:
    """Estimate κ₂ of D^(−½) K D^(−½), D the diagonal of K, by power and inverse power steps.

    Jacobi's scaling takes out units and stiffness that merely differ from place to place (van der
    Sluis 1969: no other diagonal does much better); what is left amplifies the backward error.
    Costs six solutions with one right-hand side, so it is made on demand.

    Parameters
    ----------
    matrix
        K, positive definite: supports are in it (`SymmetricMatrix.constrained`).
    factor
        Of the same matrix.
    """
    root = np.sqrt(matrix.diagonal())
    start = np.random.default_rng(0).standard_normal(matrix.size)

    def largest(apply: Operator, steps: int) -> float:
        vector, value = start / np.linalg.norm(start), 0.0
        for _ in range(steps):
            image = apply(vector)
            value = float(np.linalg.norm(image))
            vector = image / value
        return value

    highest = largest(lambda v: (matrix @ (v / root)) / root, _POWER_STEPS)
    lowest = 1 / largest(lambda v: root * factor.solve((root * v)[:, None])[:, 0], _INVERSE_STEPS)
    return highest / lowest
