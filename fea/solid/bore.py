"""The facets of a bore, their parts within an arc, and the nodal forces of a pressure on them."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fea.solid.clip import parts_within
from fea.solid.element import shape_functions, tabulate
from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

# High enough for the pressure harmonics of a cycle: the highest have a period of only a few coarse facets.
FACET_DEGREE = 10


@dataclass(frozen=True)
class FacetPoints:
    """Quadrature points of facets or of parts of them.

    Attributes
    ----------
    nodes
        (n_facets, n_facet_nodes).
    shape_values
        (n_points, n_facet_nodes), or (n_facets, n_points, n_facet_nodes) if each facet has its own points.
    areas
        (n_facets, n_points) weight times area, mm².
    angle
        (n_facets, n_points) about the bore's axis from rod +x, rad.
    """

    nodes: Ints
    shape_values: Floats
    areas: Floats
    angle: Floats


@dataclass(frozen=True)
class BoreFacets(FacetPoints):
    """Quadrature points of a bore's facets.

    Attributes
    ----------
    corners
        (n_facets, n_facet_nodes, 3) places of the nodes from the bore's axis, mm.
    node_angle
        (n_facets, n_facet_nodes) angle of the nodes, rad.
    cut_y, cut_z
        Whether the cell represents its mirror images about y = 0, z = 0.
    """

    corners: Floats
    node_angle: Floats
    cut_y: bool
    cut_z: bool


def bore_facets(mesh: TetMesh, surface: Surface, center_x: float) -> BoreFacets:
    """Quadrature points of the bore `surface`, whose axis passes through (`center_x`, 0)."""
    nodes = mesh.facets[surface]
    corners = mesh.points[nodes] - np.array([center_x, 0.0, 0.0])
    table = tabulate(nodes.shape[1], FACET_DEGREE)
    areas, angle = _areas_and_angles(corners, table.values, table.gradients)
    return BoreFacets(
        nodes=nodes,
        shape_values=table.values,
        areas=areas * table.weights,
        angle=angle,
        corners=corners,
        node_angle=np.arctan2(corners[..., 1], corners[..., 0]),
        cut_y=Surface.SYMMETRY_Y in mesh.facets,
        cut_z=Surface.SYMMETRY_Z in mesh.facets,
    )


def _areas_and_angles(corners: Floats, values: Floats, gradients: Floats) -> tuple[Floats, Floats]:
    """Area per reference area and angle (n_facets, n_points) for shape functions as in `FacetPoints`."""
    places = values @ corners
    return facet_areas(corners, gradients), np.arctan2(places[..., 1], places[..., 0])


def facet_areas(corners: Floats, gradients: Floats) -> Floats:
    """Area per reference area (n_facets, n_points) of facets with nodes `corners` (n_facets, n_nodes, 3)."""
    tangents = corners.transpose(0, 2, 1)[:, None] @ gradients
    return np.asarray(np.linalg.norm(np.cross(tangents[..., 0], tangents[..., 1]), axis=-1))


def facets_within(bore: BoreFacets, direction: float, half_arc: float) -> Iterator[FacetPoints]:
    """Quadrature points of the surface within `half_arc` (rad) of a direction: whole facets, then parts.

    Within a facet the arc ends on a line that is straight in reference coordinates: where the angle
    interpolated between the facet's corners equals the end of the arc. Points near the end are therefore not
    switched by rounding, and the forces vary continuously with the direction.
    """
    corner = bore.node_angle[:, :3]
    psi = wrapped(corner[:, :1] - direction) + wrapped(corner - corner[:, :1])
    inside = (np.abs(psi) <= half_arc).all(axis=1)
    outside = (psi >= half_arc).all(axis=1) | (psi <= -half_arc).all(axis=1)
    yield FacetPoints(bore.nodes[inside], bore.shape_values, bore.areas[inside], bore.angle[inside])
    crossed = np.flatnonzero(~inside & ~outside)
    owner, parts = parts_within(psi[crossed], half_arc)
    yield _part_points(bore, crossed[owner], parts)


def _part_points(bore: BoreFacets, facets: Ints, parts: Floats) -> FacetPoints:
    """Quadrature points of parts (n, 3, 2), each of one of the `facets` (n,)."""
    nodes, corners = bore.nodes[facets], bore.corners[facets]
    table = tabulate(3, FACET_DEGREE)
    places = table.values @ parts
    shapes = shape_functions(nodes.shape[1], places.reshape(-1, 2).T)
    values, gradients = (each.reshape(*places.shape[:2], *each.shape[1:]) for each in shapes)
    areas, angle = _areas_and_angles(corners, values, gradients)
    share = np.abs(np.linalg.det(parts[:, 1:] - parts[:, :1]))[:, None]  # of the reference triangle
    return FacetPoints(nodes, values, areas * share * table.weights, angle)


def wrapped(angle: Floats) -> Floats:
    """Return the same directions as angles within −π…π."""
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)


def radial_forces(points: FacetPoints, n_nodes: int, pressure: Floats) -> Floats:
    """Nodal forces (n_nodes, 3) of a radial traction at the quadrature points."""
    traction = points.areas * pressure
    forces = np.zeros((n_nodes, 3))
    for axis, component in enumerate((np.cos(points.angle), np.sin(points.angle))):
        nodal = (traction * component)[:, None] @ points.shape_values
        forces[:, axis] = np.bincount(points.nodes.ravel(), nodal.ravel(), minlength=n_nodes)
    return forces


def radial_traction(bore: BoreFacets, n_nodes: int, pressure: Floats) -> Floats:
    """Radial traction (n_nodes, 3) of a pressure at the facets' nodes."""
    traction = np.zeros((n_nodes, 3))
    traction[bore.nodes, 0] = pressure * np.cos(bore.node_angle)
    traction[bore.nodes, 1] = pressure * np.sin(bore.node_angle)
    return traction
