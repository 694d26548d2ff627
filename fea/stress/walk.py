"""Walks over the surface of a mesh: places at given distances from a start, each with its interpolation."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fea.solid.element import shape_functions
from geometry.arrays import Floats, Ints, Mask

if TYPE_CHECKING:
    from scipy.spatial import KDTree

# Facets whose centres are nearest to a place: the one that holds it is among them.
_CANDIDATES = 24
# A step has left the facets it may walk on if it ends off them by more than this share of its length.
_OFF = 0.4


@dataclass(frozen=True)
class Walks:
    """Places (n, n_steps) on a surface, on n ways.

    Attributes
    ----------
    nodes, weights
        (n, n_steps, n_nodes_of_a_facet): a nodal field there is the weighted sum of its values.
    ahead
        (n, n_steps, 3) unit direction of the way.
    reached
        (n,) how many steps stay on the facets.
    """

    nodes: Ints
    weights: Floats
    ahead: Floats
    reached: Ints

    def of(self, field: Floats) -> Floats:
        """Values (n, n_steps, …) of a field (n_points, …)."""
        extra = (1,) * (field.ndim - 1)
        return np.asarray((self.weights.reshape(*self.weights.shape, *extra) * field[self.nodes]).sum(axis=2))


@dataclass(frozen=True)
class Ground:
    """Facets to walk on.

    Attributes
    ----------
    points
        (n_points, 3).
    facets
        (n_facets, 3) or (n_facets, 6), outward.
    patch
        (n_facets,) number of the face each belongs to: a way stays on one.
    """

    points: Floats
    facets: Ints
    patch: Ints

    def walk(self, start: Floats, ahead: Floats, facet: Ints, step: Floats, count: int) -> Walks:
        """Walk straight ahead over the facets.

        Parameters
        ----------
        start, ahead
            (n, 3) where to begin, and the unit tangent to follow.
        facet
            (n,) where each way begins.
        step, count
            (n,) length of a step, mm, and how many.
        """
        here, patch = start, self.patch[facet]
        on = np.ones(len(start), dtype=bool)
        nodes, weights, directions, reached = [], [], [], np.zeros(len(start), dtype=np.int64)
        for _ in range(count):
            aim = here + step[:, None] * ahead
            found, share, place = self._nearest(aim, patch)
            on = on & (np.linalg.norm(place - aim, axis=1) < _OFF * step)
            normal = self._normals[found]
            turned = ahead - (ahead * normal).sum(axis=1, keepdims=True) * normal
            ahead = turned / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-12)
            here = place
            reached += on
            nodes.append(self.facets[found])
            weights.append(shape_functions(self.facets.shape[1], share.T)[0])
            directions.append(ahead)
        return Walks(np.stack(nodes, 1), np.stack(weights, 1), np.stack(directions, 1), reached)

    def depth(self, start: Floats, ahead: Floats) -> Floats:
        """Distance (n,) from places (n, 3) in the solid to the surface in a direction (n, 3) each, mm."""
        return np.array([self._first_hit(a, b) for a, b in zip(start, ahead, strict=True)])

    @cached_property
    def _corners(self) -> Floats:
        return np.asarray(self.points[self.facets[:, :3]])

    @cached_property
    def _centers(self) -> Floats:
        return np.asarray(self._corners.mean(axis=1))

    @cached_property
    def _radii(self) -> Floats:
        return np.asarray(np.linalg.norm(self._corners - self._centers[:, None], axis=2).max(axis=1))

    @cached_property
    def _normals(self) -> Floats:
        one, other = self._corners[:, 1] - self._corners[:, 0], self._corners[:, 2] - self._corners[:, 0]
        normal = np.cross(one, other)
        return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))

    @cached_property
    def _tree(self) -> "KDTree":
        from scipy.spatial import KDTree  # noqa: PLC0415 - only a body with sharp edges needs it

        return KDTree(self._centers)

    def _nearest(self, places: Floats, patch: Ints) -> tuple[Ints, Floats, Floats]:
        """Facet (n,) of its patch nearest to each place, where in it (n, 2), and that point (n, 3)."""
        _, found = self._tree.query(places, k=min(_CANDIDATES, len(self.facets)))
        share, inside = _barycentric(self._corners[found], places[:, None])
        corners = self._corners[found]
        at = corners[..., 0, :] + np.einsum(
            "...k,...kx->...x", share, corners[..., 1:, :] - corners[..., :1, :]
        )
        apart = np.linalg.norm(at - places[:, None], axis=2)
        apart = np.where(self.patch[found] == patch[:, None], apart, np.inf)
        best = (apart - 1e-9 * inside).argmin(axis=1)
        rows = np.arange(len(places))
        return found[rows, best], share[rows, best], at[rows, best]

    def _first_hit(self, start: Floats, ahead: Floats) -> float:
        """Distance to the first facet that a ray leaves the solid through; infinite where there is none."""
        beside = np.cross(self._centers - start, ahead)
        near = ((beside**2).sum(axis=1) <= (1.01 * self._radii) ** 2) & (self._normals @ ahead > 1e-6)
        normal, corners = self._normals[near], self._corners[near]
        distance = ((corners[:, 0] - start) * normal).sum(axis=1) / (normal @ ahead)
        hit = start + distance[:, None] * ahead
        _, inside = _barycentric(corners, hit)
        distance = distance[inside & (distance > 0)]
        return float(distance.min(initial=np.inf))


def _barycentric(corners: Floats, places: Floats) -> tuple[Floats, Mask]:
    """Coordinates (…, 2) in triangles (…, 3, 3) of the points nearest to places (…, 3).

    Returns
    -------
    share, inside
        Clipped to the triangle, and whether that was needed for none (with a little slack).
    """
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
