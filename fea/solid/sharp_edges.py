"""Sharp re-entrant edges of the whole rod, the faces between which they lie, and paths away from them."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from fea.solid.assembly import shape_functions
from fea.solid.boundary import BoundarySurface
from geometry.arrays import Floats, Ints, Mask, linked_groups
from mesh.creases import Creases, SurfaceMesh
from mesh.tetmesh import FACET_EDGES, TetMesh

# Nodes of a flat facet, which does not show how its face is curved.
_FLAT = 3
# Facets whose centres are nearest to a place: the one that holds it is among them.
_CANDIDATES = 24
# A step has left its face if it ends off it by more than this share of its length.
_OFF = 0.4
# A path ends where its face turns by more than this over the given length, rad: in a hollow, such as a
# fillet, the stress is another notch's; over a round it leads to another face.
_HOLLOW, _ROUND = 0.1, 0.4


@dataclass(frozen=True)
class SurfacePaths:
    """Places (n, n_steps) along n paths on a surface."""

    #: nodes, weights: (n, n_steps, n_nodes_of_a_facet): a nodal field there is the weighted sum of its values
    nodes: Ints
    weights: Floats
    ahead: Floats  #: (n, n_steps, 3) unit direction of the path
    length: Ints  #: (n,) number of steps that stay on the face

    def values(self, field: Floats) -> Floats:
        """Values (n, n_steps, …) of a field (n_points, …)."""
        extra = (1,) * (field.ndim - 1)
        return np.asarray((self.weights.reshape(*self.weights.shape, *extra) * field[self.nodes]).sum(axis=2))


@dataclass(frozen=True)
class FacetSurface:
    """Outward facets, grouped into smooth faces."""

    points: Floats  #: (n_points, 3)
    facets: Ints  #: (n_facets, 3) or (n_facets, 6), outward
    face: Ints  #: (n_facets,) number of the face each belongs to
    normals: Floats  #: (n_facets, n_nodes, 3) outward, at the nodes of each

    def paths(
        self, start: Floats, ahead: Floats, facet: Ints, step: Floats, *, count: int, within: Floats
    ) -> SurfacePaths:
        """Follow `count` steps (n,), mm, from places (n, 3) along unit tangents, each beginning on a facet.

        A path ends where its face does, or where the face turns within a length (n,), mm.
        """
        here, face, rows = start, self.face[facet], np.arange(len(start))
        on = np.ones(len(start), dtype=bool)
        nodes, weights, directions, length = [], [], [], np.zeros(len(start), dtype=np.int64)
        # Angle by which each path has risen so far, and how many steps ago it is compared.
        risen, window = np.zeros((count + 1, len(start))), np.rint(within / step).astype(int)
        for number in range(count):
            aim = here + step[:, None] * ahead
            facets, share, place = self._nearest(aim, face)
            on = on & (np.linalg.norm(place - aim, axis=1) < _OFF * step)
            shape = shape_functions(self.facets.shape[1], share.T)[0]
            normal = (shape[..., None] * self.normals[facets]).sum(axis=1)
            normal /= np.linalg.norm(normal, axis=1, keepdims=True)
            across = (ahead * normal).sum(axis=1)
            if self.facets.shape[1] > _FLAT:
                risen[number + 1] = risen[number] - np.arcsin(np.clip(across, -1.0, 1.0))
                rise = risen[number + 1] - risen[np.maximum(number + 1 - window, 0), rows]
                on = on & (rise > -_ROUND) & (rise < _HOLLOW)
            turned = ahead - across[:, None] * normal
            ahead = turned / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-12)
            here = place
            length += on
            nodes.append(self.facets[facets])
            weights.append(shape)
            directions.append(ahead)
        return SurfacePaths(np.stack(nodes, 1), np.stack(weights, 1), np.stack(directions, 1), length)

    def depth(self, start: Floats, ahead: Floats) -> Floats:
        """Distance (n,) from places (n, 3) in the solid to the surface in a direction (n, 3) each, mm."""
        return np.array([self._exit(place, along) for place, along in zip(start, ahead, strict=True)])

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

    def _nearest(self, places: Floats, face: Ints) -> tuple[Ints, Floats, Floats]:
        """Facet (n,) of its face nearest to each place, where in it (n, 2), and that point (n, 3)."""
        _, candidates = self._tree.query(places, k=min(_CANDIDATES, len(self.facets)))
        corners = self._flat.corners[candidates]
        share, inside = _barycentric(corners, places[:, None])
        sides = corners[..., 1:, :] - corners[..., :1, :]
        at = corners[..., 0, :] + np.einsum("...k,...kx->...x", share, sides)
        apart = np.linalg.norm(at - places[:, None], axis=2)
        apart = np.where(self.face[candidates] == face[:, None], apart, np.inf)
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
    first, second = corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :]
    to = places - corners[..., 0, :]
    a, b, c = (first**2).sum(-1), (first * second).sum(-1), (second**2).sum(-1)
    d, e = (first * to).sum(-1), (second * to).sum(-1)
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
# is that of the corner there. Between its ends an edge is looked at in places at most so far apart, relative
# to the rod's length, but in no fewer and no more than these.
_END, _END_MOST = 0.25, 0.02
_APART, _FEWEST, _MOST = 0.005, 5, 33


@dataclass(frozen=True)
class SharpEdges:
    """Stations on the sharp re-entrant edges of the rod, each with two flanks.

    They divide each edge evenly, whatever mesh edges it consists of.
    """

    #: at, size: (n, 3) each station, and (n,) the length of the mesh edge it is on, mm
    at: Floats
    size: Floats
    nodes: Ints  #: (n, 2) the vertices at the ends of that mesh edge
    opening: Floats  #: (n,) angle of the notch, outside the material, rad
    facet: Ints  #: (n, 2) of `surface` on either side
    #: normal, away: (n, 2, 3) outward normal of either flank there, and its tangent away from the edge
    normal: Floats
    away: Floats
    place: Ints  #: (n,) number of the place: one edge of the rod, with its mirror images
    between: tuple[tuple[str, str], ...]  #: per place, the two faces that meet there, in words
    edge: Ints  #: (n,) number of the connected edge of the rod that it is on, along which stations follow
    length: Floats  #: (n,) of that edge, mm
    surface: FacetSurface  #: of the rod

    @classmethod
    def of(cls, mesh: TetMesh, creases: Creases) -> "SharpEdges | None":
        """Find the edges of the whole rod; None where there are none."""
        body = BoundarySurface.of(mesh, list(mesh.facets))
        edges = body.edges
        ends = body.facets[edges.facet[:, :1], FACET_EDGES[edges.place[:, 0]]]
        crease = creases.find(ends)
        sharp = np.flatnonzero((crease >= 0) & ~edges.convex)
        if not sharp.size:
            return None
        names = [tuple(sorted(pair)) for pair in creases.between]
        places = sorted({names[label] for label in creases.label[crease[sharp]]})
        place = np.array([places.index(names[label]) for label in creases.label[crease[sharp]]])
        number, share, edge, length = _stations(mesh.points, ends[sharp], place)
        row = sharp[number]
        fold = creases.fold[crease[row]]
        a, b = mesh.points[ends[row, 0]], mesh.points[ends[row, 1]]
        size = np.linalg.norm(b - a, axis=1)
        normal, away = _flanks(body, row, share)
        joined = edges.facet[edges.smooth & (crease < 0)]
        face = linked_groups(len(body.facets), *joined.T)
        return cls(
            at=a + share[:, None] * (b - a),
            size=size,
            nodes=ends[row],
            opening=np.where(edges.cosine[row] < 0, fold, np.pi - fold),
            facet=edges.facet[row],
            normal=normal,
            away=away,
            place=place[number],
            between=tuple((first, second) for first, second in places),
            edge=edge,
            length=length,
            surface=FacetSurface(body.points, body.facets, face, body.normals),
        )

    def thickness(self, rows: Ints) -> Floats:
        """Thickness (n, 2) of the material behind either flank of some of the edges, mm."""
        depth, beside = np.empty((len(rows), 2)), _BESIDE * float(np.ptp(self.surface.points, axis=0).max())
        for side in (0, 1):
            inwards = -self.normal[rows, side]
            start = self.at[rows] + beside * (self.away[rows, side] + 1e-2 * inwards)
            depth[:, side] = self.surface.depth(start, inwards)
        return depth

    def paths(self, side: int, rows: Ints, step: Floats, count: int, within: Floats) -> SurfacePaths:
        """Follow `count` steps (n,), mm, from some stations over one flank; see `FacetSurface.paths`."""
        start, ahead, facet = self.at[rows], self.away[rows, side], self.facet[rows, side]
        return self.surface.paths(start, ahead, facet, step, count=count, within=within)


def _flanks(body: BoundarySurface, rows: Ints, share: Floats) -> tuple[Floats, Floats]:
    """Outward normals and tangents away from the edge (n, 2, 3) of the facets on either side.

    They are those at a share (n,) of the mesh edges, from the first end.
    """
    normal, away = np.empty((2, len(rows), 2, 3))
    curved, s = body.facets.shape[1] > _FLAT, share[:, None]
    for side in (0, 1):
        facet, place = body.edges.facet[rows, side], body.edges.place[rows, side]
        # On the other side the edge runs backwards.
        first, last = (place, (place + 1) % 3)[:: 1 - 2 * side]
        a, b = body.points[body.facets[facet, first]], body.points[body.facets[facet, last]]
        along = b - a
        n = (1 - s) * body.normals[facet, first] + s * body.normals[facet, last]
        if curved:
            sag = body.points[body.facets[facet, place + 3]] - (a + b) / 2
            along = along + 4 * (1 - 2 * s) * sag
            middle = (
                body.normals[facet, place + 3] - (body.normals[facet, first] + body.normals[facet, last]) / 2
            )
            n = n + 4 * s * (1 - s) * middle
        n /= np.linalg.norm(n, axis=1, keepdims=True)
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        across = np.cross(along, n) * (2 * side - 1)
        normal[:, side], away[:, side] = n, across / np.linalg.norm(across, axis=1, keepdims=True)
    return normal, away


def _stations(points: Floats, ends: Ints, place: Ints) -> tuple[Ints, Floats, Ints, Floats]:
    """Stations of the edges of the rod: mesh edge, share of it from its first end, edge, and its length.

    Mesh edges (n, 2) are part of the edge of the rod with the number `place` (n,).
    """
    longest = float(np.ptp(points, axis=0).max())
    size = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)
    stations = []
    for edge, (chain, forward, closed) in enumerate(_chains(points, ends, place)):
        position = np.concatenate([[0.0], np.cumsum(size[chain])])
        length = float(position[-1])
        margin = 0.0 if closed else min(_END * length, _END_MOST * longest)
        count = int(np.clip(np.ceil((length - 2 * margin) / (_APART * longest)), _FEWEST, _MOST))
        along = np.linspace(margin, length - margin, count + closed)[:count]
        which = np.clip(np.searchsorted(position, along, side="right") - 1, 0, len(chain) - 1)
        share = np.clip((along - position[which]) / size[chain[which]], 0.0, 1.0)
        share = np.where(forward[which], share, 1 - share)
        stations.append((chain[which], share, np.full(count, edge), np.full(count, length)))
    numbers, shares, edges, lengths = (np.concatenate(column) for column in zip(*stations, strict=True))
    return numbers, shares, edges, lengths


def _chains(points: Floats, ends: Ints, place: Ints) -> Iterator[tuple[Ints, Mask, bool]]:
    """Yield mesh edges in their order along an edge of the rod, which run forward, and whether it is closed.

    A closed edge begins at its outermost vertex.
    """
    for number in np.unique(place):
        edges_at: dict[int, list[int]] = {}  # by node
        for edge in np.flatnonzero(place == number).tolist():
            for node in ends[edge].tolist():
                edges_at.setdefault(node, []).append(edge)
        unused = {edge for edges in edges_at.values() for edge in edges}
        outermost = sorted(edges_at, key=lambda node: tuple(points[node]), reverse=True)
        for start in sorted(outermost, key=lambda node: len(edges_at[node]) == 2):  # open ends first
            while first := unused.intersection(edges_at[start]):
                edge, node, chain, forward = min(first), start, list[int](), list[bool]()
                while True:
                    unused.discard(edge)
                    chain.append(edge)
                    forward.append(bool(ends[edge, 0] == node))
                    node = int(ends[edge].sum()) - node
                    following = unused.intersection(edges_at[node])
                    if len(edges_at[node]) != 2 or not following:
                        break
                    edge = following.pop()
                yield np.array(chain), np.array(forward), node == start
