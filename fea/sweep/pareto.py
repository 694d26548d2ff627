"""The rods that none is both lighter and stronger than."""

import numpy as np

from geometry.arrays import Floats, Ints


def pareto_front(mass: Floats, factor: Floats) -> Ints:
    """Return the numbers of the rods on the front, the lightest first.

    Parameters
    ----------
    mass, factor
        (n,) NaN where there is no result.
    """
    known = np.flatnonzero(np.isfinite(mass) & np.isfinite(factor))
    order = known[np.lexsort([-factor[known], mass[known]])]
    best = np.maximum.accumulate(factor[order]) if len(order) else factor[order]
    before = np.concatenate([[-np.inf], best[:-1]])[: len(order)]
    return np.asarray(order[factor[order] > before])
