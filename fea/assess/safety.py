"""Safety against yielding."""

import numpy as np

from geometry.arrays import Floats, Ints

# Upper limit of the factor, which would be infinite at zero stress; it keeps colour scales readable.
CAP = 100.0


def safety_factor(von_mises: Floats, yield_strength: float) -> Floats:
    """Yield strength over von Mises stress, at most `CAP`."""
    return np.asarray(yield_strength / np.maximum(von_mises, yield_strength / CAP))


def element_largest(nodal: Floats, tets: Ints) -> Floats:
    """Largest nodal value of each element, (n_elements,)."""
    return np.asarray(nodal[tets].max(axis=1))
