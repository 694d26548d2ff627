"""The residuals of a solution."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from fea.solid.assembly import SymmetricMatrix
from fea.solvers.direct import Operator
from geometry.arrays import Floats, Mask

# The error of a direct solver is a few units in the last place, that of the iterative one some thousand. A
# solution that would fail its check (1e-12) is refined iteratively (Wilkinson 1963) as long as that helps.
REFINE_ABOVE = 9e-13
# The same for residual forces: a part far stiffer than the rest determines ‖K‖, so that a small backward
# error may hide residual forces that matter in the rest.
REFINE_IMBALANCE = 1e-8
# Up to this many right-hand sides of a direct solver are checked one by one; of more, a few random sums.
CHECKED_SINGLY = 8
_SUMS = 3
# Largest number of refinement steps.
MOST_REFINEMENTS = 3

Fields = TypeVar("Fields")


@dataclass(frozen=True)
class Residuals:
    """Residuals of the equations of one parity: the worst over its right-hand sides.

    Of many sides of a direct solver, random sums are checked, each column divided by ‖K‖ ‖u‖ + ‖f‖.
    """

    backward_error: float  #: ‖Ku − f‖ / (‖K‖ ‖u‖ + ‖f‖), maximum norms (Rigal & Gaches 1967)
    energy: float  #: |uᵀKu − uᵀf| / uᵀf
    #: Largest force at a restraint of inertia relief, N (for sums: relative to that scale); ideally zero
    reaction: float
    imbalance: float  #: ‖Ku − f‖ / ‖f‖, maximum norms

    @property
    def excess(self) -> float:
        """Ratio to the limit of refinement, for the worse of the two."""
        return max(self.backward_error / REFINE_ABOVE, self.imbalance / REFINE_IMBALANCE)


def refined(
    first: Fields, correct: Callable[[Fields], Fields], check: Callable[[Fields], Residuals]
) -> tuple[Fields, Residuals]:
    """Improve a solution by steps of refinement as long as it is rough and that helps (Wilkinson 1963)."""
    best, checked = first, check(first)
    for _ in range(MOST_REFINEMENTS):
        if checked.excess <= 1:
            break
        further = correct(best)
        better = check(further)
        if not better.excess < checked.excess:
            break
        best, checked = further, better
    return best, checked


def residuals(
    K: SymmetricMatrix, u: Floats, f: Floats, *, fixed: Mask, restraints: Mask, singly: bool = False
) -> Residuals:
    """Compare every column with its right-hand side, or random sums of many columns of a direct solver.

    K is the stiffness without its supports; u and f are (n, k). Of the constrained degrees of freedom `fixed`
    (n,), `restraints` (n,) stop only a rigid motion. `singly` checks every column, however many there are.
    """
    load = _largest(f)
    scale = K.norm() * _largest(u) + load
    if u.shape[1] > CHECKED_SINGLY and not singly:
        # Weights of sums of columns, each divided by its scale, with random signs. Whatever the errors of the
        # others, the residual of a sum is not smaller than that of one column for at least one of the two
        # signs of that column (after Freivalds 1977). With three sums the worst column therefore escapes in
        # at most one of eight cases; a faulty factor, which affects all columns, practically never does.
        signs = np.random.default_rng(0).choice([-1.0, 1.0], (len(scale), _SUMS))
        where = scale[:, None] != 0
        weights = np.asarray(np.divide(signs, scale[:, None], out=np.zeros_like(signs), where=where))
        # The smallest ratio of load to scale among the columns.
        load = np.full(_SUMS, np.min(load[load > 0] / scale[load > 0], initial=1.0))
        u, f, scale = u @ weights, f @ weights, np.ones(_SUMS)
    product = K @ u
    residual = np.abs(np.where(fixed[:, None], 0.0, product - f)).max(axis=0)
    work = (u * f).sum(axis=0)
    energy = (u * product).sum(axis=0)
    reaction = np.abs((product - f)[restraints]).max(initial=0.0)
    return Residuals(
        worst_ratio(residual, scale),
        worst_ratio(np.abs(energy - work), np.abs(work)),
        float(reaction),
        worst_ratio(residual, load),
    )


def _largest(columns: Floats) -> Floats:
    """Maximum norms of columns, without a copy of them."""
    return np.asarray(np.maximum(columns.max(axis=0), -columns.min(axis=0)))


def worst_ratio(error: Floats, scale: Floats) -> float:
    """Largest ratio; a case without any load counts as exact, and a value that is not finite as infinite."""
    if not (np.isfinite(error).all() and np.isfinite(scale).all()):
        return float("inf")
    loaded = scale > 0
    return float((error[loaded] / scale[loaded]).max(initial=0.0))


def probe(matrix: SymmetricMatrix) -> Floats:
    """Right-hand side (n, 1) that excites every mode: a uniform translation plus noise.

    Solved with the loads it costs little; loads alone might hide the softest modes.
    """
    random = np.random.default_rng(0)
    shift = np.tile(random.standard_normal(3), matrix.size // 3)
    return (matrix.diagonal() * (shift + random.standard_normal(matrix.size)))[:, None]


def condition_of(matrix: SymmetricMatrix, u: Floats, f: Floats) -> float:
    """Estimate the condition number from solutions, usually between half and four times the true one.

    u and f (n, k) are zero at constrained degrees of freedom. The number is infinite if a solution shows that
    the matrix is not positive definite, and 1 without any load.
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


def condition_estimate(matrix: SymmetricMatrix, solve: Operator) -> float:
    """Estimate the condition number of K with its supports by two solutions, the first of the probe."""
    f = matrix.diagonal()[:, None] * solve(probe(matrix))
    return condition_of(matrix, solve(f), f)
