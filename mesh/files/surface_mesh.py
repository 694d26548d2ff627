"""The boundary of a mesh as flat triangles: places, normals, and patches without sharp edges."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import Floats, Ints, Mask
from mesh.tetmesh import FACE_NODES, FACES


@dataclass(frozen=True)
class SurfaceMesh:
    """Boundary triangles, by the vertices of the facets."""

    points: Floats  # (n_nodes, 3), mm
    facets: Ints  # (n, 3) vertices, anticlockwise from outside

    @cached_property
    def corners(self) -> Floats:
        """(n, 3, 3) mm."""
        return np.asarray(self.points[self.facets])

    @cached_property
    def vectors(self) -> Floats:
        """(n, 3) outward normals as long as the areas, mm²."""
        corners = self.corners
        return np.asarray(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2)

    @cached_property
    def areas(self) -> Floats:
        """(n,) mm²."""
        return np.asarray(np.linalg.norm(self.vectors, axis=1))

    @cached_property
    def normals(self) -> Floats:
        """(n, 3) outward unit normals."""
        return np.asarray(self.vectors / np.maximum(self.areas, 1e-300)[:, None])

    @property
    def volume(self) -> float:
        """Enclosed volume, mm³, by the divergence theorem."""
        return float((self.corners.mean(axis=1) * self.vectors).sum() / 3)

    @property
    def center(self) -> Floats:
        """Centre of gravity (3,) of the enclosed volume, mm."""
        corners = self.corners
        pairs = corners + np.roll(corners, 1, axis=1)
        square = (pairs**2).sum(axis=1) / 12  # ∫x² over a triangle, per area
        return np.asarray((square * self.vectors).sum(axis=0) / (2 * self.volume))

    def patches(self, chosen: Mask, sharpest: float) -> list[Ints]:
        """Groups of the chosen facets (n,) that are joined by edges at which they turn by less, rad.

        From π on, every edge joins.
        """
        from scipy import sparse  # noqa: PLC0415 - only meshes from files need it
        from scipy.sparse.csgraph import connected_components  # noqa: PLC0415

        own = np.flatnonzero(chosen)
        edges = np.sort(self.facets[own][:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        keys = edges[:, 0] * len(self.points) + edges[:, 1]
        order = np.argsort(keys, kind="stable")
        pair = np.flatnonzero(keys[order][1:] == keys[order][:-1])
        one, other = order[pair] // 3, order[pair + 1] // 3
        least = np.cos(sharpest) if sharpest < np.pi else -np.inf
        smooth = (self.normals[own[one]] * self.normals[own[other]]).sum(axis=1) > least
        links = (np.ones(int(smooth.sum()), dtype=np.int8), (one[smooth], other[smooth]))
        _, label = connected_components(sparse.csr_array(links, shape=(len(own),) * 2), directed=False)
        by_label = np.argsort(label, kind="stable")
        starts = np.flatnonzero(np.diff(label[by_label])) + 1
        return [own[group] for group in np.split(by_label, starts)]


def face_counts(tets: Ints) -> tuple[Ints, Ints]:
    """Return a number of each face (n_elements, 4), equal for equal vertices, and how often each occurs."""
    a, b, c = np.sort(tets[:, FACES].reshape(-1, 3), axis=1).T
    n_points = int(tets.max(initial=0)) + 1
    _, edge = np.unique(a * n_points + b, return_inverse=True)
    _, which, counts = np.unique(edge * n_points + c, return_inverse=True, return_counts=True)
    return which.reshape(-1, 4), counts


def folded(tets: Ints) -> Mask:
    """Elements (n_elements,), positively oriented, that lie on the same side of a face as their neighbour."""
    which, counts = face_counts(tets)
    a, b, c = tets[:, FACES].reshape(-1, 3).T
    even = (a < b).astype(int) + (b < c) + (c < a) == 2  # as a permutation of the rising order
    evens = np.bincount(which.ravel(), even)
    return np.asarray(((counts == 2) & (evens != 1))[which].any(axis=1))


def boundary_facets(tets: Ints) -> Ints:
    """Faces (n, 3) or (n, 6) that belong to a single element, oriented outwards, in `TetMesh`'s order."""
    which, counts = face_counts(tets)
    element, face = np.nonzero(counts[which] == 1)
    return np.asarray(tets[element[:, None], FACE_NODES[tets.shape[1]][face]])
