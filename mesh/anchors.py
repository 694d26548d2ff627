"""Where the nodes of a mesh lie on the solid: on which of its vertices, curves and faces."""

from dataclasses import dataclass

import gmsh
import numpy as np
from scipy.spatial import cKDTree

from geometry.arrays import Floats, Ints
from mesh.tetmesh import TetMesh

# Of the size of the solid: nodes that are further from those of gmsh were moved off the surface.
_SAME = 1e-9

# Boundary of each entity by its dimension and tag.
Topology = dict[tuple[int, int], tuple[int, ...]]


@dataclass(frozen=True)
class Anchors:
    """Where the nodes of a mesh lie on the solid.

    Attributes
    ----------
    dim, tag
        (n_nodes,) of the entity of lowest dimension that holds each node, by gmsh; 3 inside a volume.
    share
        (n_nodes,) for those on a curve, how far along it, 0 … 1 of its parameter.
    start
        By curve, the vertex where its parameter begins.
    topology
        Of the solid.
    """

    dim: Ints
    tag: Ints
    share: Floats
    start: dict[int, int]
    topology: Topology

    @property
    def closures(self) -> dict[int, set[tuple[int, int]]]:
        """By face: itself, its curves and their vertices, each by dimension and tag."""
        found: dict[int, set[tuple[int, int]]] = {}
        for (dim, face), curves in self.topology.items():
            if dim == 2:
                points = {(0, abs(point)) for curve in curves for point in self.topology[1, abs(curve)]}
                found[face] = {(2, face), *((1, abs(curve)) for curve in curves), *points}
        return found


def anchors(mesh: TetMesh) -> Anchors:
    """Return where the nodes of a mesh lie on the open model, from which it was made."""
    dim, tag = np.full(len(mesh.points), 3), np.zeros(len(mesh.points), dtype=np.int64)
    share, tree = np.zeros(len(mesh.points)), cKDTree(mesh.points)
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
    return Anchors(dim, tag, share, {curve: start_of(curve) for curve in curves}, topology())


def topology() -> Topology:
    """Return the boundary of each entity of the open model."""
    return {
        (dim, tag): tuple(own for _, own in gmsh.model.getBoundary([(dim, tag)], combined=False))
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
