"""The boundary of a mesh as flat triangles: places, normals, and patches without sharp edges."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import Floats, Ints, Mask, linked_groups
from mesh.tetmesh import FACET_EDGES


@dataclass(frozen=True)
class SurfaceMesh:
    """Boundary triangles, by the vertices of the facets."""

    points: Floats  #: (n_nodes, 3), mm
    facets: Ints  #: (n, 3) vertices, anticlockwise from outside

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
        facets = np.flatnonzero(chosen)
        edges = np.sort(self.facets[facets][:, FACET_EDGES], axis=2).reshape(-1, 2)
        keys = edges[:, 0] * len(self.points) + edges[:, 1]
        order = np.argsort(keys, kind="stable")
        pair = np.flatnonzero(keys[order][1:] == keys[order][:-1])
        one, other = order[pair] // 3, order[pair + 1] // 3
        least = np.cos(sharpest) if sharpest < np.pi else -np.inf
        smooth = (self.normals[facets[one]] * self.normals[facets[other]]).sum(axis=1) > least
        label = linked_groups(len(facets), one[smooth], other[smooth])
        by_label = np.argsort(label, kind="stable")
        starts = np.flatnonzero(np.diff(label[by_label])) + 1
        return [facets[group] for group in np.split(by_label, starts)]
