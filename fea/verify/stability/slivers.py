"""Slivers put in by hand: nodes moved until some elements are almost flat, in a field they all can hold."""

from dataclasses import replace

import numpy as np

from fea.solid.traction import traction_forces
from fea.verify.body import STEEL, held
from fea.verify.stability.row import ExtremeRow
from fea.verify.stability.solved import percent, solved
from geometry.bodies.shape import Prism, polygon
from geometry.surfaces import Surface
from mesh.body import mesh_body
from mesh.tetmesh import TetMesh

FLATNESS = (1e-1, 1e-3, 1e-5, 1e-7)
SIDE = 4.0
# The exact field is linear, and a sliver can hold it; what is left is rounding, amplified by flatness.
TOLERANCE_PERCENT = 1e-2


def rows() -> list[ExtremeRow]:
    """One inner vertex is moved towards the opposite face of an element, to `value` of its height."""
    corners = (
        ((0.0, 0.0), Surface.FREE),
        ((SIDE, 0.0), Surface.FREE),
        ((SIDE, SIDE), Surface.FREE),
        ((0.0, SIDE), Surface.FREE),
    )
    whole = mesh_body(Prism(polygon(*corners), (0.0, SIDE), Surface.CLAMPED, Surface.LOADED), 1.5, order=1)
    material = replace(STEEL, poissons_ratio=0.0)
    found = []
    for flatness in FLATNESS:
        mesh = _flattened(whole, flatness)
        forces = traction_forces(mesh, Surface.LOADED, lambda _, normals: normals)
        result = solved(mesh, material, forces, held(mesh, {Surface.CLAMPED: (0, 1, 2)}))
        exact = SIDE / material.youngs_modulus
        end = np.unique(mesh.facets[Surface.LOADED])
        error = max(percent(value, exact) for value in result.displacement[end, 2])
        found.append(result.row("sliver", "height left", flatness, error, TOLERANCE_PERCENT))
    return found


def _flattened(mesh: TetMesh, flatness: float) -> TetMesh:
    """Move the first inner vertex that can be, so that no element turns inside out."""
    surface = np.unique(np.concatenate([facets.ravel() for facets in mesh.facets.values()]))
    inner = np.setdiff1d(np.arange(len(mesh.points)), surface)
    for tet in mesh.tets[np.isin(mesh.tets, inner).any(axis=1)]:
        vertex = tet[np.isin(tet, inner)][0]
        a, b, c = mesh.points[tet[tet != vertex]]
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal)
        height = (mesh.points[vertex] - a) @ normal
        points = mesh.points.copy()
        points[vertex] -= (1 - flatness) * height * normal
        spans = points[mesh.tets[:, 1:]] - points[mesh.tets[:, :1]]
        if np.linalg.det(spans).min() > 0:
            return replace(mesh, points=points)
    raise AssertionError("a mesh with inner vertices has one that can be moved")
