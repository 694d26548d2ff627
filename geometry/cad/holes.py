"""Cylindrical holes of an imported solid: through-holes, and walls that are open on one side."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import gmsh
import numpy as np

from geometry.arrays import Floats
from geometry.cad.cylinders import recognised
from geometry.faces import Face, edge_points, faces_of


class Interior:
    """The inside of volumes of the open model.

    The kernel takes milliseconds to tell, so it is asked only for volumes whose bounding box holds the point.

    Parameters
    ----------
    volumes
        gmsh's tags.
    """

    def __init__(self, volumes: Sequence[int]) -> None:
        self._volumes = tuple(volumes)
        boxes = np.reshape([gmsh.model.getBoundingBox(3, volume) for volume in volumes], (-1, 2, 3))
        self._low, self._high = boxes[:, 0], boxes[:, 1]

    def contains(self, point: Floats) -> bool:
        """Whether a point lies in any of the volumes."""
        near = ((self._low <= point) & (point <= self._high)).all(axis=1)
        return any(gmsh.model.isInside(3, self._volumes[at], list(point)) for at in np.flatnonzero(near))


_PARALLEL = 1e-4
# Largest distance of two axes, and difference of two radii, that count as one, relative to the radius: bores
# of rod and cap are drawn apart, and some are fitted.
_COAXIAL, _ALIKE = 1e-3, 2e-4
# Least part of a turn that the wall of a hole covers (an oil hole may be missing from it), and of one that is
# open on one side, more than which a fillet does not cover.
CLOSED, _OPEN = 0.8, 0.3


@dataclass(frozen=True, eq=False)
class Hole:
    """A cylindrical through-hole."""

    # center, direction: middle of its axis, mm, and the axis's unit vector
    center: Floats
    direction: Floats
    # radius, width: mm; the width is its length along the axis, at its longest
    radius: float
    width: float
    # area, moment: of its wall, mm², and its first moment (3,) about `center`, mm³
    area: float
    moment: Floats
    faces: tuple[int, ...]  # gmsh's tags of its wall, the largest first
    turn: float = 1.0  # part of a full turn that the wall covers, in the mean over its width
    deviation: float = 0.0  # by how much the axes and radii of its faces differ, mm
    fitted: bool = False  # whether a face of it is a surface of another kind, to which the cylinder is fitted

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

    def has_diameter(self, diameter: float | None) -> bool:
        """Whether it has a diameter, mm, if one is given."""
        return diameter is None or math.isclose(2 * self.radius, diameter, rel_tol=1e-3)

    def text(self) -> str:
        """Say where it is and how large."""
        return f"diameter {2 * self.radius:.5g} mm at {place_text(self.center)}, {self.width:.4g} mm long"


def place_text(place: Floats) -> str:
    """Write coordinates, mm, without the remainders of rounding."""
    x, y, z = np.round(place, 4) + 0.0
    return f"({x:.4g}, {y:.4g}, {z:.4g})"


def through_holes(interior: Interior, faces: Sequence[Face]) -> list[Hole]:
    """Return the cylindrical through-holes, one per axis, the largest radius first."""
    holes: list[Hole] = []
    for group in _coaxial([face for face in faces if face.shape == "Cylinder"]):
        walls = [wall for wall in _walls(group) if wall.turn > CLOSED and _is_through(wall, interior)]
        if walls:
            holes.append(_bearing(walls))
    return sorted(holes, key=lambda hole: -hole.radius)


def hollow_walls(interior: Interior, faces: Sequence[Face], *, at_most: float = math.inf) -> list[Hole]:
    """Return cylindrical walls with material outside them that cover a third of a turn or more.

    Parameters
    ----------
    at_most
        Part of a turn that they cover at most.

    Returns
    -------
    list of Hole
        The widest of each axis, the largest radius first.
    """
    walls = [hollow_wall(interior, group) for group in wall_groups(faces, at_most=at_most)]
    return sorted((wall for wall in walls if wall is not None), key=lambda wall: -wall.radius)


def wall_groups(faces: Sequence[Face], *, at_most: float = math.inf) -> list[list[Hole]]:
    """Return cylindrical walls that cover a third of a turn or more, by their axes, hollow or not.

    Parameters
    ----------
    at_most
        Part of a turn that they cover at most.
    """
    axes = _coaxial([face for face in faces if face.shape == "Cylinder"])
    groups = [[wall for wall in _walls(axis) if _OPEN < wall.turn <= at_most] for axis in axes]
    return [group for group in groups if group]


def hollow_wall(interior: Interior, group: Sequence[Hole]) -> Hole | None:
    """Return the widest of coaxial walls with material outside them; None if there is none."""
    hollow = [wall for wall in group if _is_hollow(wall, interior)]
    return _bearing(hollow) if hollow else None


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
            if np.linalg.norm(offset) < _COAXIAL * group[0].values[6] and np.linalg.norm(turned) < _PARALLEL:
                group.append(face)
                break
        else:
            groups.append([face])
    return groups


def _walls(group: Sequence[Face]) -> list[Hole]:
    """Join coaxial faces of one radius."""
    point, direction = np.array(group[0].values[:3]), np.array(group[0].values[3:6])
    direction = direction * np.sign(direction[np.argmax(np.abs(direction))])
    walls = []
    for same in _of_radius(group):
        same.sort(key=lambda face: -gmsh.model.occ.getMass(2, face.tag))
        radius = same[0].values[6]
        extents = np.array([_extent(face, point, direction) for face in same])
        low, high = float(extents.min()), float(extents.max())
        areas = np.array([gmsh.model.occ.getMass(2, face.tag) for face in same])
        area = float(areas.sum())
        center = point + (low + high) / 2 * direction
        tags = tuple(face.tag for face in same)
        middles = np.array([gmsh.model.occ.getCenterOfMass(2, tag) for tag in tags])
        apart = [np.cross(np.array(face.values[:3]) - point, direction) for face in same]
        walls.append(
            Hole(
                center=center,
                direction=direction,
                radius=radius,
                width=high - low,
                area=area,
                moment=areas @ (middles - center),
                faces=tags,
                turn=area / (2 * math.pi * radius * _covered(extents)),
                deviation=float(
                    max(np.linalg.norm(apart, axis=1)) + np.ptp([face.values[6] for face in same])
                ),
                fitted=any(face.fitted for face in same),
            )
        )
    return walls


def _of_radius(group: Sequence[Face]) -> list[list[Face]]:
    """Divide coaxial faces by their radius, the smallest first."""
    found: list[list[Face]] = []
    for face in sorted(group, key=lambda face: face.values[6]):
        if found and face.values[6] - found[-1][0].values[6] < _ALIKE * face.values[6]:
            found[-1].append(face)
        else:
            found.append([face])
    return found


def _extent(face: Face, point: Floats, direction: Floats) -> Floats:
    if face.fitted:
        along = (edge_points(face.tag) - point) @ direction
        return np.array([along.min(), along.max()])
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


def _is_through(wall: Hole, interior: Interior) -> bool:
    """Whether its axis is free from end to end and beyond, with material behind most of its wall."""
    reach = 0.55 * wall.width
    free = [wall.center + step * reach * wall.direction for step in (-1.0, -0.5, 0.0, 0.5, 1.0)]
    if any(interior.contains(point) for point in free):
        return False
    # At the middle of a face, because the middle of the whole wall may lie in a groove.
    middle = np.array(gmsh.model.occ.getCenterOfMass(2, wall.faces[0]))
    level = wall.center + ((middle - wall.center) @ wall.direction) * wall.direction
    across = np.cross(wall.direction, np.eye(3)[np.argmin(np.abs(wall.direction))])
    across /= np.linalg.norm(across)
    other = np.cross(wall.direction, across)
    ring = [math.cos(a) * across + math.sin(a) * other for a in np.arange(8) * math.pi / 4 + 0.1]
    behind = sum(interior.contains(level + 1.002 * wall.radius * out) for out in ring)
    before = sum(interior.contains(level + 0.998 * wall.radius * out) for out in ring)
    return behind >= 6 and before == 0


def _is_hollow(wall: Hole, interior: Interior) -> bool:
    """Whether there is material outside the largest face of a wall, and none before it."""
    low, high = (np.array(end) for end in gmsh.model.getParametrizationBounds(2, wall.faces[0]))
    votes = 0
    for share in ((0.5, 0.5), (0.3, 0.4), (0.7, 0.6), (0.4, 0.7), (0.6, 0.3)):  # one may lie in an oil hole
        point = np.array(gmsh.model.getValue(2, wall.faces[0], list(low + (high - low) * share)))
        out = point - wall.center
        out -= (out @ wall.direction) * wall.direction
        hollow = not interior.contains(point - 2e-3 * out) and interior.contains(point + 2e-3 * out)
        votes += 1 if hollow else -1
        if abs(votes) == 2:
            break
    return votes > 0


@dataclass(frozen=True)
class Walls:
    """Cylindrical walls of a solid.

    Of a solid with a thousand faces, the kernel takes a minute to tell which are hollow.
    """

    interior: Interior  # of the solid
    groups: tuple[tuple[Hole, ...], ...]  # walls with the same axis, those with the largest radius first

    def hollow(self) -> Iterator[Hole]:
        """Find the hollow walls, one per axis, the largest radius first."""
        found: list[Hole] = []
        for group in self.groups:
            least = max(wall.radius for wall in group)
            while found and found[0].radius >= least:
                yield found.pop(0)
            wall = hollow_wall(self.interior, group)
            found = sorted([*found, *([] if wall is None else [wall])], key=lambda wall: -wall.radius)
        yield from found

    def about(self, bore: Hole, slack: float) -> Iterator[Hole]:
        """Find the hollow wall on the axis of a bore, up to a distance relative to the bore's radius."""
        for group in self.groups:
            if group[0].parallel(bore) and group[0].apart(bore) < slack * bore.radius:
                wall = hollow_wall(self.interior, group)
                yield from () if wall is None else (wall,)


def walls_of(volume: int) -> Walls:
    """Return the walls of a volume of the open model."""
    groups = wall_groups([recognised(face) for face in faces_of((volume,))])
    groups.sort(key=lambda group: -max(wall.radius for wall in group))
    return Walls(Interior((volume,)), tuple(map(tuple, groups)))
