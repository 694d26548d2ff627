"""Nodal forces of the pressure on a bore."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fea.solid.element import tabulate
from fea.solid.integration import jacobians
from fea.solid.parity import Split
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# The kinks at an arc's ends need points rather than order: with these 25, stress away from the bore is
# within 1e-4 of the peak of what exact integration gives on the coarsest of the default meshes.
FACET_DEGREE = 10


@dataclass(frozen=True)
class BoreFacets:
    """Quadrature points of a bore's facets.

    Attributes
    ----------
    nodes
        (n_facets, n_facet_nodes).
    shape_values
        (n_points, n_facet_nodes).
    areas
        (n_facets, n_points) weight times area, mm².
    angle
        (n_facets, n_points) about the bore's axis from rod +x, rad.
    node_angle
        (n_facets, n_facet_nodes) angle of the nodes, rad.
    cut_y, cut_z
        Whether the cell stands for its mirror images about y = 0, z = 0.
    """

    nodes: Ints
    shape_values: Floats
    areas: Floats
    angle: Floats
    node_angle: Floats
    cut_y: bool
    cut_z: bool


def bore_facets(mesh: TetMesh, surface: Surface, center_x: float) -> BoreFacets:
    """Quadrature points of the bore `surface`, whose axis passes through (`center_x`, 0)."""
    nodes = mesh.facets[surface]
    table = tabulate(nodes.shape[1], FACET_DEGREE)
    corners = mesh.points[nodes]
    tangents = jacobians(corners, table.gradients)
    normal = np.cross(tangents[..., 0], tangents[..., 1])
    places = table.values @ corners
    return BoreFacets(
        nodes,
        table.values,
        np.linalg.norm(normal, axis=-1) * table.weights,
        np.arctan2(places[..., 1], places[..., 0] - center_x),
        np.arctan2(corners[..., 1], corners[..., 0] - center_x),
        Surface.SYMMETRY_Y in mesh.facets,
        Surface.SYMMETRY_Z in mesh.facets,
    )


@dataclass(frozen=True)
class BoreLoad:
    """A bore pressure on the cell.

    Attributes
    ----------
    forces
        Nodal forces, N.
    traction
        At the bore's nodes, MPa, zero elsewhere.
    scale
        Factor on the analytic peak pressure that made the resultant exact.
    """

    forces: Split
    traction: Split
    scale: float


def bore_load(
    bore: BoreFacets,
    n_nodes: int,
    force: tuple[float, float],
    pressure: Callable[[Floats], Floats],
) -> BoreLoad:
    """Press a bore in the direction of `force`, with exactly that resultant.

    The traction points along the exact radius, so that it has no moment about the bore's axis; the
    pressure p(ψ), ψ from the direction of the force, is multiplied by a + b sin ψ with the a ≈ 1 and
    b ≈ 0 that make both components of the discrete resultant exact.

    Parameters
    ----------
    bore
        The facets of the meshed cell.
    n_nodes
        Of the mesh.
    force
        (x, y) on the whole rod, N.
    pressure
        p(ψ), MPa, of the whole force on the whole width; vectorised, ψ in −π…π.
    """
    magnitude, direction = float(np.hypot(*force)), float(np.arctan2(force[1], force[0]))
    a, b = 1.0, 0.0
    if magnitude > 0:
        a, b = np.linalg.solve(_resultants(bore, direction, pressure), [magnitude, 0.0])

    def exact(angle: Floats) -> Floats:
        psi = _wrapped(angle - direction)
        return np.asarray(pressure(psi) * (a + b * np.sin(psi))) if magnitude > 0 else np.zeros_like(angle)

    there, nodal = exact(bore.angle), exact(bore.node_angle)
    if not bore.cut_y:
        return BoreLoad(
            Split(radial_forces(bore, n_nodes, there), None),
            Split(radial_traction(bore, n_nodes, nodal), None),
            float(a),
        )
    mirrored, nodal_mirrored = exact(-bore.angle), exact(-bore.node_angle)
    return BoreLoad(
        Split(
            radial_forces(bore, n_nodes, (there + mirrored) / 2),
            radial_forces(bore, n_nodes, (there - mirrored) / 2),
        ),
        Split(
            radial_traction(bore, n_nodes, (nodal + nodal_mirrored) / 2),
            radial_traction(bore, n_nodes, (nodal - nodal_mirrored) / 2),
        ),
        float(a),
    )


def _resultants(bore: BoreFacets, direction: float, pressure: Callable[[Floats], Floats]) -> Floats:
    """Resultants along and across the force of p and of p sin ψ (columns), over every image of the cell."""
    weight = bore.areas * (2 if bore.cut_z else 1)
    system = np.zeros((2, 2))
    for side in (1, -1) if bore.cut_y else (1,):
        psi = _wrapped(side * bore.angle - direction)
        pressed = weight * pressure(psi)
        radial = np.stack([np.cos(psi), np.sin(psi)])
        system[:, 0] += (radial * pressed).sum(axis=(1, 2))
        system[:, 1] += (radial * pressed * np.sin(psi)).sum(axis=(1, 2))
    return system


def _wrapped(angle: Floats) -> Floats:
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)


def radial_forces(bore: BoreFacets, n_nodes: int, pressure: Floats) -> Floats:
    """Nodal forces (n_nodes, 3) of a radial traction at the quadrature points."""
    traction = bore.areas * pressure
    forces = np.zeros((n_nodes, 3))
    for axis, component in enumerate((np.cos(bore.angle), np.sin(bore.angle))):
        nodal = (traction * component) @ bore.shape_values
        forces[:, axis] = np.bincount(bore.nodes.ravel(), nodal.ravel(), minlength=n_nodes)
    return forces


def radial_traction(bore: BoreFacets, n_nodes: int, pressure: Floats) -> Floats:
    """Radial traction (n_nodes, 3) of a pressure at the facets' nodes."""
    traction = np.zeros((n_nodes, 3))
    traction[bore.nodes, 0] = pressure * np.cos(bore.node_angle)
    traction[bore.nodes, 1] = pressure * np.sin(bore.node_angle)
    return traction
