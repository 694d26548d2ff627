"""Measures of solids whose faces are splines, which the CAD kernel itself misses by up to a per cent."""

import math
from collections.abc import Sequence

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import Floats
from geometry.mass import MassProperties

# Nodes of the triangles: three vertices, and the middles of their sides.
_TRIANGLE6 = 9
# Degree of exactness of the quadrature on a triangle; cubic moments of quadratic triangles have more, and are
# integrated to 1e-6 with elements of this size, over the extent, and so many around a circle.
_QUADRATURE = "Gauss8"
_SIZE, _AROUND = 0.05, 24
# Samples along an edge of a face.
_SAMPLES = np.linspace(0.0, 1.0, 129)


def wall_area(face: int, point: Floats, direction: Floats, radius: float) -> tuple[float, Floats]:
    """Area, mm², and centroid (3,) of a face on a cylinder, by an integral along its edges.

    The cylinder's axis goes through a point. By Green's theorem on the unrolled face the area is the integral
    of the height times the radius over the angle; edges along the axis have no part in it.
    """
    across = np.eye(3)[np.abs(direction).argmin()]
    x = np.cross(direction, across)
    x /= np.linalg.norm(x)
    y = np.cross(direction, x)
    total, moment = 0.0, np.zeros(3)
    for _, signed in gmsh.model.getBoundary([(2, face)], combined=False, oriented=True):
        edge, sign = abs(signed), math.copysign(1.0, signed)
        (low,), (high,) = gmsh.model.getParametrizationBounds(1, edge)
        places = np.reshape(gmsh.model.getValue(1, edge, low + (high - low) * _SAMPLES), (-1, 3)) - point
        height, angle = places @ direction, np.unwrap(np.arctan2(places @ y, places @ x))
        step = sign * radius * np.diff(angle)
        middle = (height[1:] + height[:-1]) / 2
        turn = (angle[1:] + angle[:-1]) / 2
        total += float(step @ middle)
        moment += np.array([
            radius * float(step @ (middle * np.cos(turn))),
            radius * float(step @ (middle * np.sin(turn))),
            float(step @ middle**2) / 2,
        ])  # fmt: skip
    centroid = moment / total
    return abs(total), point + centroid[0] * x + centroid[1] * y + centroid[2] * direction


def triangulated_mass(volume: int) -> MassProperties:
    """Volume, centre and second moments of a volume of the open model from a mesh of its faces.

    By the divergence theorem, from the quadratic triangles of a mesh of its own, which is cleared again: call
    it before the model is meshed.
    """
    points, normals = _quadrature(volume)
    cell = float((points * normals).sum()) / 3
    center = (points**2 * normals).sum(axis=0) / 2 / cell
    away = points - center
    square = (away**3 * normals).sum(axis=0) / 3
    xy, yz, xz = (
        float((away[:, i] ** 2 * away[:, j] * normals[:, i]).sum()) / 2 for i, j in ((0, 1), (1, 2), (0, 2))
    )
    xx, yy, zz = square.tolist()
    inertia = ((yy + zz, -xy, -xz), (-xy, xx + zz, -yz), (-xz, -yz, xx + yy))
    x, y, z = center.tolist()
    return MassProperties(cell, (x, y, z), inertia)


def _quadrature(volume: int) -> tuple[Floats, Floats]:
    """Points (n, 3) on the boundary, and outward normals (n, 3) there as long as their weights, mm²."""
    faces = gmsh.model.getBoundary([(kernel.SOLID, volume)], combined=False, oriented=False)
    box = np.concatenate([np.reshape(_edge_points(tag), (-1, 3)) for _, tag in faces])
    # The other solids may be so much larger that a mesh of theirs with these elements would not end.
    gmsh.model.setVisibility(gmsh.model.getEntities(), 0)
    gmsh.model.setVisibility([(kernel.SOLID, volume)], 1, recursive=True)
    size = _SIZE * float(np.ptp(box, axis=0).max())
    changed = {"MeshOnlyVisible": 1, "MeshSizeMax": size, "MeshSizeFromCurvature": _AROUND}
    kept = {name: gmsh.option.getNumber(f"Mesh.{name}") for name in changed}
    try:
        for name, value in changed.items():
            gmsh.option.setNumber(f"Mesh.{name}", value)
        with kernel.attempt("mesh the faces of the solid", "Export the rod again, as STEP"):
            gmsh.model.mesh.clear()
            gmsh.model.mesh.generate(2)
            gmsh.model.mesh.setOutwardOrientation(volume)
            gmsh.model.mesh.setOrder(2)
        places, weights = gmsh.model.mesh.getIntegrationPoints(_TRIANGLE6, _QUADRATURE)
        points, normals = [], []
        for _, tag in faces:
            jacobians, _, at = gmsh.model.mesh.getJacobians(_TRIANGLE6, places, tag)
            columns = np.reshape(jacobians, (-1, 3, 3))  # column by column
            area = np.cross(columns[:, 0], columns[:, 1])
            points.append(np.reshape(at, (-1, 3)))
            normals.append(np.tile(weights, len(area) // len(weights))[:, None] * area)
    finally:
        gmsh.model.mesh.clear()
        gmsh.model.setVisibility(gmsh.model.getEntities(), 1)
        for name, value in kept.items():
            gmsh.option.setNumber(f"Mesh.{name}", value)
    return np.concatenate(points), np.concatenate(normals)


def _edge_points(face: int) -> Sequence[float]:
    points: list[float] = []
    for _, edge in gmsh.model.getBoundary([(2, face)], combined=False, oriented=False):
        (low,), (high,) = gmsh.model.getParametrizationBounds(1, edge)
        points.extend(gmsh.model.getValue(1, edge, low + (high - low) * np.linspace(0, 1, 9)))
    return points
