"""Stress singularities of linear elasticity, found from the mesh.

At the border of a clamped surface and along sharp re-entrant edges the exact stress is infinite (Williams
1952); the computed stress grows with every refinement and is meaningless. Such places are masked: every node
within a radius that does not depend on the element size, so that the peak outside converges. So are the rims
of interfaces and bolt seats.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.spatial import KDTree

from fea.solid.boundary import BoundarySurface
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import Surface
from mesh.creases import Creases, SurfaceMesh, rims
from mesh.tetmesh import EDGES, FACET_EDGES, TetMesh

# Radius of the mask, over the smallest measure.
_SHARE = 0.25


@dataclass(frozen=True)
class RimMask:
    """Rims with one name, and the radius within which stress is left out."""

    name: str  #: in words
    nodes: Ints  #: (n,) on the rims
    radius: float  #: mm


def rim_masks(mesh: TetMesh, largest: float) -> tuple[RimMask, ...]:
    """Masks of the rims of a mesh of separate bodies, with radii of at most `largest`, mm."""
    all_rims = rims(mesh)
    if not all_rims:
        return ()
    part = np.zeros(len(mesh.points), dtype=np.int64)
    if mesh.part is not None:
        part[mesh.tets] = mesh.part[:, None]
    corners = mesh.points[mesh.tets[:, :4]]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
    volume = np.bincount(part[mesh.tets[:, 0]], volumes)
    masks: dict[str, RimMask] = {}
    for rim in all_rims:
        facets = mesh.facets[rim.surface]
        edges = np.concatenate([other.edges for other in all_rims if other.surface is rim.surface])
        measures = []
        for number in np.unique(part[rim.nodes]):
            area = SurfaceMesh(mesh.points, facets[part[facets[:, 0]] == number][:, :3]).areas.sum()
            ends = mesh.points[edges[part[edges[:, 0]] == number]]
            border = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
            measures += [2 * area / border, volume[number] / area]
        radius = min(largest, _SHARE * float(min(measures)))
        same = masks.get(rim.name, RimMask(rim.name, rim.nodes, radius))
        nodes = np.union1d(same.nodes, rim.nodes)
        masks[rim.name] = RimMask(rim.name, nodes, min(same.radius, radius))
    return tuple(masks.values())


# Without known creases, a re-entrant edge is sharp if the facets turn there by more than this. Curved facets
# follow a fillet smoothly; flat ones turn at each edge, by up to 54° at the coarsest size allowed.
CURVED_DEGREES, FLAT_DEGREES = 30.0, 60.0
# Largest distance of a mid-side node from the middle of a straight side, over its length.
_STRAIGHT = 1e-4
# Of the stress per angle of flat facets in place of a curved surface, 1/rad.
_OF_TURN = 2 * np.log(2) / np.pi
# Where the facets turn by more than this there is a cusp, whose faces may be tangent to each other.
_CUSP = np.radians(120.0)
# Radius of the mask relative to the longest side of the body: 4 mm on a rod of 200 mm.
RADIUS = 0.02


class BoundaryEdges:
    """Edges at which the facets of a body meet; the body continues across the mirror planes of its mesh."""

    def __init__(self, mesh: TetMesh) -> None:
        surfaces = [surface for surface in mesh.facets if surface not in mesh.planes]
        self._mesh, body = mesh, BoundarySurface.of(mesh, surfaces, mesh.planes)
        self._edges, self._n_facets = body.edges, len(body.facets)
        facet, place = self._edges.facet[:, 0], self._edges.place[:, 0]
        self._ends = body.source[body.facets[facet[:, None], FACET_EDGES[place]]]  # (n_edges, 2) nodes

    def singular_nodes(self, held: tuple[Surface, ...] = (), creases: Creases | None = None) -> Ints:
        """Nodes on sharp re-entrant edges and on the borders of clamped surfaces.

        Creases are where the surface of the solid turns; without them, where the facets do.
        """
        mesh, edges = self._mesh, self._edges
        pairs = product(held, [surface for surface in mesh.facets if surface not in (*mesh.planes, *held)])
        border = [np.intersect1d(mesh.facets[first], mesh.facets[second]) for first, second in pairs]
        if creases is None:
            turns = edges.cosine < np.cos(np.radians(FLAT_DEGREES if _is_flat(mesh) else CURVED_DEGREES))
        else:
            cusp = edges.cosine < np.cos(_CUSP)
            # A facet that turns back at more than one of its edges is folded over: a flaw of the mesh.
            folded = np.bincount(edges.facet[cusp].ravel(), minlength=self._n_facets) > 1
            turns = (creases.find(self._ends) >= 0) | (cusp & ~folded[edges.facet].any(axis=1))
        return np.unique(np.concatenate([self._ends[turns & ~edges.convex].ravel(), *border]))

    def facet_share(self) -> Floats:
        """Share (n_nodes,) by which flat facets in place of a curved surface may change the stress.

        A surface whose slope changes by a small angle t at each edge of flat facets has a stress that differs
        from that of the smooth one by (2 t / pi) ln(2 sin(pi x / l)), x from the edge of a facet of length l
        (Gao 1991, first order of a slightly undulating surface): 0.44 t between edges, of the other sign
        within a twelfth of l, which elements as large as facets do not resolve. Returned is 0.44 times the
        largest t, rad, of the edges of the elements at the node. Edges that turn by more than `FLAT_DEGREES`
        are those of the solid. All are 0 where facets are curved, and of first order: the error of such
        elements is fitted to solids with flat facets.
        """
        mesh, share = self._mesh, np.zeros(len(self._mesh.points))
        if mesh.order == 1 or not _is_flat(mesh):
            return share
        turn = np.arccos(np.clip(self._edges.cosine, -1.0, 1.0))
        turn[turn > np.radians(FLAT_DEGREES)] = 0.0
        np.maximum.at(share, self._ends, turn[:, None])
        near = np.zeros_like(share)
        np.maximum.at(near, mesh.tets, share[mesh.tets].max(axis=1, keepdims=True))
        return np.asarray(_OF_TURN * near)


def _is_flat(mesh: TetMesh) -> bool:
    if mesh.order == 1:
        return True
    ends = mesh.points[mesh.tets[:, np.array(EDGES)]]
    sagitta = mesh.points[mesh.tets[:, 4:]] - ends.mean(axis=2)
    length = np.linalg.norm(np.ptp(ends, axis=2), axis=-1)
    return bool((np.linalg.norm(sagitta, axis=-1) < _STRAIGHT * length).all())


def masked_nodes(mesh: TetMesh, singular: Ints, rims: Sequence[RimMask] = ()) -> Mask:
    """Whether each node (n_nodes,) is near a singular place or a rim of parts that touch."""
    near = nodes_near(mesh, singular, mask_radius(mesh))
    for rim in rims:
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
    near[mesh.tets[np.isin(mesh.tets, singular).any(axis=1)]] = True
    distance, _ = KDTree(mesh.points[singular]).query(mesh.points)
    return np.asarray(near | (distance <= radius))
