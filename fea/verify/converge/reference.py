"""What a sequence of ever finer meshes tends to, and how well that is known."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

# Orders beyond these are accidents of irregular meshes.
LEAST_ORDER, LARGEST_ORDER = 1.0, 3.0
# Of Roache 1994, for three meshes or more.
SAFETY = 1.25


@dataclass(frozen=True)
class Reference:
    """A value taken for the truth.

    Attributes
    ----------
    value
        MPa.
    uncertainty_percent
        Of the value; 0 where it is exact.
    """

    value: float
    uncertainty_percent: float = 0.0


def extrapolated(sizes: Sequence[float], values: Sequence[float]) -> Reference:
    """Richardson's extrapolation of the three finest meshes with Roache's (1994) grid convergence index.

    The order p solves (f3 − f2) / (f2 − f1) = r^p for the constant ratio r of the sizes; where the values do
    not approach one from one side, the finest is taken, uncertain by the spread of the three.

    Parameters
    ----------
    sizes
        Element sizes, coarse to fine, in constant ratio.
    values
        What they gave; fewer than three have no known uncertainty (infinite).
    """
    if len(values) < 3:
        return Reference(values[-1], float("inf"))
    coarse, medium, fine = values[-3:]
    ratio = sizes[-2] / sizes[-1]
    first, second = medium - coarse, fine - medium
    spread = 100 * (max(coarse, medium, fine) - min(coarse, medium, fine)) / abs(fine)
    if second == 0 or first / second <= 1:
        return Reference(fine, spread)
    order = float(np.clip(np.log(first / second) / np.log(ratio), LEAST_ORDER, LARGEST_ORDER))
    change = second / (ratio**order - 1)
    return Reference(fine + change, 100 * SAFETY * abs(change / fine))
