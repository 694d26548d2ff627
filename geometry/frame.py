"""Right-handed frames about an axis."""

import numpy as np

from geometry.arrays import Floats


def rod_frame(axis: Floats, between: Floats) -> tuple[Floats, float]:
    """Return the rod's frame in the coordinates of a file, and its length.

    Parameters
    ----------
    axis
        Unit vector (3,) along the pins.
    between
        From a point on the big end's axis to one on the small end's, mm.

    Returns
    -------
    tuple
        Unit vectors (3, 3) along the rod, across it and along its pins, as rows; distance of the axes, mm.
    """
    x = between - (between @ axis) * axis
    length = float(np.linalg.norm(x))
    x = x / length
    return np.stack([x, np.cross(axis, x), axis]), length


def basis_across(direction: Floats) -> Floats:
    """Two unit vectors (2, 3) across a direction and across each other, right-handed with it."""
    first = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    first = first / np.linalg.norm(first)
    return np.stack([first, np.cross(direction, first)])
