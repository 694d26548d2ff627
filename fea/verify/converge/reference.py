"""The limit of a sequence of finer meshes, and its uncertainty."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

# Orders outside this range are accidents of irregular meshes.
LEAST_ORDER, LARGEST_ORDER = 1.0, 3.0
# Safety factor of Roache 1994, for three meshes or more.
SAFETY = 1.25


@dataclass(frozen=True)
class Reference:
    """A reference value.

    Attributes
    ----------
    value
        MPa.
    uncertainty_percent
        Uncertainty of the value; 0 if it is exact.
    """

    value: float
    uncertainty_percent: float = 0.0


def extrapolated(sizes: Sequence[float], values: Sequence[float]) -> Reference:
    """Richardson extrapolation of the three finest meshes with Roache's (1994) grid convergence index.

    The order p solves (f3 − f2) / (f2 − f1) = r^p for the constant ratio r of the sizes. If the values do not
    converge monotonically, the value of the finest mesh is used, with the spread of the three as uncertainty.

    Parameters
    ----------
    sizes
        Element sizes, coarse to fine, in constant ratio.
    values
        Their results; with fewer than three the uncertainty is unknown (infinite).
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
