"""Sharp re-entrant edges of the whole rod: where they are, between which faces, and the ways off them."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from fea.stress.boundary_skin import Edges, Skin, facet_normals, shared_edges, skin
from fea.stress.walk import Ground, Walks
from geometry.arrays import Floats, Ints, Mask
from mesh.creases import Creases
from mesh.tetmesh import FACET_EDGES, TetMesh

# Start of the ray that measures the thickness behind a flank: from the edge, as a share of the mesh's edge.
_BESIDE = 0.5
# Distance from the end of an edge, relative to its length and at most to the rod's, within which the stress
# is that of the corner there.
_END, _END_MOST = 0.25, 0.02


@dataclass(frozen=True)
class SharpEdges:
    """Edges of the mesh on sharp re-entrant edges of the rod, each with its two flanks.

    Attributes
    ----------
    middle, size
        (n, 3) middle of each and (n,) its length, mm.
    nodes
        (n, 2) the vertices at its ends.
    opening
        (n,) angle of the notch, outside the material, rad.
    facet
        (n, 2) of `ground` on either side.
    normal, away
        (n, 2, 3) outward normal of either flank there, and its tangent that leads away from the edge.
    place
        (n,) number of the place: one edge of the rod, with its mirror images.
    between
        Per place, the two faces that meet there, in words.
    length
        (n,) of the connected edge of the rod that it is part of, mm.
    at_end
        (n,) whether it is next to an end of that edge.
    ground
        The surface of the rod.
    """

    middle: Floats
    size: Floats
    nodes: Ints
    opening: Floats
    facet: Ints
    normal: Floats
    away: Floats
    place: Ints
    between: tuple[tuple[str, str], ...]
    length: Floats
    at_end: Mask
    ground: Ground

    @classmethod
    def of(cls, mesh: TetMesh, creases: Creases) -> "SharpEdges | None":
        """Find them on the whole rod; None where there are none."""
        body = skin(mesh, list(mesh.facets), ())
        normals = facet_normals(body.points, body.facets)
        edges = shared_edges(body, normals)
        ends = body.facets[edges.facet[:, :1], FACET_EDGES[edges.place[:, 0]]]
        row = every = creases.find(ends)
        found = np.flatnonzero((row >= 0) & ~edges.convex)
        if not found.size:
            return None
        ends, row = ends[found], row[found]
        fold = creases.fold[row]
        a, b = mesh.points[ends[:, 0]], mesh.points[ends[:, 1]]
        middle, size = (a + b) / 2, np.linalg.norm(b - a, axis=1)
        normal, away = _flanks(body, normals, edges, found, (b - a) / size[:, None])
        names = [tuple(sorted(pair)) for pair in creases.between]
        places = sorted({names[label] for label in creases.label[row]})
        place = np.array([places.index(names[label]) for label in creases.label[row]])
        length = _lengths(ends, size, place, len(mesh.points))
        far = np.minimum(_END * length, _END_MOST * float(np.ptp(mesh.points, axis=0).max()))
        return cls(
            middle=middle,
            size=size,
            nodes=ends,
            opening=np.where(edges.cosine[found] < 0, fold, np.pi - fold),
            facet=edges.facet[found],
            normal=normal,
            away=away,
            place=place,
            between=tuple((one, other) for one, other in places),
            length=length,
            at_end=_to_end(mesh.points, ends, place, middle) < far,
            ground=Ground(body.points, body.facets, _patches(body, edges, every)),
        )

    def thickness(self, rows: Ints) -> Floats:
        """Thickness (n, 2) of the material behind either flank of some of the edges, mm."""
        found = np.empty((len(rows), 2))
        for side in (0, 1):
            inwards, size = -self.normal[rows, side], self.size[rows, None]
            start = self.middle[rows] + _BESIDE * size * self.away[rows, side] + 1e-3 * size * inwards
            found[:, side] = self.ground.depth(start, inwards)
        return found

    def walks(self, side: int, step: Floats, count: int, rows: Ints) -> Walks:
        """Walk away from some of the edges over one flank, `count` steps (n,) of so many mm."""
        return self.ground.walk(self.middle[rows], self.away[rows, side], self.facet[rows, side], step, count)


def _flanks(body: Skin, normals: Floats, edges: Edges, found: Ints, along: Floats) -> tuple[Floats, Floats]:
    """Outward normals and tangents away from the edge (n, 2, 3) of the facets on either side."""
    normal, away = np.empty((2, len(found), 2, 3))
    for side in (0, 1):
        facet, place = edges.facet[found, side], edges.place[found, side]
        at = place + 3 if body.facets.shape[1] == 6 else place
        n = normals[facet, at]
        start = body.points[body.facets[facet, place]]
        inwards = body.points[body.facets[facet, (place + 2) % 3]] - start
        across = inwards - (inwards * n).sum(axis=1, keepdims=True) * n
        across -= (across * along).sum(axis=1, keepdims=True) * along
        normal[:, side], away[:, side] = n, across / np.linalg.norm(across, axis=1, keepdims=True)
    return normal, away


def _patches(body: Skin, edges: Edges, crease: Ints) -> Ints:
    """Number (n_facets,) of the face of each facet: facets are joined but across creases."""
    joined = edges.facet[edges.smooth & (crease < 0)]
    n = len(body.facets)
    graph = sparse.coo_array((np.ones(len(joined)), (joined[:, 0], joined[:, 1])), shape=(n, n))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def _lengths(ends: Ints, size: Floats, place: Ints, n_points: int) -> Floats:
    """Length (n,) of the connected edge that each mesh edge is part of, within its place."""
    total = np.empty(len(ends))
    for number in np.unique(place):
        own = np.flatnonzero(place == number)
        graph = sparse.coo_array((np.ones(own.size), ends[own].T), shape=(n_points, n_points))
        _, piece = connected_components(graph, directed=False)
        sums = np.bincount(piece[ends[own, 0]], size[own])
        total[own] = sums[piece[ends[own, 0]]]
    return total


def _to_end(points: Floats, ends: Ints, place: Ints, middle: Floats) -> Floats:
    """Distance (n,) of each mesh edge from the nearest end of its place's edges; infinite without one."""
    found = np.full(len(ends), np.inf)
    for number in np.unique(place):
        own = np.flatnonzero(place == number)
        nodes, count = np.unique(ends[own], return_counts=True)
        last = points[nodes[count == 1]]
        if len(last):
            apart = np.linalg.norm(middle[own, None] - last, axis=2)
            found[own] = apart.min(axis=1)
    return found
