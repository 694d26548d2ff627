"""Cylindrical through-holes of an imported solid."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import gmsh
import numpy as np

from geometry.arrays import Floats
from geometry.faces import Face

_PARALLEL = 1e-6


@dataclass(frozen=True, eq=False)
class Hole:
    """A cylindrical through-hole.

    Attributes
    ----------
    center, direction
        Middle of its axis, mm, and the axis's unit vector.
    radius, width
        mm; the width is its length along the axis, at its longest.
    area, moment
        Of its wall, mm², and its first moment (3,) about `center`, mm³.
    faces
        gmsh's tags of its wall, the largest first.
    """

    center: Floats
    direction: Floats
    radius: float
    width: float
    area: float
    moment: Floats
    faces: tuple[int, ...]

    @property
    def mean_width(self) -> float:
        """Mean length of its wall along the axis (the ends may be slanted, an oil hole cut into it), mm."""
        return self.area / (2 * math.pi * self.radius)

    def taper(self, direction: Floats) -> float:
        """How much longer than its mean a wall with slanted ends is on the side of a unit vector, mm."""
        return float(self.moment @ direction) / (math.pi * self.radius**2)

    def parallel(self, other: "Hole") -> bool:
        """Whether the axes are parallel."""
        return bool(np.linalg.norm(np.cross(self.direction, other.direction)) < _PARALLEL)

    def apart(self, other: "Hole") -> float:
        """Return the distance of two parallel axes, mm."""
        between = other.center - self.center
        return float(np.linalg.norm(between - (between @ self.direction) * self.direction))

    def text(self) -> str:
        """Say where it is and how large."""
        x, y, z = self.center
        return f"diameter {2 * self.radius:.5g} mm at ({x:.4g}, {y:.4g}, {z:.4g}), {self.width:.4g} mm long"


def through_holes(volumes: Sequence[int], faces: Sequence[Face]) -> list[Hole]:
    """Return the cylindrical through-holes, one per axis, the largest radius first."""
    holes: list[Hole] = []
    for group in _coaxial([face for face in faces if face.shape == "Cylinder"]):
        walls = [wall for wall in _walls(group) if _is_through(wall, volumes)]
        if walls:
            holes.append(_bearing(walls))
    return sorted(holes, key=lambda hole: -hole.radius)


def _bearing(walls: Sequence[Hole]) -> Hole:
    """Return the coaxial wall that a pin touches: the narrowest one that is not just a lip."""
    most = max(wall.area for wall in walls)
    return min((wall for wall in walls if wall.area > most / 2), key=lambda wall: wall.radius)


def _coaxial(cylinders: Sequence[Face]) -> list[list[Face]]:
    groups: list[list[Face]] = []
    for face in cylinders:
        for group in groups:
            point, direction = np.array(group[0].values[:3]), np.array(group[0].values[3:6])
            offset = np.cross(np.array(face.values[:3]) - point, direction)
            turned = np.cross(np.array(face.values[3:6]), direction)
            if np.linalg.norm(offset) < 1e-5 * group[0].values[6] and np.linalg.norm(turned) < _PARALLEL:
                group.append(face)
                break
        else:
            groups.append([face])
    return groups


def _walls(group: Sequence[Face]) -> list[Hole]:
    """Join coaxial faces of one radius; keep the walls that go (nearly) all the way round."""
    point, direction = np.array(group[0].values[:3]), np.array(group[0].values[3:6])
    direction = direction * np.sign(direction[np.argmax(np.abs(direction))])
    walls = []
    for radius in sorted({round(face.values[6], 6) for face in group}):
        same = [face for face in group if abs(face.values[6] - radius) < 2e-6]
        same.sort(key=lambda face: -gmsh.model.occ.getMass(2, face.tag))
        extents = np.array([_extent(face, point, direction) for face in same])
        low, high = float(extents.min()), float(extents.max())
        areas = np.array([gmsh.model.occ.getMass(2, face.tag) for face in same])
        area = float(areas.sum())
        if area > 0.8 * 2 * math.pi * radius * _covered(extents):  # an oil hole may be missing from it
            center = point + (low + high) / 2 * direction
            tags = tuple(face.tag for face in same)
            middles = np.array([gmsh.model.occ.getCenterOfMass(2, tag) for tag in tags])
            moment = areas @ (middles - center)
            walls.append(
                Hole(
                    center=center,
                    direction=direction,
                    radius=same[0].values[6],
                    width=high - low,
                    area=area,
                    moment=moment,
                    faces=tags,
                )
            )
    return walls


def _extent(face: Face, point: Floats, direction: Floats) -> Floats:
    (u0, v0), (u1, v1) = gmsh.model.getParametrizationBounds(2, face.tag)
    ends = np.reshape(gmsh.model.getValue(2, face.tag, [u0, v0, u1, v1]), (2, 3))
    return np.asarray((ends - point) @ direction)


def _covered(extents: Floats) -> float:
    """Length of the union of intervals (n, 2); a groove divides the wall of a bore into several."""
    total, end = 0.0, -math.inf
    for low, high in sorted(map(sorted, extents.tolist())):
        total += max(0.0, high - max(low, end))
        end = max(end, high)
    return total


def _is_through(wall: Hole, volumes: Sequence[int]) -> bool:
    """Whether its axis is free from end to end and beyond, with material behind most of its wall."""
    reach = 0.55 * wall.width
    free = [wall.center + step * reach * wall.direction for step in (-1.0, -0.5, 0.0, 0.5, 1.0)]
    if any(inside(point, volumes) for point in free):
        return False
    # At the middle of a face, because the middle of the whole wall may lie in a groove.
    middle = np.array(gmsh.model.occ.getCenterOfMass(2, wall.faces[0]))
    level = wall.center + ((middle - wall.center) @ wall.direction) * wall.direction
    across = np.cross(wall.direction, np.eye(3)[np.argmin(np.abs(wall.direction))])
    across /= np.linalg.norm(across)
    other = np.cross(wall.direction, across)
    ring = [math.cos(a) * across + math.sin(a) * other for a in np.arange(8) * math.pi / 4 + 0.1]
    behind = sum(inside(level + 1.002 * wall.radius * out, volumes) for out in ring)
    before = sum(inside(level + 0.998 * wall.radius * out, volumes) for out in ring)
    return behind >= 6 and before == 0


def inside(point: Floats, volumes: Sequence[int]) -> bool:
    """Whether a point lies in any of the volumes."""
    return any(gmsh.model.isInside(3, volume, list(point)) for volume in volumes)
