"""The boundary of a mesh as flat triangles: places, normals, and patches without sharp edges."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import Floats, Ints, Mask, linked_groups, twins
from mesh.tetmesh import FACET_EDGES

# Angle up to which two facets lie on each other, rad.
_TWIN = 1e-6


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

    def hinges(self, facets: Ints) -> tuple[Ints, Ints, Floats]:
        """Pairs of facets (n,) with an edge in common, and the cosines of the angles by which they turn."""
        edges = np.sort(self.facets[facets][:, FACET_EDGES], axis=2).reshape(-1, 2)
        one, other = (side // 3 for side in twins(edges[:, 0] * len(self.points) + edges[:, 1]))
        return one, other, (self.normals[facets[one]] * self.normals[facets[other]]).sum(axis=1)

    def patches(self, chosen: Mask, sharpest: float) -> list[Ints]:
        """Groups of facets (n,) joined by edges at which they turn by less, rad; from π on by every edge."""
        facets = np.flatnonzero(chosen)
        one, other, cosines = self.hinges(facets)
        smooth = cosines > (np.cos(sharpest) if sharpest < np.pi else -np.inf)
        label = linked_groups(len(facets), one[smooth], other[smooth])
        by_label = np.argsort(label, kind="stable")
        starts = np.flatnonzero(np.diff(label[by_label])) + 1
        return [facets[group] for group in np.split(by_label, starts)]


def apart(surface: SurfaceMesh) -> SurfaceMesh:
    """Give bodies that have sides in common nodes of their own.

    Of the four facets at such a side, those belong together that are next to each other through material.
    """
    sides = surface.facets[:, FACET_EDGES].reshape(-1, 2)
    _, which, uses = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(which.ravel(), kind="stable")
    of_side = np.split(order // 3, np.cumsum(uses)[:-1])
    links = [rows for rows in of_side if len(rows) == 2]
    for number in np.flatnonzero(uses == 4):
        links += _through_material(surface, of_side[number], *sides[order[np.cumsum(uses)[number] - 1]])
    body = linked_groups(len(surface.facets), *np.array(links, dtype=np.int64).reshape(-1, 2).T)
    count = len(surface.points)
    keys, facets = np.unique(body[:, None] * count + surface.facets, return_inverse=True)
    return SurfaceMesh(surface.points[keys % count], facets.reshape(-1, 3))


def _through_material(surface: SurfaceMesh, rows: Ints, start: int, end: int) -> list[Ints]:
    """Pairs of facets at a side, each with the next one through the material behind it."""
    along = surface.points[end] - surface.points[start]
    along = along / np.linalg.norm(along)
    arms = surface.corners[rows].mean(axis=1) - surface.points[start]
    arms -= np.outer(arms @ along, along)
    forwards = (np.cross(along, arms) * surface.normals[rows]).sum(axis=1) > 0
    pairs = []
    for facet in np.flatnonzero(forwards):
        arm, normal = arms[facet], surface.normals[rows[facet]]
        turned = np.arctan2(-arms @ normal, arms @ arm / np.linalg.norm(arm))
        turned = np.where(forwards, np.inf, (turned - _TWIN) % (2 * np.pi))  # one that lies on it comes last
        pairs.append(rows[[facet, turned.argmin()]])
    return pairs
