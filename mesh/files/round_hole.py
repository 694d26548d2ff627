"""Cylindrical holes on the boundary of a mesh, found by the shape of its facets."""

import math
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats, Ints, Mask
from geometry.holes import CLOSED, RoundHole, basis_across, place_text
from geometry.segments import Circle, fitted_circle
from mesh.surface_mesh import SurfaceMesh


def circles_through(triples: Floats) -> tuple[Floats, Floats]:
    """Centres (n, 2) and radii (n,) of the circles through three places each (n, 3, 2); NaN for lines."""
    first = triples[:, 0]
    spans = triples[:, 1:] - first[:, None]
    cross = 2 * (spans[:, 0, 0] * spans[:, 1, 1] - spans[:, 0, 1] * spans[:, 1, 0])
    squares = (spans**2).sum(axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        x = (spans[:, 1, 1] * squares[:, 0] - spans[:, 0, 1] * squares[:, 1]) / cross
        y = (spans[:, 0, 0] * squares[:, 1] - spans[:, 1, 0] * squares[:, 0]) / cross
    center = np.column_stack([x, y])
    radius = np.linalg.norm(center, axis=1)
    wrong = ~np.isfinite(radius)
    radius[wrong] = np.nan
    return center + first, radius


@dataclass(frozen=True)
class Axes:
    """Cylinders with parallel axes."""

    direction: Floats  #: unit vector (3,)
    centers: Floats  #: (n, 3) a point on each axis, mm
    radii: Floats  #: (n,) mm
    #: Root mean square distance of the points from their cylinder, over its radius, the largest of all
    residual: float


def fitted_axes(clouds: list[Floats], direction: Floats) -> Axes:
    """Least-squares cylinders through clouds of points (n, 3), with a common direction near a guess (3,)."""
    from scipy.optimize import least_squares  # noqa: PLC0415 - only meshes from files need it

    across = basis_across(direction)
    middles = [cloud.mean(axis=0) for cloud in clouds]
    starts = [
        fitted_circle((cloud - middle) @ across.T) for cloud, middle in zip(clouds, middles, strict=True)
    ]
    first = [(*circle.center, circle.radius) if circle else (0.0, 0.0, 1.0) for circle in starts]
    scale = max(radius for *_, radius in first)

    def turned(tilt: Floats) -> Floats:
        vector = direction + tilt @ across
        return np.asarray(vector / np.linalg.norm(vector))

    def off(unknowns: Floats) -> Floats:
        axis = turned(unknowns[:2])
        parts = []
        for cloud, middle, (u, v, radius) in zip(
            clouds, middles, scale * unknowns[2:].reshape(-1, 3), strict=True
        ):
            arm = cloud - middle - (u * across[0] + v * across[1])
            parts.append(np.linalg.norm(np.cross(arm, axis), axis=1) / radius - 1)
        return np.concatenate(parts)

    solution = least_squares(off, np.concatenate([[0, 0], np.ravel(first) / scale])).x
    axis, circles = turned(solution[:2]), scale * solution[2:].reshape(-1, 3)
    centers = np.array(
        [m + u * across[0] + v * across[1] for m, (u, v, _) in zip(middles, circles, strict=True)]
    )
    ends = np.cumsum([len(cloud) for cloud in clouds])[:-1]
    worst = max(float(np.sqrt((part**2).mean())) for part in np.split(off(solution), ends))
    return Axes(axis, centers, circles[:, 2], worst)


def straightest(normals: Floats, areas: Floats) -> Floats:
    """Direction (3,) that normals (n, 3) are most nearly across, weighted by areas (n,)."""
    _, vectors = np.linalg.eigh((normals * areas[:, None]).T @ normals)
    return np.asarray(vectors[:, 0])


def covered(angles: Floats, bins: int = 360) -> float:
    """Share of a turn that intervals (n, k) of angles, rad, cover; each spans less than half a turn."""
    if not len(angles):
        return 0.0
    start = angles[:, :1]
    off = start + (angles - start + np.pi) % (2 * np.pi) - np.pi
    low = np.floor(off.min(axis=1) / (2 * np.pi) * bins).astype(int)
    high = np.ceil(off.max(axis=1) / (2 * np.pi) * bins).astype(int)
    marks = np.zeros(3 * bins + 2)
    np.add.at(marks, low + bins, 1)
    np.add.at(marks, np.maximum(high, low + 1) + bins, -1)
    open_bins = np.cumsum(marks)[: 3 * bins].reshape(3, bins).sum(axis=0) <= 0
    return float(1 - open_bins.mean())


# Normals of a wall's facets lean out of the plane across the axis by the sine of this angle at most: on a
# coarse mesh triangles span several angles. The bevels of a bore lean by 45°.
_LEAN = 0.3
# Neighbours on a wall turn by less: eight facets around a bore turn by 45°.
_SHARPEST = math.radians(55)
_LEAST_FACETS, _LEAST_TURN = 4, 1 / 15
# A circle that takes up less of what is left of a patch is chance.
_LEAST_SHARE = 0.03
_SAMPLES, _MOST_PLACES, _FINALISTS = 200, 1000, 8
_ROUNDS = 6


@dataclass(frozen=True, eq=False, kw_only=True)
class MeshHole(RoundHole):
    """The wall of a cylindrical hole of a surface mesh."""

    through: bool  #: whether nothing crosses the axis
    facets: Ints  #: numbers of the wall's facets

    @property
    def closed(self) -> bool:
        """Whether the wall goes all the way round."""
        return self.turn >= CLOSED

    def text(self) -> str:
        """Say how large it is, where, and what it lacks."""
        place = place_text(self.center)
        lacks = "" if self.closed else f", open: only {360 * self.turn:.0f}° of it exist"
        blind = "" if self.through or not self.closed else ", blind"
        return f"diameter {2 * self.radius:.4g} mm at {place}{lacks}{blind}"


def round_holes(surface: SurfaceMesh, direction: Floats, tolerance: float) -> list[MeshHole]:
    """Find the concave cylindrical walls along a unit vector, the largest radius first.

    Their vertices are off the cylinder by at most `tolerance`, over its radius.
    """
    across = basis_across(direction)
    flat = _Plan(surface.corners @ across.T, surface.normals @ across.T, surface.areas)
    side = np.abs(surface.normals @ direction) < _LEAN
    extent = float(np.ptp(surface.corners[side].reshape(-1, 3), axis=0).max()) if side.any() else 0.0
    circles: list[Circle] = []
    for patch in surface.patches(side, _SHARPEST):
        if flat.turns(patch) >= _LEAST_TURN:
            circles += _circles(flat, patch, tolerance, extent / 2)
    walls = [(circle, flat.wall(circle, side, tolerance)) for circle in _distinct(circles)]
    holes = [_hole(surface, flat, circle, wall, direction) for circle, wall in walls if len(wall)]
    return sorted(holes, key=lambda hole: -hole.radius)


@dataclass(frozen=True)
class _Plan:
    """Facets seen along the axis: corners (n, 3, 2), normals (n, 2), areas (n,)."""

    corners: Floats
    normals: Floats
    areas: Floats

    def turns(self, patch: Ints) -> float:
        """Share of a turn that the normals of a patch take up, in steps of a sixtieth."""
        angles = np.arctan2(self.normals[patch, 1], self.normals[patch, 0])
        return len(np.unique(np.floor(angles * (60 / (2 * np.pi))))) / 60

    def wall(self, circle: Circle, among: Mask | Ints, tolerance: float) -> Ints:
        """Facets among others that lie on a circle, with the material outside of it."""
        facets = np.flatnonzero(among) if among.dtype == bool else among
        corners = self.corners[facets]
        near = (circle.distance(corners) < tolerance * circle.radius).all(axis=1)
        inwards = circle.center - corners.mean(axis=1)
        return np.asarray(facets[near & ((self.normals[facets] * inwards).sum(axis=1) > 0.8 * circle.radius)])


def _circles(flat: _Plan, patch: Ints, tolerance: float, largest: float) -> list[Circle]:
    """Circles that take up much of a patch: one fits a whole wall, samples find those among other faces."""
    circles = []
    rest = patch
    for _ in range(_ROUNDS):
        if len(rest) < _LEAST_FACETS:
            break
        circle = fitted_circle(flat.corners[rest].reshape(-1, 2))
        if circle is None or len(flat.wall(circle, rest, tolerance)) < len(rest):
            circle = _of_samples(flat, rest, tolerance, largest)
        if circle is None:
            break
        wall = flat.wall(circle, rest, tolerance)
        if flat.areas[wall].sum() < _LEAST_SHARE * flat.areas[rest].sum():
            break
        better = fitted_circle(flat.corners[wall].reshape(-1, 2))
        if better is not None and better.radius < largest:
            circles.append(better)
        rest = np.setdiff1d(rest, wall)
    return circles


def _of_samples(flat: _Plan, patch: Ints, tolerance: float, largest: float) -> Circle | None:
    """Circle of most area among those through three corners of the patch (RANSAC, Fischler & Bolles 1981)."""
    places = np.unique(np.round(flat.corners[patch].reshape(-1, 2), 9), axis=0)
    if len(places) < 3:
        return None
    random = np.random.default_rng(0)
    from scipy.spatial import KDTree  # noqa: PLC0415 - only meshes from files need it

    first = random.integers(len(places), size=_SAMPLES)
    near = KDTree(places).query(places[first], k=min(24, len(places)))[1]
    picks = random.integers(near.shape[1], size=(_SAMPLES, 2))
    centers, radii = circles_through(
        places[np.column_stack([first, near[np.arange(_SAMPLES)[:, None], picks]])]
    )
    usable = radii < largest
    centers, radii = centers[usable], radii[usable]
    few = places[random.permutation(len(places))[:_MOST_PLACES]]
    off = np.abs(np.linalg.norm(few - centers[:, None], axis=2) - radii[:, None])
    votes = (off < tolerance * radii[:, None]).sum(axis=1)
    best, most = None, 0.0
    for number in np.argsort(-votes, kind="stable")[:_FINALISTS]:
        circle = Circle(centers[number], float(radii[number]))
        wall = flat.wall(circle, patch, tolerance)
        area = float(flat.areas[wall].sum())
        if len(wall) >= _LEAST_FACETS and area > most:
            best, most = circle, area
    return best


def _distinct(circles: list[Circle]) -> list[Circle]:
    """One of each group of circles that differ by rounding, or by what patches of one wall differ."""
    kept: list[Circle] = []
    for circle in sorted(circles, key=lambda circle: -circle.radius):
        same = (
            np.linalg.norm(circle.center - other.center) < 0.02 * other.radius
            and abs(circle.radius - other.radius) < 0.01 * other.radius
            for other in kept
        )
        if not any(same):
            kept.append(circle)
    return kept


def _hole(surface: SurfaceMesh, flat: _Plan, circle: Circle, wall: Ints, direction: Floats) -> MeshHole:
    across = basis_across(direction)
    circle = fitted_circle(flat.corners[wall].reshape(-1, 2)) or circle
    heights = surface.corners[wall] @ direction
    arms = flat.corners[wall] - circle.center
    middle = (heights.min() + heights.max()) / 2
    around = flat.corners - circle.center
    after = np.roll(around, -1, axis=1)
    turns = around[..., 0] * after[..., 1] - around[..., 1] * after[..., 0]
    crosses = ((turns > 0).all(axis=1) | (turns < 0).all(axis=1)).any()
    return MeshHole(
        center=circle.center @ across + middle * direction,
        direction=direction,
        radius=circle.radius,
        width=float(np.ptp(heights)),
        area=float(surface.areas[wall].sum()),
        turn=covered(np.arctan2(arms[..., 1], arms[..., 0])),
        through=not crosses,
        facets=wall,
    )
