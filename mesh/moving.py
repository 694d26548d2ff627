"""Move a mesh to a solid of other dimensions, so that results change smoothly with them."""

from dataclasses import dataclass, replace
from functools import cached_property

import gmsh
import numpy as np
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu
from scipy.spatial import KDTree

from geometry.arrays import Floats, Ints, Mask
from mesh.generate import snapped
from mesh.quality import Quality, measure, shape, with_straight_edges
from mesh.tetmesh import EDGES, TetMesh

# Of the size of the solid: nodes that are further from those of gmsh were moved off the surface.
_SAME = 1e-9

# Boundary of each entity by its dimension and tag.
Topology = dict[tuple[int, int], tuple[int, ...]]


@dataclass(frozen=True)
class MeshClassification:
    """Classification of the nodes of a mesh on the vertices, curves and faces of its solid."""

    #: dim, tag: (n_nodes,) of the entity of lowest dimension that holds each node, by gmsh; 3 inside a volume
    dim: Ints
    tag: Ints
    share: Floats  #: (n_nodes,) for those on a curve, how far along it, 0 … 1 of its parameter
    start: dict[int, int]  #: by curve, the vertex where its parameter begins
    topology: Topology  #: of the solid

    @property
    def closures(self) -> dict[int, set[tuple[int, int]]]:
        """By face: itself, its curves and their vertices, each by dimension and tag."""
        closures: dict[int, set[tuple[int, int]]] = {}
        for (dim, face), curves in self.topology.items():
            if dim == 2:
                points = {(0, abs(point)) for curve in curves for point in self.topology[1, abs(curve)]}
                closures[face] = {(2, face), *((1, abs(curve)) for curve in curves), *points}
        return closures


def classify(mesh: TetMesh) -> MeshClassification:
    """Classify the nodes of a mesh on the open model, from which it was made."""
    dim, tag = np.full(len(mesh.points), 3), np.zeros(len(mesh.points), dtype=np.int64)
    share, tree = np.zeros(len(mesh.points)), KDTree(mesh.points)
    near = _SAME * float(np.ptp(mesh.points, axis=0).max())
    for kind in (2, 1, 0):
        for _, entity in gmsh.model.getEntities(kind):
            places = gmsh.model.mesh.getNodes(kind, entity)[1].reshape(-1, 3)
            if not len(places):
                continue
            distance, node = tree.query(places)
            node = node[distance <= near]
            dim[node], tag[node] = kind, entity
            if kind == 1:
                share[node] = _shares(entity, mesh.points[node])
    curves = [entity for _, entity in gmsh.model.getEntities(1)]
    return MeshClassification(dim, tag, share, {curve: start_of(curve) for curve in curves}, topology())


def topology() -> Topology:
    """Return the boundary of each entity of the open model."""
    return {
        (dim, tag): tuple(part for _, part in gmsh.model.getBoundary([(dim, tag)], combined=False))
        for dim in (1, 2, 3)
        for _, tag in gmsh.model.getEntities(dim)
    }


def start_of(curve: int) -> int:
    """Return the vertex where the parameter of a curve begins; 0 for a curve without vertices."""
    ends = [tag for _, tag in gmsh.model.getBoundary([(1, curve)], combined=False, oriented=False)]
    if not ends:
        return 0
    (least,), _ = gmsh.model.getParametrizationBounds(1, curve)
    place = gmsh.model.getValue(1, curve, [least])
    places = np.array([gmsh.model.getValue(0, tag, []) for tag in ends])
    return int(ends[int(np.linalg.norm(places - place, axis=1).argmin())])


def _shares(curve: int, places: Floats) -> Floats:
    (least,), (most,) = gmsh.model.getParametrizationBounds(1, curve)
    at = gmsh.model.getParametrization(1, curve, places.ravel()) if len(places) else np.zeros(0)
    return np.asarray((at - least) / (most - least))


# Of the shape of the worst element before: a mesh with much worse ones is made again.
_WORSE = 0.3


@dataclass(frozen=True)
class MovableMesh:
    """A mesh that can follow its solid.

    Nodes on vertices and curves keep their share of the way; those on faces, which are put on the face again,
    and inside solve Laplace's equation on the graph of edges, weighted by the inverse square of the length,
    so that small elements keep their shape.
    """

    mesh: TetMesh  #: on the solid from which it was made
    classification: MeshClassification  #: where its nodes lie on its solid

    def moved(self) -> tuple[TetMesh, Quality] | None:
        """Return the mesh on the open solid, with its quality; None for other faces, or bad elements."""
        if topology() != self.classification.topology:
            return None
        mesh, straightened = with_straight_edges(snapped(replace(self.mesh, points=self._points())))
        after = measure(mesh, straightened)
        sound = after.least_scaled_jacobian > 0 and after.least_shape > _WORSE * self._least_shape
        return (mesh, after) if sound else None

    def _points(self) -> Floats:
        old, dim = self.mesh.points, self.classification.dim
        new = old.copy()
        self._on_vertices_and_curves(new)
        vertex = self._vertices
        surface, inside = vertex & (dim == 2), vertex & (dim == 3)
        new[surface] += self._surface.follow(new - old, surface, vertex & (dim < 2))
        self._on_faces(new, surface)
        new[inside] += self._volume.follow(new - old, inside, vertex & (dim < 3))
        middles = ~vertex & (dim >= 2)
        new[middles] = self._between(new)[middles] + (old - self._between(old))[middles]
        self._on_faces(new, middles & (dim == 2))
        return new

    def _on_vertices_and_curves(self, new: Floats) -> None:
        dim, tag, share = self.classification.dim, self.classification.tag, self.classification.share
        for node in np.flatnonzero(dim == 0):
            new[node] = gmsh.model.getValue(0, int(tag[node]), [])
        for curve in np.unique(tag[dim == 1]).tolist():
            nodes = np.flatnonzero((dim == 1) & (tag == curve))
            along = share[nodes] if start_of(curve) == self.classification.start[curve] else 1 - share[nodes]
            (least,), (most,) = gmsh.model.getParametrizationBounds(1, curve)
            places = gmsh.model.getValue(1, curve, least + along * (most - least))
            new[nodes] = np.reshape(places, (-1, 3))

    def _on_faces(self, new: Floats, some: Mask) -> None:
        for face in np.unique(self.classification.tag[some]).tolist():
            nodes = np.flatnonzero(some & (self.classification.tag == face))
            places, _ = gmsh.model.getClosestPoint(2, face, new[nodes].ravel())
            new[nodes] = np.reshape(places, (-1, 3))

    @cached_property
    def _least_shape(self) -> float:
        return float(shape(self.mesh).min())

    @cached_property
    def _vertices(self) -> Mask:
        return np.isin(np.arange(len(self.mesh.points)), self.mesh.tets[:, :4])

    @cached_property
    def _ends(self) -> Ints:
        pairs = np.sort(self.mesh.tets[:, EDGES].reshape(-1, 2), axis=1)
        return np.unique(pairs, axis=0)

    @cached_property
    def _of_middles(self) -> Ints:
        """Vertices (n_nodes, 2) at the ends of the edge of each node; a vertex has itself."""
        ends = np.repeat(np.arange(len(self.mesh.points))[:, None], 2, axis=1)
        if self.mesh.order == 2:
            ends[self.mesh.tets[:, 4:].ravel()] = self.mesh.tets[:, EDGES].reshape(-1, 2)
        return ends

    def _between(self, points: Floats) -> Floats:
        return np.asarray(points[self._of_middles].mean(axis=1))

    @cached_property
    def _volume(self) -> "_Graph":
        return self._graph(self._ends, 3)

    @cached_property
    def _surface(self) -> "_Graph":
        dim, tag = self.classification.dim, self.classification.tag
        i, j = np.where(dim[self._ends[:, :1]] >= dim[self._ends[:, 1:]], self._ends, self._ends[:, ::-1]).T
        along = dim[i] == 2
        i, j = i[along], j[along]
        of_face = self.classification.closures
        entities = zip(tag[i].tolist(), dim[j].tolist(), tag[j].tolist(), strict=True)
        same = [(kind, entity) in of_face[face] for face, kind, entity in entities]
        return self._graph(self._ends[along][same], 2)

    def _graph(self, ends: Ints, kind: int) -> "_Graph":
        count = len(self.mesh.points)
        i, j = ends.T
        weight = 1 / ((self.mesh.points[i] - self.mesh.points[j]) ** 2).sum(axis=1)
        weights = sparse.coo_array((weight, (i, j)), shape=(count, count)).tocsr()
        weights = (weights + weights.T).tocsr()
        free = self._vertices & (self.classification.dim == kind)
        laplacian = sparse.diags_array(weights.sum(axis=1)) - weights
        return _Graph(weights, splu(laplacian.tocsr()[free][:, free].tocsc()))


@dataclass(frozen=True)
class _Graph:
    weights: sparse.csr_array
    solver: SuperLU

    def follow(self, shift: Floats, free: Mask, fixed: Mask) -> Floats:
        """Displacement (n_free, 3) of free nodes that follow those whose shift is known."""
        return np.asarray(self.solver.solve(self.weights[free][:, fixed] @ shift[fixed]))
