"""Plane seats around holes of imported solids."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import gmsh
import numpy as np

from geometry.arrays import Floats
from geometry.cad.cylinders import loop_points
from geometry.faces import Face

# Cosine of the angle between a seat's normal and the axis; its distance from the end of the hole's wall (a
# chamfer may lie between), and its inner radius, over the hole's radius.
_SQUARE, _BEYOND, _INNER = 1 - 1e-6, 0.5, 1.6
# Places along each edge of a seat.
_PLACES = 64
# Difference of levels and radii that are the same, mm.
_SAME = 1e-4


@dataclass(frozen=True)
class Seat:
    """An annular part of a plane face around a hole.

    Attributes
    ----------
    level
        Position along the axis, mm.
    inner, outer
        Radii of the largest whole annulus, mm.
    round
        Whether its outer edge is a circle.
    """

    level: float
    inner: float
    outer: float
    round: bool = False


def seat_at(
    faces: Sequence[Face], point: Floats, direction: Floats, end: float, radius: float
) -> Seat | None:
    """Find the plane face around the end of a hole; None without one that surrounds the axis.

    Parameters
    ----------
    faces
        Of the solid.
    point, direction
        Of the axis; `direction` leads out of the hole.
    end
        Position of the end of the hole's wall along the axis, mm.
    radius
        Of the hole, mm.
    """
    annuli = [seat for face in faces if face.shape == "Plane" and (seat := _seat(face, point, direction))]
    near = [
        seat
        for seat in annuli
        if -1e-3 * radius <= seat.level - end <= _BEYOND * radius and seat.inner < _INNER * radius
    ]
    first = min(near, key=lambda seat: (round(seat.level, 6), seat.inner), default=None)
    return None if first is None else _grown(first, annuli)


def _grown(seat: Seat, annuli: Sequence[Seat]) -> Seat:
    """Add the annuli around it, into which imprinted circles divide a face."""
    for other in sorted(annuli, key=lambda one: one.inner):
        beside = abs(other.level - seat.level) < _SAME and abs(other.inner - seat.outer) < _SAME
        seat = replace(seat, outer=other.outer, round=other.round) if beside else seat
    return seat


def _seat(face: Face, point: Floats, direction: Floats) -> Seat | None:
    low, high = gmsh.model.getParametrizationBounds(2, face.tag)
    normal = np.array(gmsh.model.getNormal(face.tag, [(a + b) / 2 for a, b in zip(low, high, strict=True)]))
    if abs(normal @ direction) < _SQUARE:
        return None
    _, loops = gmsh.model.occ.getCurveLoops(face.tag)
    if len(loops) < 2:
        return None
    level = float((loop_points(loops[0])[0] - point) @ direction)
    center = point + level * direction
    reach = [_reach(loop, center) for loop in loops]
    inner = min(range(len(loops)), key=lambda number: reach[number][1])
    if not _surrounds(loop_points(loops[inner]) - center, direction):
        return None
    nearest, farthest = min(ends for number, ends in enumerate(reach) if number != inner)
    return Seat(level, reach[inner][1], nearest, round=farthest - nearest < _SAME)


def _reach(loop: Sequence[int], center: Floats) -> tuple[float, float]:
    """Least and largest distance of a loop of curves from a point, mm."""
    apart = np.linalg.norm(loop_points(loop, _PLACES) - center, axis=1)
    return float(apart.min()), float(apart.max())


def _surrounds(away: Floats, direction: Floats) -> bool:
    """Whether points (n, 3) of a loop lie on all sides of the axis."""
    across = np.linalg.svd(direction[None])[2][1:]
    angle = np.sort(np.arctan2(away @ across[1], away @ across[0]))
    gaps = np.diff(np.append(angle, angle[0] + 2 * np.pi))
    return bool(gaps.max() < np.pi)
