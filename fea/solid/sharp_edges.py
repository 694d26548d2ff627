"""Sharp re-entrant edges of the whole rod: where they are, between which faces, and the ways off them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from fea.solid.boundary import BoundarySurface
from fea.solid.element import shape_functions
from geometry.arrays import Floats, Ints, Mask, linked_groups
from mesh.creases import Creases
from mesh.surface_mesh import SurfaceMesh
from mesh.tetmesh import FACET_EDGES, TetMesh

# Facets whose centres are nearest to a place: the one that holds it is among them.
_CANDIDATES = 24
# A step has left the facets it may walk on if it ends off them by more than this share of its length.
_OFF = 0.4


@dataclass(frozen=True)
class Walks:
    """Places (n, n_steps) on a surface, on n ways."""

    #: nodes, weights: (n, n_steps, n_nodes_of_a_facet): a nodal field there is the weighted sum of its values
    nodes: Ints
    weights: Floats
    ahead: Floats  #: (n, n_steps, 3) unit direction of the way
    reached: Ints  #: (n,) how many steps stay on the facets

    def of(self, field: Floats) -> Floats:
        """Values (n, n_steps, …) of a field (n_points, …)."""
        extra = (1,) * (field.ndim - 1)
        return np.asarray((self.weights.reshape(*self.weights.shape, *extra) * field[self.nodes]).sum(axis=2))


@dataclass(frozen=True)
class Ground:
    """Facets to walk on."""

    points: Floats  #: (n_points, 3)
    facets: Ints  #: (n_facets, 3) or (n_facets, 6), outward
    patch: Ints  #: (n_facets,) number of the face each belongs to: a way stays on one

    def walk(self, start: Floats, ahead: Floats, facet: Ints, step: Floats, count: int) -> Walks:
        """Walk `count` steps (n,), mm, from places (n, 3) along unit tangents, each beginning on a facet."""
        here, patch = start, self.patch[facet]
        on = np.ones(len(start), dtype=bool)
        nodes, weights, directions, reached = [], [], [], np.zeros(len(start), dtype=np.int64)
        for _ in range(count):
            aim = here + step[:, None] * ahead
            facets, share, place = self._nearest(aim, patch)
            on = on & (np.linalg.norm(place - aim, axis=1) < _OFF * step)
            normal = self._flat.normals[facets]
            turned = ahead - (ahead * normal).sum(axis=1, keepdims=True) * normal
            ahead = turned / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-12)
            here = place
            reached += on
            nodes.append(self.facets[facets])
            weights.append(shape_functions(self.facets.shape[1], share.T)[0])
            directions.append(ahead)
        return Walks(np.stack(nodes, 1), np.stack(weights, 1), np.stack(directions, 1), reached)

    def depth(self, start: Floats, ahead: Floats) -> Floats:
        """Distance (n,) from places (n, 3) in the solid to the surface in a direction (n, 3) each, mm."""
        return np.array([self._exit(a, b) for a, b in zip(start, ahead, strict=True)])

    @cached_property
    def _flat(self) -> SurfaceMesh:
        return SurfaceMesh(self.points, self.facets[:, :3])

    @cached_property
    def _centers(self) -> Floats:
        return np.asarray(self._flat.corners.mean(axis=1))

    @cached_property
    def _radii(self) -> Floats:
        return np.asarray(np.linalg.norm(self._flat.corners - self._centers[:, None], axis=2).max(axis=1))

    @cached_property
    def _tree(self) -> KDTree:
        return KDTree(self._centers)

    def _nearest(self, places: Floats, patch: Ints) -> tuple[Ints, Floats, Floats]:
        """Facet (n,) of its patch nearest to each place, where in it (n, 2), and that point (n, 3)."""
        _, candidates = self._tree.query(places, k=min(_CANDIDATES, len(self.facets)))
        corners = self._flat.corners[candidates]
        share, inside = _barycentric(corners, places[:, None])
        sides = corners[..., 1:, :] - corners[..., :1, :]
        at = corners[..., 0, :] + np.einsum("...k,...kx->...x", share, sides)
        apart = np.linalg.norm(at - places[:, None], axis=2)
        apart = np.where(self.patch[candidates] == patch[:, None], apart, np.inf)
        best = (apart - 1e-9 * inside).argmin(axis=1)
        rows = np.arange(len(places))
        return candidates[rows, best], share[rows, best], at[rows, best]

    def _exit(self, start: Floats, ahead: Floats) -> float:
        """Distance to the first facet that a ray leaves the solid through; infinite where there is none."""
        beside = np.cross(self._centers - start, ahead)
        near = ((beside**2).sum(axis=1) <= (1.01 * self._radii) ** 2) & (self._flat.normals @ ahead > 1e-6)
        normal, corners = self._flat.normals[near], self._flat.corners[near]
        distance = ((corners[:, 0] - start) * normal).sum(axis=1) / (normal @ ahead)
        _, inside = _barycentric(corners, start + distance[:, None] * ahead)
        distance = distance[inside & (distance > 0)]
        return float(distance.min(initial=np.inf))


def _barycentric(corners: Floats, places: Floats) -> tuple[Floats, Mask]:
    """Coordinates (…, 2) in triangles (…, 3, 3), clipped, of the nearest points, and whether inside."""
    one, other = corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :]
    to = places - corners[..., 0, :]
    a, b, c = (one**2).sum(-1), (one * other).sum(-1), (other**2).sum(-1)
    d, e = (one * to).sum(-1), (other * to).sum(-1)
    area = a * c - b * b
    share = np.stack([(c * d - b * e) / area, (a * e - b * d) / area], axis=-1)
    slack = 1e-6
    inside = (share >= -slack).all(axis=-1) & (share.sum(axis=-1) <= 1 + slack)
    clipped = np.clip(share, 0.0, 1.0)
    total = clipped.sum(axis=-1, keepdims=True)
    return np.where(inside[..., None], share, clipped / np.maximum(total, 1.0)), inside


# Start of the ray that measures the thickness behind a flank: from the edge, as a share of the rod's longest
# side. It does not depend on the elements, nor does the thickness then.
_BESIDE = 0.002
# Distance from the end of an edge, relative to its length and at most to the rod's, within which the stress
# is that of the corner there.
_END, _END_MOST = 0.25, 0.02


@dataclass(frozen=True)
class SharpEdges:
    """Edges of the mesh on sharp re-entrant edges of the rod, each with its two flanks."""

    #: middle, size: (n, 3) middle of each and (n,) its length, mm
    middle: Floats
    size: Floats
    nodes: Ints  #: (n, 2) the vertices at its ends
    opening: Floats  #: (n,) angle of the notch, outside the material, rad
    facet: Ints  #: (n, 2) of `ground` on either side
    #: normal, away: (n, 2, 3) outward normal of either flank there, and its tangent that leads away from the
    #: edge
    normal: Floats
    away: Floats
    place: Ints  #: (n,) number of the place: one edge of the rod, with its mirror images
    between: tuple[tuple[str, str], ...]  #: per place, the two faces that meet there, in words
    length: Floats  #: (n,) of the connected edge of the rod that it is part of, mm
    at_end: Mask  #: (n,) whether it is next to an end of that edge
    ground: Ground  #: the surface of the rod

    @classmethod
    def of(cls, mesh: TetMesh, creases: Creases) -> "SharpEdges | None":
        """Find them on the whole rod; None where there are none."""
        body = BoundarySurface.of(mesh, list(mesh.facets))
        edges = body.edges
        ends = body.facets[edges.facet[:, :1], FACET_EDGES[edges.place[:, 0]]]
        row = every = creases.find(ends)
        kept = np.flatnonzero((row >= 0) & ~edges.convex)
        if not kept.size:
            return None
        ends, row = ends[kept], row[kept]
        fold = creases.fold[row]
        a, b = mesh.points[ends[:, 0]], mesh.points[ends[:, 1]]
        middle, size = (a + b) / 2, np.linalg.norm(b - a, axis=1)
        normal, away = _flanks(body, kept, (b - a) / size[:, None])
        names = [tuple(sorted(pair)) for pair in creases.between]
        places = sorted({names[label] for label in creases.label[row]})
        place = np.array([places.index(names[label]) for label in creases.label[row]])
        length = _lengths(ends, size, place, len(mesh.points))
        far = np.minimum(_END * length, _END_MOST * float(np.ptp(mesh.points, axis=0).max()))
        joined = body.edges.facet[body.edges.smooth & (every < 0)]
        distance = np.full(len(ends), np.inf)
        for number in np.unique(place):
            of_place = np.flatnonzero(place == number)
            nodes, count = np.unique(ends[of_place], return_counts=True)
            last = mesh.points[nodes[count == 1]]
            if len(last):
                apart = np.linalg.norm(middle[of_place, None] - last, axis=2)
                distance[of_place] = apart.min(axis=1)
        return cls(
            middle=middle,
            size=size,
            nodes=ends,
            opening=np.where(edges.cosine[kept] < 0, fold, np.pi - fold),
            facet=edges.facet[kept],
            normal=normal,
            away=away,
            place=place,
            between=tuple((one, other) for one, other in places),
            length=length,
            at_end=distance < far,
            ground=Ground(body.points, body.facets, linked_groups(len(body.facets), *joined.T)),
        )

    def thickness(self, rows: Ints) -> Floats:
        """Thickness (n, 2) of the material behind either flank of some of the edges, mm."""
        depth, beside = np.empty((len(rows), 2)), _BESIDE * float(np.ptp(self.ground.points, axis=0).max())
        for side in (0, 1):
            inwards = -self.normal[rows, side]
            start = self.middle[rows] + beside * (self.away[rows, side] + 1e-2 * inwards)
            depth[:, side] = self.ground.depth(start, inwards)
        return depth

    def walks(self, side: int, step: Floats, count: int, rows: Ints) -> Walks:
        """Walk away from some of the edges over one flank, `count` steps (n,) of so many mm."""
        return self.ground.walk(self.middle[rows], self.away[rows, side], self.facet[rows, side], step, count)


def _flanks(body: BoundarySurface, rows: Ints, along: Floats) -> tuple[Floats, Floats]:
    """Outward normals and tangents away from the edge (n, 2, 3) of the facets on either side."""
    normal, away = np.empty((2, len(rows), 2, 3))
    for side in (0, 1):
        facet, place = body.edges.facet[rows, side], body.edges.place[rows, side]
        at = place + 3 if body.facets.shape[1] == 6 else place
        n = body.normals[facet, at]
        start = body.points[body.facets[facet, place]]
        inwards = body.points[body.facets[facet, (place + 2) % 3]] - start
        across = inwards - (inwards * n).sum(axis=1, keepdims=True) * n
        across -= (across * along).sum(axis=1, keepdims=True) * along
        normal[:, side], away[:, side] = n, across / np.linalg.norm(across, axis=1, keepdims=True)
    return normal, away


def _lengths(ends: Ints, size: Floats, place: Ints, n_points: int) -> Floats:
    """Length (n,) of the connected edge that each mesh edge is part of, within its place."""
    total = np.empty(len(ends))
    for number in np.unique(place):
        of_place = np.flatnonzero(place == number)
        piece = linked_groups(n_points, *ends[of_place].T)
        sums = np.bincount(piece[ends[of_place, 0]], size[of_place])
        total[of_place] = sums[piece[ends[of_place, 0]]]
    return total
