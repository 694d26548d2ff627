"""How well a solution satisfies its equations."""

from dataclasses import dataclass

import numpy as np

from fea.solid.assembly import SymmetricMatrix
from geometry.arrays import Floats, Mask

# A direct solver leaves a few units in the last place, the iterative one some thousand. What would fail its
# check (1e-12) gets a step of refinement (Wilkinson 1963), or as many as help.
REFINE_ABOVE = 9e-13
# The same of what is left of the forces: a part far stiffer than the rest gives ‖K‖ all to itself, so that a
# backward error within its limit may hide forces that matter where the rest is.
REFINE_IMBALANCE = 1e-8
# So many right-hand sides of a direct solver are checked one by one; of more, a few random sums.
CHECKED_SINGLY = 8
_SUMS = 3


@dataclass(frozen=True)
class Residuals:
    """How well the equations of one parity are satisfied, the worst over its right-hand sides.

    Many right-hand sides of a direct solver are held against these by random sums of theirs, each column
    divided by ‖K‖ ‖u‖ + ‖f‖.

    Attributes
    ----------
    backward_error
        ‖Ku − f‖ / (‖K‖ ‖u‖ + ‖f‖), maximum norms (Rigal & Gaches 1967).
    energy
        |uᵀKu − uᵀf| / uᵀf.
    reaction
        Largest force at a restraint of inertia relief, N (of sums: in parts of that scale); it should vanish.
    imbalance
        ‖Ku − f‖ / ‖f‖, maximum norms.
    """

    backward_error: float
    energy: float
    reaction: float
    imbalance: float

    @property
    def excess(self) -> float:
        """How many times worse than asked for, by the worse of the two."""
        return max(self.backward_error / REFINE_ABOVE, self.imbalance / REFINE_IMBALANCE)

    @property
    def rough(self) -> bool:
        """Whether refinement is worth a try."""
        return self.excess > 1

    def better_than(self, other: "Residuals") -> bool:
        """Whether a step of refinement from `other` helped."""
        return self.excess < other.excess


def residuals(
    K: SymmetricMatrix, u: Floats, f: Floats, *, fixed: Mask, held: Mask, singly: bool = False
) -> Residuals:
    """Hold every column against its right-hand side, or sums of many columns of a direct solver.

    Parameters
    ----------
    K
        The stiffness without its supports.
    u, f
        (n, k) displacements and forces.
    fixed
        (n,) degrees of freedom that are no equation.
    held
        (n,) those of them that restrain a rigid motion only.
    singly
        Whether every column is looked at, however many there are.
    """
    load = np.abs(f).max(axis=0)
    scale = K.norm() * np.abs(u).max(axis=0) + load
    if u.shape[1] > CHECKED_SINGLY and not singly:
        weights = _signed_shares(scale)
        # Of the columns the one whose load is the least part of its scale.
        load = np.full(_SUMS, np.min(load[load > 0] / scale[load > 0], initial=1.0))
        u, f, scale = u @ weights, f @ weights, np.ones(_SUMS)
    product = K @ u
    left = np.abs(np.where(fixed[:, None], 0.0, product - f)).max(axis=0)
    work = (u * f).sum(axis=0)
    energy = (u * product).sum(axis=0)
    reaction = np.abs((product - f)[held]).max(initial=0.0)
    return Residuals(
        worst_ratio(left, scale),
        worst_ratio(np.abs(energy - work), np.abs(work)),
        float(reaction),
        worst_ratio(left, load),
    )


def _signed_shares(scale: Floats) -> Floats:
    """Weights (n, k) of k sums of n columns, each counting by its scale (n,), with random signs.

    Whatever the others err by, a sum's residual at a place is no less than one column's there for at least
    one of that column's two signs (after Freivalds 1977): three sums let the worst column hide once in eight
    times at most, and a broken factor, which spoils them all, practically never.
    """
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (len(scale), _SUMS))
    return np.asarray(np.divide(signs, scale[:, None], out=np.zeros_like(signs), where=scale[:, None] != 0))


def worst_ratio(error: Floats, scale: Floats) -> float:
    """Largest ratio; a load case without any load counts as exact, a value that is not finite as infinite."""
    if not (np.isfinite(error).all() and np.isfinite(scale).all()):
        return float("inf")
    loaded = scale > 0
    return float((error[loaded] / scale[loaded]).max(initial=0.0))
