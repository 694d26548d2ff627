"""Balls that enclose many paths: quickly computed, but not quite the smallest."""

import numpy as np

from geometry.arrays import Reals

# Number of times that a ball grows.
GROWTHS = 4
_TINY = 1e-30


def distances_from_middle(paths: Reals, start: Reals) -> Reals:
    """Distances (n, n_points) of the points of paths from the centre of an almost smallest enclosing ball.

    It starts half-way from `start` to the point farthest from it, and grows towards points outside (Ritter
    1990). The largest distance is the radius of a ball that encloses all points.

    Parameters
    ----------
    paths
        (n, n_dimensions, n_points).
    start
        (n, n_dimensions), a point on the surface: the longest vector of each path.
    """
    squares = np.einsum("nct,nct->nt", paths, paths)
    rows, center = np.arange(len(paths)), start
    radius = np.zeros(len(paths), paths.dtype)
    for _ in range(GROWTHS):
        far = paths[rows, :, _square_distances(paths, squares, center).argmax(axis=1)]
        away = np.linalg.norm(far - center, axis=1)
        radius = np.maximum(radius, (radius + away) / 2)
        step = np.maximum(1 - radius / np.maximum(away, _TINY), 0)
        center = center + step[:, None] * (far - center)
    return np.asarray(np.sqrt(np.maximum(_square_distances(paths, squares, center), 0)))


def _square_distances(paths: Reals, squares: Reals, center: Reals) -> Reals:
    along = (center[:, None] @ paths)[:, 0]
    return np.asarray(squares - 2 * along + (center**2).sum(axis=1)[:, None])
