"""Stress singularities of linear elasticity, found from the mesh.

At the border of a clamped surface and along sharp re-entrant edges the exact stress is infinite (Williams
1952); the computed stress grows with every refinement and is meaningless. Such places are masked: every node
within a radius that does not depend on the element size, so that the peak outside converges. So are the rims
of interfaces and bolt seats (`fea.stress.rim_mask`).
"""

from collections.abc import Sequence

import numpy as np

from fea.stress.boundary_skin import facet_normals, shared_edges, skin
from fea.stress.rim_mask import RimMask, rim_masks
from geometry.arrays import Ints, Mask
from geometry.mirror import PLANE_AXIS
from geometry.surfaces import Surface
from mesh.creases import Creases
from mesh.tetmesh import EDGES, FACET_EDGES, TetMesh

# Where the creases of the solid are not known, a re-entrant edge is sharp if the facets turn there by more
# than this angle. Curved facets follow a fillet smoothly; flat ones turn at each edge, by up to 54° at the
# coarsest size allowed.
CURVED_DEGREES, FLAT_DEGREES = 30.0, 60.0
# Largest distance of a mid-side node from the middle of a straight side, over its length.
_STRAIGHT = 1e-4
# Where the facets turn by more than this there is a cusp, whose faces may be tangent to each other.
_CUSP = np.radians(120.0)
# Radius of the mask relative to the longest side of the body: 4 mm on a rod of 200 mm.
RADIUS = 0.02


def singular_nodes(mesh: TetMesh, held: tuple[Surface, ...] = (), creases: Creases | None = None) -> Ints:
    """Nodes on sharp re-entrant edges and on the borders of clamped surfaces.

    Parameters
    ----------
    mesh
        The mesh, which continues across its mirror planes.
    held
        Surfaces whose displacement is prescribed.
    creases
        Where the surface of the solid turns; without them, where the facets do.
    """
    planes = tuple(plane for plane in PLANE_AXIS if plane in mesh.facets)
    surfaces = [surface for surface in mesh.facets if surface not in planes]
    border = [
        np.intersect1d(mesh.facets[surface], mesh.facets[other])
        for surface in held
        for other in surfaces
        if other not in held
    ]
    return np.unique(np.concatenate([_on_sharp_edges(mesh, surfaces, planes, creases), *border]))


def _on_sharp_edges(
    mesh: TetMesh, surfaces: list[Surface], planes: tuple[Surface, ...], creases: Creases | None
) -> Ints:
    body = skin(mesh, surfaces, planes)
    normals = facet_normals(body.points, body.facets)
    edges = shared_edges(body, normals)
    facet, place = edges.facet[:, 0], edges.place[:, 0]
    ends = body.source[body.facets[facet[:, None], FACET_EDGES[place]]]
    if creases is None:
        turns = edges.cosine < np.cos(np.radians(FLAT_DEGREES if _is_flat(mesh) else CURVED_DEGREES))
    else:
        turns = (creases.find(ends) >= 0) | (edges.cosine < np.cos(_CUSP))
    return np.unique(ends[turns & ~edges.convex])


def _is_flat(mesh: TetMesh) -> bool:
    """Whether the elements have straight sides."""
    if mesh.order == 1:
        return True
    ends = mesh.points[mesh.tets[:, np.array(EDGES)]]
    off = mesh.points[mesh.tets[:, 4:]] - ends.mean(axis=2)
    length = np.linalg.norm(np.ptp(ends, axis=2), axis=-1)
    return bool((np.linalg.norm(off, axis=-1) < _STRAIGHT * length).all())


def masked_nodes(mesh: TetMesh, held: tuple[Surface, ...] = (), creases: Creases | None = None) -> Mask:
    """Whether each node is near a singular place, or near a rim of parts that touch: see `nodes_near`.

    Parameters
    ----------
    mesh, held, creases
        As for `singular_nodes`.

    Returns
    -------
    ndarray
        (n_nodes,).
    """
    near = nodes_near(mesh, singular_nodes(mesh, held, creases), mask_radius(mesh))
    return near | near_rims(mesh, rim_masks(mesh, mask_radius(mesh)))


def near_rims(mesh: TetMesh, masks: Sequence[RimMask]) -> Mask:
    """Whether each node (n_nodes,) is near a rim of parts that touch."""
    near = np.zeros(len(mesh.points), dtype=bool)
    for rim in masks:
        near |= nodes_near(mesh, rim.nodes, rim.radius)
    return near


def mask_radius(mesh: TetMesh) -> float:
    """Radius of the mask, mm; that of rims may be smaller."""
    return RADIUS * float(np.ptp(mesh.points, axis=0).max())


def nodes_near(mesh: TetMesh, singular: Ints, radius: float) -> Mask:
    """Whether each node (n_nodes,) is within a radius, mm, of some nodes, or in an element that has one."""
    near = np.zeros(len(mesh.points), dtype=bool)
    if not singular.size:
        return near
    touching = np.isin(mesh.tets, singular).any(axis=1)
    near[mesh.tets[touching]] = True
    from scipy.spatial import KDTree  # noqa: PLC0415 - only a body with sharp edges needs it

    distance, _ = KDTree(mesh.points[singular]).query(mesh.points)
    return np.asarray(near | (distance <= radius))
