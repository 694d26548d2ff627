"""Cylindrical holes on the boundary of a mesh, and which two of them are the bores of a rod."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from typing import TypeVar

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial import KDTree

from geometry.arrays import Floats, Ints, Mask
from geometry.holes import (
    CLOSED,
    NAME_BORES,
    UNKNOWN,
    Diameters,
    RoundHole,
    basis_across,
    bore_pairs,
    heavier_first,
    off_the_rod,
    pin_wall,
    place_text,
)
from geometry.segments import Circle, fitted_circle
from mesh.creases import SurfaceMesh
from mesh.tetmesh import MeshError


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
    radius[~np.isfinite(radius)] = np.nan
    return center + first, radius


@dataclass(frozen=True)
class FittedCylinders:
    """Cylinders with parallel axes."""

    direction: Floats  #: unit vector (3,)
    centers: Floats  #: (n, 3) a point on each axis, mm
    radii: Floats  #: (n,) mm
    #: Root mean square distance of the points from their cylinder, over its radius, the largest of all
    residual: float


def fitted_cylinders(clouds: list[Floats], direction: Floats) -> FittedCylinders:
    """Least-squares cylinders through clouds of points (n, 3), with a common direction near a guess (3,)."""
    across = basis_across(direction)
    middles = [cloud.mean(axis=0) for cloud in clouds]
    placed = list(zip(clouds, middles, strict=True))
    starts = [fitted_circle((cloud - middle) @ across.T) for cloud, middle in placed]
    first = [(*circle.center, circle.radius) if circle else (0.0, 0.0, 1.0) for circle in starts]
    scale = max(radius for *_, radius in first)

    def turned(tilt: Floats) -> Floats:
        vector = direction + tilt @ across
        return np.asarray(vector / np.linalg.norm(vector))

    def off(unknowns: Floats) -> Floats:
        axis, circles = turned(unknowns[:2]), scale * unknowns[2:].reshape(-1, 3)
        parts = []
        for (cloud, middle), (u, v, radius) in zip(placed, circles, strict=True):
            arm = cloud - middle - (u * across[0] + v * across[1])
            parts.append(np.linalg.norm(np.cross(arm, axis), axis=1) / radius - 1)
        return np.concatenate(parts)

    solution = least_squares(off, np.concatenate([[0, 0], np.ravel(first) / scale])).x
    axis, circles = turned(solution[:2]), scale * solution[2:].reshape(-1, 3)
    centers = np.array(middles) + circles[:, :2] @ across
    ends = np.cumsum([len(cloud) for cloud in clouds])[:-1]
    worst = max(float(np.sqrt((part**2).mean())) for part in np.split(off(solution), ends))
    return FittedCylinders(axis, centers, circles[:, 2], worst)


def straightest(normals: Floats, areas: Floats) -> Floats:
    """Direction (3,) that normals (n, 3) are most nearly across, weighted by areas (n,)."""
    _, vectors = np.linalg.eigh((normals * areas[:, None]).T @ normals)
    return np.asarray(vectors[:, 0])


def covered(angles: Floats) -> float:
    """Share of a turn that intervals (n, k) of angles, rad, cover; each spans less than half a turn."""
    if not len(angles):
        return 0.0
    start, turn = angles[:, :1], 2 * np.pi
    unrolled = start + (angles - start + np.pi) % turn - np.pi
    low = unrolled.min(axis=1) % turn
    order = np.argsort(low)
    low, high = low[order], (low + np.ptp(unrolled, axis=1))[order]
    reached = np.maximum(np.maximum.accumulate(high), high.max() - turn)
    gaps = np.maximum(np.append(low[1:], low[0] + turn) - reached, 0.0)
    return float(1 - gaps.sum() / turn)


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
    """Find concave cylindrical walls along a unit vector, the largest first, `tolerance` over the radius."""
    across = basis_across(direction)
    flat = _Plan(surface.corners @ across.T, surface.normals @ across.T, surface.areas)
    side = np.abs(surface.normals @ direction) < _LEAN
    extent = float(np.ptp(surface.corners[side].reshape(-1, 3), axis=0).max()) if side.any() else 0.0
    circles: list[Circle] = []
    for patch in surface.patches(side, _SHARPEST):
        if flat.turns(patch) >= _LEAST_TURN:
            circles += _circles(flat, patch, tolerance, extent / 2)
    walls = [(circle, flat.wall(circle, side, tolerance)) for circle in _distinct_circles(circles)]
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


def _circles(flat: _Plan, rest: Ints, tolerance: float, largest: float) -> list[Circle]:
    """Circles that take up much of a patch: one fits a whole wall, samples find those among other faces."""
    circles = []
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
    first = random.integers(len(places), size=_SAMPLES)
    near = KDTree(places).query(places[first], k=min(24, len(places)))[1]
    picks = random.integers(near.shape[1], size=(_SAMPLES, 2))
    triples = np.column_stack([first, near[np.arange(_SAMPLES)[:, None], picks]])
    centers, radii = circles_through(places[triples])
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


def _distinct_circles(circles: list[Circle]) -> list[Circle]:
    """One of each group of circles that differ by rounding, or by what patches of one wall differ."""
    kept: list[Circle] = []
    for circle in sorted(circles, key=lambda circle: -circle.radius):
        near = [one for one in kept if np.linalg.norm(circle.center - one.center) < 0.02 * one.radius]
        if not any(abs(circle.radius - one.radius) < 0.01 * one.radius for one in near):
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


ADD_CAP = (
    'Give its file as rod.cap (--cap FILE), or rod.cap = "assumed" (--cap assumed) for a ring of the section '
    "at the joint"
)
# Relative tolerance of diameters that the user gives, and of radii that count as the same.
_SAME = 5e-3
# Tolerances, over the radius, with which walls are searched: wide while the direction is a guess.
_WIDE, _CLOSE = 0.05, 0.015
# Directions of normals that are tried, and the angle (its cosine) that counts as one direction.
_DIRECTIONS, _ALIGNED, _ALIGNED_SINE = 6, math.cos(math.radians(8)), math.sin(math.radians(3))
# Sine of the angle, and distance over the radius, from which on two axes are not the same.
_ANOTHER, _APART = 0.05, 0.05
# Sums of radii within this factor are of the same holes, seen along directions a little apart.
_SAME_SIZE = 0.97
# From this share of a turn on, an open wall may be half a bore; fillets are shorter.
_HALF = 0.42

Pair = tuple[MeshHole, MeshHole]
Holes = TypeVar("Holes", bound=tuple[MeshHole, ...])


def find_bore_pair(surface: SurfaceMesh, diameters: Diameters = UNKNOWN) -> Pair:
    """Find the bores of the big and the small end: the two largest parallel through-holes.

    Raises `MeshError`: no two holes can be the bores, several pairs can, or the pair leaves out a larger hole
    or lies off the centre of gravity. The message lists the holes.
    """
    walls = _walls(surface)
    usable = map(_pin_walls, walls)
    pairs = [pair for holes in usable for pair in islice(bore_pairs(holes, diameters, _SAME), 1)]
    every = sorted((hole for holes in walls for hole in holes), key=lambda hole: -hole.radius)
    if not pairs:
        remedy = NAME_BORES if _half_open(every) is None else f"Is the cap missing? {ADD_CAP}"
        raise MeshError(f"no two parallel round bores were found on its surface. {_listed(every)}. {remedy}")
    best = _straightened(surface, _largest(pairs))
    for bore, diameter in zip(best, diameters, strict=True):
        like = [one for one in every if one.closed and one.through and one.same_radius(bore.radius, _SAME)]
        if any(all(_beside(hole, other) for other in best) for hole in like):
            known = f" of {diameter:g} mm" if diameter else ""
            raise MeshError(f"more than one hole{known} could be a bore. {_listed(every)}. {NAME_BORES}")
    if not any(diameters):
        _require_largest(best, every)
        if why := off_the_rod(best, surface.center):
            raise MeshError(
                f"the two largest through-holes cannot be the bores, because {why}. "
                f"{_listed(best)}. {NAME_BORES}"
            )
    alike = best[0].same_radius(best[1].radius, _SAME) and not any(diameters)
    return heavier_first(best, surface.center) if alike else best


def open_wall(surface: SurfaceMesh) -> MeshHole | None:
    """Find the wall of a bore that lacks its cap: the largest one, if it is half open."""
    return _half_open([hole for holes in _walls(surface) for hole in holes])


def _half_open(holes: Sequence[MeshHole]) -> MeshHole | None:
    walls = [(hole,) for hole in holes if hole.turn >= _HALF]
    (largest,) = _largest(walls) if walls else (None,)
    return None if largest is None or largest.closed else largest


def _largest(groups: Sequence[Holes]) -> Holes:
    """The largest holes; of those that directions a little apart give, the ones with most wall."""
    radii = [sum(hole.radius for hole in group) for group in groups]
    alike = (group for group, radius in zip(groups, radii, strict=True) if radius > _SAME_SIZE * max(radii))
    return max(alike, key=lambda group: sum(hole.area for hole in group))


def _straightened(surface: SurfaceMesh, pair: Pair) -> Pair:
    clouds = [surface.points[np.unique(surface.facets[bore.facets])] for bore in pair]
    holes = round_holes(surface, fitted_cylinders(clouds, pair[0].direction).direction, _CLOSE)
    big, small = (max(holes, key=lambda hole: _common(hole, bore), default=bore) for bore in pair)
    lost = big.area < pair[0].area or small.area < pair[1].area
    return pair if lost else (big, small)


def _common(hole: MeshHole, bore: MeshHole) -> int:
    return int(np.isin(hole.facets, bore.facets).sum())


def _directions(surface: SurfaceMesh) -> list[Floats]:
    normals, areas = surface.normals, surface.areas
    left = areas.copy()
    directions = []
    for _ in range(_DIRECTIONS):
        cells = np.round(normals * np.sign(normals @ [1.0, 1e-3, 1e-6])[:, None], 1)
        _, which = np.unique(cells, axis=0, return_inverse=True)
        cell = int(np.bincount(which.ravel(), left).argmax())
        near = np.abs(normals @ normals[np.flatnonzero(which.ravel() == cell)[0]]) > _ALIGNED
        if not left[near].sum() > 0:
            break
        sign = np.sign(normals[near] @ normals[near][0])
        mean = ((sign * left[near])[:, None] * normals[near]).sum(axis=0)
        directions.append(mean / np.linalg.norm(mean))
        left[near] = 0.0
    _, axes = np.linalg.eigh((normals * areas[:, None]).T @ normals)
    return _distinct([*directions, *axes.T], _ALIGNED_SINE)


def _distinct(directions: Sequence[Floats], sine: float) -> list[Floats]:
    kept: list[Floats] = []
    for direction in directions:
        if all(np.linalg.norm(np.cross(direction, other)) > sine for other in kept):
            kept.append(direction)
    return kept


def _walls(surface: SurfaceMesh) -> list[list[MeshHole]]:
    kept: list[Floats] = []
    for guess in _directions(surface):
        closed = [hole for hole in round_holes(surface, guess, _WIDE) if hole.turn >= _HALF]
        if not closed:
            continue
        wall = np.unique(np.concatenate([hole.facets for hole in closed[:2]]))
        direction = straightest(surface.normals[wall], surface.areas[wall])
        kept.append(direction * np.sign(direction[np.argmax(np.abs(direction))]))
    return [round_holes(surface, direction, _CLOSE) for direction in _distinct(kept, 1e-4)]


def _pin_walls(holes: Sequence[MeshHole]) -> list[MeshHole]:
    """The walls that pins touch, closed and through, one per axis."""
    kept = []
    for hole in holes:
        group = [other for other in holes if hole.apart(other) < 0.02 * hole.radius and other.closed]
        if hole.closed and hole.through and hole is pin_wall(group):
            kept.append(hole)
    return kept


def _beside(hole: MeshHole, bore: MeshHole) -> bool:
    if _common(hole, bore):
        return False
    turned = float(np.linalg.norm(np.cross(hole.direction, bore.direction)))
    return turned > _ANOTHER or bore.apart(hole) > _APART * bore.radius


def _require_largest(pair: Pair, holes: Sequence[MeshHole]) -> None:
    """Refuse bores that leave out a larger hole, such as half a big end without its cap."""
    small = min(bore.radius for bore in pair)
    for hole in holes:
        unused = all(_beside(hole, bore) for bore in pair)
        rounded_pocket = not hole.closed and not hole.through
        if unused and hole.turn >= _HALF and hole.radius > 1.005 * small and not rounded_pocket:
            missing = "" if hole.closed else f": is the cap missing? {ADD_CAP}"
            raise MeshError(
                f"the two largest through-holes cannot be the bores, because there is a larger one that is "
                f"{'blind' if hole.closed else 'half open'}{missing}. {_listed(holes)}. {NAME_BORES}"
            )


def _listed(holes: Sequence[MeshHole]) -> str:
    texts = [hole.text() for hole in holes if hole.turn >= _HALF][:8]
    return f"Round holes: {'; '.join(texts)}" if texts else "There are no round holes"
