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

# The kinks at an arc's ends need points rather than order.
FACET_DEGREE = 6


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
    cut_y, cut_z
        Whether the cell stands for its mirror images about y = 0, z = 0.
    """

    nodes: Ints
    shape_values: Floats
    areas: Floats
    angle: Floats
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
        Surface.SYMMETRY_Y in mesh.facets,
        Surface.SYMMETRY_Z in mesh.facets,
    )


@dataclass(frozen=True)
class BoreLoad:
    """Nodal forces of a bore pressure.

    Attributes
    ----------
    forces
        N.
    scale
        Factor on the analytic peak pressure that made the resultant exact.
    """

    forces: Split
    scale: float


def bore_load(
    bore: BoreFacets,
    n_nodes: int,
    force: tuple[float, float],
    pressure: Callable[[Floats], Floats],
) -> BoreLoad:
    """Nodal forces of a pressure that presses a bore in the direction of `force`, with exactly that resultant.

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
    shape = (n_nodes, 3)
    if magnitude == 0:
        return BoreLoad(Split(np.zeros(shape), np.zeros(shape) if bore.cut_y else None), 1.0)

    images = (1.0, -1.0) if bore.cut_y else (1.0,)
    psi = [_wrapped(side * bore.angle - direction) for side in images]
    raw = [pressure(angle) for angle in psi]
    weight = bore.areas * (2 if bore.cut_z else 1)
    # Resultant along and across the force of p and of p sin ψ, over every image of the cell.
    system = np.zeros((2, 2))
    for angle, p in zip(psi, raw, strict=True):
        radial = np.stack([np.cos(angle), np.sin(angle)])
        system[:, 0] += (radial * (weight * p)).sum(axis=(1, 2))
        system[:, 1] += (radial * (weight * p * np.sin(angle))).sum(axis=(1, 2))
    a, b = np.linalg.solve(system, [magnitude, 0.0])
    exact = [p * (a + b * np.sin(angle)) for angle, p in zip(psi, raw, strict=True)]

    if not bore.cut_y:
        return BoreLoad(Split(_radial_forces(bore, n_nodes, exact[0]), None), float(a))
    there, mirrored = exact
    return BoreLoad(
        Split(
            _radial_forces(bore, n_nodes, (there + mirrored) / 2),
            _radial_forces(bore, n_nodes, (there - mirrored) / 2),
        ),
        float(a),
    )


def _wrapped(angle: Floats) -> Floats:
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)


def _radial_forces(bore: BoreFacets, n_nodes: int, pressure: Floats) -> Floats:
    traction = bore.areas * pressure
    forces = np.zeros((n_nodes, 3))
    for axis, component in enumerate((np.cos(bore.angle), np.sin(bore.angle))):
        nodal = (traction * component) @ bore.shape_values
        forces[:, axis] = np.bincount(bore.nodes.ravel(), nodal.ravel(), minlength=n_nodes)
    return forces
