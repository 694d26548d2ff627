"""The boundary as facets, continued across mirror planes, and the angles at which the facets meet."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fea.solid.assembly import jacobians, shape_functions
from fea.solid.parity import Parity
from geometry.arrays import Floats, Ints, Mask, linked_groups, twins
from geometry.surfaces import PLANE_AXIS, Surface
from mesh.tetmesh import FACET_EDGES, FACET_TURN, TetMesh

# Facets meet smoothly below this angle; curved ones of 60° that meet tangentially differ by 4°.
SMOOTH_DEGREES = 20.0
# Places of a facet's nodes in the reference triangle, and the vertices of its edges.
_FACET_NODES = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]])


@dataclass(frozen=True)
class BoundarySurface:
    """The boundary facets, with the images of those that touch a mirror plane."""

    points: Floats  #: (n, 3) the nodes of the mesh, then their images
    facets: Ints  #: (n_facets, 3) or (n_facets, 6), outward
    label: Ints  #: (n_facets,) index of the surface each belongs to
    source: Ints  #: (n,) the node of the mesh that each node is or is an image of
    sign: Floats  #: (n, 3) of the displacement components of a symmetric solution

    @classmethod
    def of(
        cls, mesh: TetMesh, surfaces: Sequence[Surface], planes: tuple[Surface, ...] = ()
    ) -> "BoundarySurface":
        """Gather the facets of `surfaces` and reflect those that touch one of `planes`."""
        boundary = cls(
            mesh.points,
            np.concatenate([mesh.facets[surface] for surface in surfaces]),
            np.repeat(np.arange(len(surfaces)), [len(mesh.facets[surface]) for surface in surfaces]),
            np.arange(len(mesh.points)),
            np.ones_like(mesh.points),
        )
        for plane in planes:
            boundary = boundary._reflected(mesh, plane)
        return boundary

    def _reflected(self, mesh: TetMesh, plane: Surface) -> "BoundarySurface":
        on = np.isin(self.source, mesh.facets[plane])
        touching = on[self.facets].any(axis=1)
        beyond = np.setdiff1d(self.facets[touching], np.flatnonzero(on))
        image = np.arange(len(self.points))
        image[beyond] = len(self.points) + np.arange(beyond.size)
        turn = np.ones(3)
        turn[PLANE_AXIS[plane]] = -1
        around = FACET_TURN[self.facets.shape[1]]
        return BoundarySurface(
            np.concatenate([self.points, self.points[beyond] * turn]),
            np.concatenate([self.facets, image[self.facets[touching]][:, around]]),
            np.concatenate([self.label, self.label[touching]]),
            np.concatenate([self.source, self.source[beyond]]),
            np.concatenate([self.sign, self.sign[beyond] * turn]),
        )

    def displacement(self, displacement: Floats, parity: Parity) -> Floats:
        """Continue a displacement (n_points, 3, n_cases) to the images."""
        beyond = self.sign[:, 1:2] < 0  # y = 0
        sign = self.sign * np.where(beyond, int(parity), 1)
        return np.asarray(displacement[self.source] * sign[:, :, None])

    @cached_property
    def normals(self) -> Floats:
        """Unit outward normals (n_facets, n_nodes, 3) of each facet at its own nodes."""
        return facet_normals(self.points, self.facets)

    @cached_property
    def edges(self) -> "Edges":
        """Pairs of facets that meet at an edge."""
        facets, points, normals = self.facets, self.points, self.normals
        ends = np.sort(facets[:, FACET_EDGES], axis=2)
        key = (ends[..., 0] * len(points) + ends[..., 1]).ravel()
        facet, place = np.divmod(np.stack(twins(key), axis=1), 3)
        # Second-order facets have a separate normal at the middle of the edge.
        at = place + 3 if facets.shape[1] == 6 else place
        first, second = normals[facet[:, 0], at[:, 0]], normals[facet[:, 1], at[:, 1]]
        cosine = np.asarray((first * second).sum(axis=1))
        flat = cosine > np.cos(np.radians(SMOOTH_DEGREES))
        smooth = flat & (self.label[facet[:, 0]] == self.label[facet[:, 1]])
        apex = points[facets[facet[:, 1], (place[:, 1] + 2) % 3]]
        on_edge = points[facets[facet[:, 0], place[:, 0]]]
        convex = flat | (((apex - on_edge) * first).sum(axis=1) < 0)
        return Edges(facet, place, cosine, smooth, convex)

    @cached_property
    def fans(self) -> Ints:
        """Number of the fan (n_facets, 3) each corner is in: the facets around a vertex up to sharp edges."""
        n_facets, smooth = len(self.facets), self.edges.smooth
        facet, place = self.edges.facet[smooth], self.edges.place[smooth]
        start = FACET_EDGES[place]  # (n, 2 facets, 2 ends), in each facet's own direction
        corner = facet[:, :, None] * 3 + start
        # The two facets run along the edge in opposite directions.
        a, b = corner[:, 0].ravel(), corner[:, 1, ::-1].ravel()
        return linked_groups(3 * n_facets, a, b).reshape(n_facets, 3)


def facet_normals(points: Floats, facets: Ints) -> Floats:
    """Unit outward normals (n_facets, n_nodes, 3) of each facet at its own nodes."""
    n_nodes = facets.shape[1]
    _, slopes = shape_functions(n_nodes, _FACET_NODES[:n_nodes].T)
    tangents = jacobians(points[facets], slopes)
    normal = np.cross(tangents[..., 0], tangents[..., 1])
    return np.asarray(normal / np.linalg.norm(normal, axis=-1, keepdims=True))


@dataclass(frozen=True)
class Edges:
    """Edges shared by two facets of the boundary."""

    #: facet, place: (n_edges, 2) the two facets, and which of its edges this is in each
    facet: Ints
    place: Ints
    cosine: Floats  #: (n_edges,) of the angle between the outward normals of the facets, amid the edge
    #: smooth, convex: (n_edges,) whether facets join smoothly; whether smoothly or at an outer edge
    smooth: Mask
    convex: Mask
