"""Safety against yielding."""

import numpy as np

from geometry.arrays import Floats, Ints

# Where stress vanishes the factor has no bound; this one keeps colour scales readable.
CAP = 100.0


def safety_factor(von_mises: Floats, yield_strength: float) -> Floats:
    """Yield strength over von Mises stress, at most `CAP`."""
    return np.asarray(yield_strength / np.maximum(von_mises, yield_strength / CAP))


def element_largest(nodal: Floats, tets: Ints) -> Floats:
    """Largest nodal value of each element, (n_elements,)."""
    return np.asarray(nodal[tets].max(axis=1))
