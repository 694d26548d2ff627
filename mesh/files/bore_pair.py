"""Which two holes of a meshed rod are its bores."""

import math
from collections.abc import Sequence
from itertools import islice

import numpy as np

from geometry.arrays import Floats
from geometry.holes import (
    NAME_BORES,
    UNKNOWN,
    Balance,
    Diameters,
    bore_pairs,
    heavier_first,
    pin_wall,
)
from mesh.files.round_hole import MeshHole, fitted_axes, round_holes, straightest
from mesh.surface_mesh import SurfaceMesh
from mesh.tetmesh import MeshError

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
        twins = [
            hole
            for hole in every
            if hole.closed
            and hole.through
            and hole.same_radius(bore.radius, _SAME)
            and all(_beside(hole, other) for other in best)
        ]
        if twins:
            known = f" of {diameter:g} mm" if diameter else ""
            raise MeshError(f"more than one hole{known} could be a bore. {_listed(every)}. {NAME_BORES}")
    if not any(diameters):
        _require_largest(best, every)
        balance = Balance.of(best, surface.center)
        if not balance.is_that_of_a_rod:
            raise MeshError(
                f"the two largest through-holes cannot be the bores, because {balance.text()}. "
                f"{_listed(best)}. {NAME_BORES}"
            )
    alike = best[0].same_radius(best[1].radius, _SAME) and not any(diameters)
    return heavier_first(best, surface.center) if alike else best


def open_wall(surface: SurfaceMesh) -> MeshHole | None:
    """Find the wall of a bore that lacks its cap: the largest one, if it is half open."""
    return _half_open([hole for holes in _walls(surface) for hole in holes])


def _half_open(holes: Sequence[MeshHole]) -> MeshHole | None:
    walls = (hole for hole in holes if hole.turn >= _HALF)
    largest = max(walls, key=lambda hole: (round(hole.radius, 6), hole.area), default=None)
    return None if largest is None or largest.closed else largest


def _largest(pairs: Sequence[Pair]) -> Pair:
    """The pair of the largest holes; of those that directions a little apart give, the one with most wall."""
    radius = max(one.radius + other.radius for one, other in pairs)
    alike = [pair for pair in pairs if pair[0].radius + pair[1].radius > _SAME_SIZE * radius]
    return max(alike, key=lambda pair: pair[0].area + pair[1].area)


def _straightened(surface: SurfaceMesh, pair: Pair) -> Pair:
    """The same holes along the axis that fits their walls, with all facets that lie on them then."""
    clouds = [surface.points[np.unique(surface.facets[bore.facets])] for bore in pair]
    holes = round_holes(surface, fitted_axes(clouds, pair[0].direction).direction, _CLOSE)
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
    """Cylindrical walls of the surface, by their directions."""
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
    """Whether a hole has another axis than a bore, and no wall in common with it."""
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
