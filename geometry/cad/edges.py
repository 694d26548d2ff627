"""Points along the edges of faces and solids of the open model."""

from collections.abc import Iterable

import gmsh
import numpy as np

from geometry.arrays import Floats

# Places along each edge.
_PLACES = np.linspace(0.0, 1.0, 9)


def edge_points(face: int) -> Floats:
    """Points (n, 3) along the edges of a face."""
    return _along(gmsh.model.getBoundary([(2, face)], combined=False, oriented=False))


def loop_points(curves: Iterable[int], count: int = _PLACES.size - 1) -> Floats:
    """Points (n, 3) along curves that form a closed loop, `count` on each, where one begins only once."""
    return _along([(1, int(curve)) for curve in curves], np.linspace(0.0, 1.0, count + 1)[:-1])


def solid_points(volume: int) -> Floats:
    """Points (n, 3) along the edges of a solid."""
    faces = gmsh.model.getBoundary([(3, volume)], combined=False, oriented=False)
    return _along(sorted(set(gmsh.model.getBoundary(faces, combined=False, oriented=False))))


def _along(edges: list[tuple[int, int]], places: Floats = _PLACES) -> Floats:
    points = []
    for _, edge in edges:
        (low,), (high,) = gmsh.model.getParametrizationBounds(1, edge)
        points.append(gmsh.model.getValue(1, edge, low + (high - low) * places))
    return np.reshape(np.concatenate(points), (-1, 3)) if points else np.zeros((0, 3))
