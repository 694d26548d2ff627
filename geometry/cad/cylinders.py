"""Cylinders and planes by their shape: faces that the kernel calls splines, revolved or unknown surfaces."""

from dataclasses import replace

import gmsh
import numpy as np

from geometry.arrays import Floats
from geometry.faces import Face, edge_points, parameter_grid
from geometry.segments import fitted_circle

# Largest deviation of a face from its cylinder, relative to the radius.
ROUND = 1e-3
# Largest mean component of its normals along the axis, and least spread of the normals of a curved face
# (about a sixth of a right angle).
_ALONG, _SPREAD = 3e-3, 0.07
# Largest height of a plane over its extent.
_FLAT = 1e-6
_SAMPLES = 9  # along each parameter
_KNOWN = ("Plane", "Cylinder", "Torus", "Cone", "Sphere")


def recognised(face: Face) -> Face:
    """Return the face as a plane or cylinder if it has that shape and the kernel does not know it.

    The box of a plane is that of its edges: the kernel's is wider by the tolerance of the file.
    """
    if face.shape == "Plane":
        points = edge_points(face.tag)
        return replace(face, low=_corner(points.min(axis=0)), high=_corner(points.max(axis=0)))
    if face.shape in _KNOWN:
        return face
    points, normals = _samples(face.tag)
    if np.ptp(points @ normals.mean(axis=0)) < _FLAT * np.ptp(points, axis=0).max():
        return recognised(replace(face, shape="Plane", fitted=True))
    found = fitted(points, normals)
    return face if found is None else replace(face, shape="Cylinder", values=found[0], fitted=True)


def fitted(points: Floats, normals: Floats) -> tuple[tuple[float, ...], float] | None:
    """Fit a cylinder to points and unit normals (n, 3), by a circle normal to the mean axis.

    Returns
    -------
    tuple or None
        Axis point (3), direction (3) and radius, and the largest deviation of a point from the cylinder, mm;
        None where the normals are not those of a cylinder.
    """
    size, axes = np.linalg.eigh(normals.T @ normals / len(normals))
    if size[0] > _ALONG**2 or size[1] < _SPREAD**2:
        return None
    direction, across = axes[:, 0], axes[:, 1:]
    middle = points.mean(axis=0)
    places = (points - middle) @ across
    circle = fitted_circle(places)
    if circle is None or (deviation := float(circle.distance(places).max())) > ROUND * circle.radius:
        return None
    on_axis = middle + across @ circle.center
    return (*on_axis.tolist(), *direction.tolist(), circle.radius), deviation


def _corner(values: Floats) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z


def _samples(face: int) -> tuple[Floats, Floats]:
    """Points and unit normals (n, 3) over the parameters of a face."""
    places = parameter_grid(face, np.linspace(0.01, 0.99, _SAMPLES)).ravel()  # at its ends may be no normal
    points = np.reshape(gmsh.model.getValue(2, face, places), (-1, 3))
    normals = np.reshape(gmsh.model.getNormal(face, places), (-1, 3))
    sound = np.isfinite(normals).all(axis=1) & (np.abs(np.linalg.norm(normals, axis=1) - 1) < 1e-6)
    if sound.sum() < 2 * _SAMPLES:
        return np.zeros((1, 3)), np.zeros((1, 3))
    return points[sound], normals[sound]
