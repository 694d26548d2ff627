"""The outer surface of a mesh, divided finely enough that curved facets look curved, and its motion."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from fea.output.pictures.scale import exaggeration
from geometry.arrays import Floats, Mask
from mesh.tetmesh import boundary_facets

Ints = npt.NDArray[Any]

SIDES = np.array([[0, 1, 3], [1, 2, 4], [2, 0, 5]])  # of a face: two vertices and the node between
SMOOTH = np.cos(np.radians(25.0))  # facets that meet at a smaller angle belong to one smooth surface
PIECES = 4
TRIANGLES = 40_000  # of a surface that fills a picture; more would be smaller than the picture can show


@dataclass(frozen=True)
class DrawnSurface:
    """The boundary facets, which belong to one element only."""

    points: Floats  #: (n_nodes, 3) coordinates of all nodes, mm
    #: (n_facets, 3) or (n_facets, 6) node numbers: vertices, mid-edge nodes; outward orientation
    facets: Ints
    pieces: int = PIECES  #: number of straight pieces in which a side of a facet is drawn

    @classmethod
    def of(cls, points: Floats, tets: Ints) -> "DrawnSurface":
        """Return the skin of tetrahedra (n_elements, 4 or 10) in VTK's node order."""
        return cls._divided(points, boundary_facets(tets))

    def part(self, chosen: Mask) -> "DrawnSurface":
        """Return the skin of some of the facets (n_facets,)."""
        return self._divided(self.points, self.facets[chosen])

    @classmethod
    def _divided(cls, points: Floats, facets: Ints) -> "DrawnSurface":
        return cls(points, facets, int(np.clip(round((TRIANGLES / len(facets)) ** 0.5), 2, PIECES)))

    @cached_property
    def normals(self) -> Floats:
        """(n_facets, 3 or 6, 3) outward unit normals at the facets' nodes, continuous across smooth edges."""
        corners = self.points[self.facets]
        along = np.einsum("nkj,fkx->fnjx", _slopes(self.facets.shape[1]), corners, optimize=True)
        own = _unit(np.cross(along[:, :, 0], along[:, :, 1]))
        mean = np.zeros_like(self.points)
        np.add.at(mean, self.facets, own)
        shared = _unit(mean)[self.facets]
        alike = np.sum(own * shared, axis=-1, keepdims=True) > SMOOTH
        return np.where(alike, shared, own)

    @cached_property
    def sides(self) -> tuple[Ints, Mask]:
        """Node numbers (n_edges, 2 or 3) of the elements' edges, and which of them are sharp edges."""
        width = 2 if self.facets.shape[1] == 3 else 3
        sides = self.facets[:, SIDES[:, :width]].reshape(-1, width)
        ends = np.sort(sides[:, :2].astype(np.int64), axis=1)
        keys = ends[:, 0] * len(self.points) + ends[:, 1]
        flat = self.normals[:, SIDES[:, :2]].sum(axis=2).reshape(-1, 3)
        order = np.argsort(keys, kind="stable")
        _, start, count = np.unique(keys[order], return_index=True, return_counts=True)
        one, other = order[start], order[start + count - 1]
        sharp = np.sum(_unit(flat[one]) * _unit(flat[other]), axis=1) < SMOOTH
        return sides[one], sharp

    def hides(self, place: Floats, towards: Floats) -> bool:
        """Return whether any facet, taken as flat, hides a place (3,) from an eye in a direction (3,)."""
        a, b, c = np.moveaxis(self.points[self.facets[:, :3]], 1, 0)
        # place + t·towards = a + ξ(b − a) + η(c − a), by Cramer's rule
        side, other, gap = b - a, c - a, place - a
        area = np.cross(side, other)
        with np.errstate(divide="ignore", invalid="ignore"):  # facets seen edge-on
            xi = np.cross(gap, other) @ towards / (area @ towards)
            eta = np.cross(side, gap) @ towards / (area @ towards)
            ahead = -np.einsum("ij,ij->i", area, gap) / (area @ towards)
        return bool(np.any((xi >= 0) & (eta >= 0) & (xi + eta <= 1) & (ahead > 0)))

    @cached_property
    def triangles(self) -> Ints:
        """The small triangles (n, 3), as numbers of the rows that `refined` returns."""
        number = {place: k for k, place in enumerate(_places(self.pieces))}
        upward = [((i, j), (i + 1, j), (i, j + 1)) for i, j in number if i + j < self.pieces]
        downward = [((i + 1, j), (i + 1, j + 1), (i, j + 1)) for i, j in number if i + j < self.pieces - 1]
        once = np.array([[number[place] for place in triangle] for triangle in upward + downward])
        return (once + len(number) * np.arange(len(self.facets))[:, None, None]).reshape(-1, 3)

    def refined(self, values: Floats) -> Floats:
        """Return nodal values (n_nodes,) or (n_nodes, k) at the corners of the small triangles."""
        return self._refined(values[self.facets])

    @cached_property
    def refined_normals(self) -> Floats:
        """Outward unit normals (n, 3) at the corners of the small triangles."""
        return _unit(self._refined(self.normals))

    def _refined(self, at_nodes: Floats) -> Floats:
        xi, eta = np.array(_places(self.pieces)).T / self.pieces
        shapes = _shapes(np.stack([1 - xi - eta, xi, eta], axis=1), self.facets.shape[1])
        fine: Floats = np.einsum("pn,fn...->fp...", shapes, at_nodes, optimize=True)
        flat: Floats = fine.reshape(-1, *at_nodes.shape[2:])
        return flat


def refined_line(points: Floats, sides: Ints) -> Floats:
    """Return (n_edges, `PIECES` + 1, 3) places along edges (n_edges, 2 or 3) with their curvature."""
    t = np.linspace(0, 1, PIECES + 1)
    if sides.shape[1] == 2:
        shapes = np.stack([1 - t, t], axis=1)
    else:
        shapes = np.stack([(1 - t) * (1 - 2 * t), t * (2 * t - 1), 4 * t * (1 - t)], axis=1)
    places: Floats = np.einsum("tn,snx->stx", shapes, points[sides], optimize=True)
    return places


def _places(pieces: int) -> list[tuple[int, int]]:
    return [(i, j) for i in range(pieces + 1) for j in range(pieces + 1 - i)]


def _shapes(bary: Floats, nodes: int) -> Floats:
    """Return the shape functions (n, nodes) of a facet at barycentric coordinates (n, 3)."""
    if nodes == 3:
        return bary
    between = [4 * bary[:, i] * bary[:, j] for i, j, _ in SIDES]
    return np.hstack([bary * (2 * bary - 1), np.stack(between, axis=1)])


def _slopes(nodes: int) -> Floats:
    """Return the derivatives (at node, of node, by ξ and η) of a facet's shape functions at its nodes.

    By central differences, which are exact for polynomials of second order.
    """
    corners = np.eye(3)
    at = np.vstack([corners, (corners + np.roll(corners, -1, axis=0)) / 2])[:nodes]
    steps = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
    return np.stack([(_shapes(at + step, nodes) - _shapes(at - step, nodes)) / 2 for step in steps], axis=-1)


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1.0)


Singles = npt.NDArray[np.float32]


@dataclass(frozen=True)
class CycleAnimation:
    """A rod at instants of the cycle, and how it is drawn there."""

    skin: DrawnSurface  #: its outer surface without load, rod frame, mm
    displacement: Singles  #: (n_frames, n_nodes, 3) of the skin's nodes, rod frame, mm
    von_mises: Singles  #: (n_frames, n_nodes), in the unit that is shown
    crank_angle: Floats  #: (n_frames,), rad
    #: crank_radius, rod_length, pin_offset: of the engine, mm
    crank_radius: float
    rod_length: float
    pin_offset: float
    title: tuple[str, ...]  #: lines of the title: study and speed
    unit: str = "MPa"  #: of the stress

    @cached_property
    def exaggeration(self) -> float:
        """Magnification of the displacements in the drawing."""
        largest = float(np.linalg.norm(self.displacement, axis=2).max())
        return exaggeration(float(np.ptp(self.skin.points, axis=0).max()), largest)

    def deformed(self, k: int) -> Floats:
        """(n_nodes, 3) drawn positions of the nodes in the rod's frame."""
        return np.asarray(self.skin.points + self.exaggeration * self.displacement[k])

    def placement(self, k: int) -> Floats:
        """(4, 4) transformation from the rod's frame to the engine's.

        The crank pin is on its circle; the rod is rotated so that its small end, at the magnified length, is
        on the cylinder axis.
        """
        theta, r = self.crank_angle[k], self.crank_radius
        near = np.abs(self.skin.points[:, 0] - self.rod_length) < 0.05 * self.rod_length
        stretched = self.rod_length + self.exaggeration * float(self.displacement[k, near, 0].mean())
        sin = (r * np.sin(theta) - self.pin_offset) / stretched
        cos = np.sqrt(1 - sin**2)
        placed = np.eye(4)
        placed[:2] = [[cos, sin, 0, r * np.cos(theta)], [-sin, cos, 0, r * np.sin(theta)]]
        return placed
