"""The parts of triangles in which a linear function lies between two values."""

import numpy as np

from geometry.arrays import Floats, Ints

_CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


def parts_within(values: Floats, bound: float) -> tuple[Ints, Floats]:
    """Cut triangles where −`bound` ≤ value ≤ `bound`.

    Polygons are clipped by one half-plane after the other (Sutherland and Hodgman, 1974).

    Parameters
    ----------
    values
        (n_triangles, 3) at the corners.
    bound
        Not negative.

    Returns
    -------
    owner, parts
        Number of the triangle (n_parts,) that each part belongs to, and the corners (n_parts, 3, 2) of the
        parts, which are triangles again, in the reference coordinates of their owner. They vary continuously
        with the values.
    """
    owner, parts = [], []
    for number, corner_values in enumerate(values):
        polygon = np.column_stack([_CORNERS, corner_values])
        for sign in (1, -1):
            polygon = _clipped(polygon, bound - sign * polygon[:, 2])
        fan = [polygon[[0, k, k + 1], :2] for k in range(1, len(polygon) - 1)]
        owner += [number] * len(fan)
        parts += fan
    return np.array(owner, dtype=np.int64), np.array(parts).reshape(-1, 3, 2)


def _clipped(polygon: Floats, level: Floats) -> Floats:
    """The part of a convex polygon (n, 3) where the level (n,) of its corners is not negative."""
    kept = []
    for here, there, a, b in zip(polygon, np.roll(polygon, -1, 0), level, np.roll(level, -1), strict=True):
        if a >= 0:
            kept.append(here)
        if a * b < 0:
            kept.append(here + a / (a - b) * (there - here))
    return np.array(kept).reshape(-1, 3)
