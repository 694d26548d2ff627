"""Cylindrical holes of an imported solid: through-holes, and walls that are open on one side."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import gmsh
import numpy as np

from geometry.arrays import Floats
from geometry.cad.shapes import Interior, recognised_faces
from geometry.faces import Face, edge_points
from geometry.holes import CLOSED, PARALLEL, RoundHole, pin_wall, place_text

# Largest distance of two axes, and difference of two radii, that count as one, relative to the radius: bores
# of rod and cap are drawn apart, and some are fitted.
_COAXIAL, _ALIKE = 1e-3, 2e-4
# Least part of a turn that a wall open on one side covers, more than which a fillet does not cover.
_OPEN = 0.3


@dataclass(frozen=True, eq=False, kw_only=True)
class CadHole(RoundHole):
    """A cylindrical hole of a solid."""

    moment: Floats  #: (3,) first moment of the wall's area about `center`, mm³
    faces: tuple[int, ...]  #: gmsh's tags of its wall, the largest first
    deviation: float = 0.0  #: by how much the axes and radii of its faces differ, mm
    fitted: bool = False  #: whether it is fitted to a face that is a surface of another kind

    @property
    def mean_width(self) -> float:
        """Mean length of its wall along the axis (the ends may be slanted, an oil hole cut into it), mm."""
        return self.area / (2 * math.pi * self.radius)

    def taper(self, direction: Floats) -> float:
        """How much longer than its mean a wall with slanted ends is on the side of a unit vector, mm."""
        return float(self.moment @ direction) / (math.pi * self.radius**2)

    def text(self) -> str:
        """Say where it is and how large."""
        return f"diameter {2 * self.radius:.5g} mm at {place_text(self.center)}, {self.width:.4g} mm long"


def through_holes(interior: Interior, faces: Sequence[Face]) -> list[CadHole]:
    """Return the cylindrical through-holes, one per axis, the largest radius first."""
    holes: list[CadHole] = []
    for group in _coaxial(faces):
        walls = [wall for wall in _walls(group) if wall.turn > CLOSED and _is_hollow(wall, interior)]
        ends = 0.55 * np.linspace(-1, 1, 5)  # a little beyond the wall's
        walls = [
            wall for wall in walls if not any(interior.contains(wall.at(end * wall.width)) for end in ends)
        ]
        if walls:
            holes.append(pin_wall(walls))
    return sorted(holes, key=lambda hole: -hole.radius)


def wall_groups(faces: Sequence[Face], *, at_most: float = math.inf) -> list[list[CadHole]]:
    """Return cylindrical walls that cover a third of a turn or more, by their axes, hollow or not.

    `at_most` is the part of a turn that they cover at most.
    """
    groups = [[wall for wall in _walls(axis) if _OPEN < wall.turn <= at_most] for axis in _coaxial(faces)]
    return [group for group in groups if group]


def hollow_wall(interior: Interior, group: Sequence[CadHole]) -> CadHole | None:
    """Return the widest of coaxial walls with material outside them; None if there is none."""
    hollow = [wall for wall in group if _is_hollow(wall, interior)]
    return pin_wall(hollow) if hollow else None


def _coaxial(faces: Sequence[Face]) -> list[list[Face]]:
    groups: list[list[Face]] = []
    for face in faces:
        if face.shape != "Cylinder":
            continue
        for group in groups:
            point, direction = np.array(group[0].values[:3]), np.array(group[0].values[3:6])
            offset = np.cross(np.array(face.values[:3]) - point, direction)
            turned = np.cross(np.array(face.values[3:6]), direction)
            if np.linalg.norm(offset) < _COAXIAL * group[0].values[6] and np.linalg.norm(turned) < PARALLEL:
                group.append(face)
                break
        else:
            groups.append([face])
    return groups


def _walls(group: Sequence[Face]) -> Iterator[CadHole]:
    """Join coaxial faces of one radius."""
    point, direction = np.array(group[0].values[:3]), np.array(group[0].values[3:6])
    direction = direction * np.sign(direction[np.argmax(np.abs(direction))])
    alike: list[list[Face]] = []
    for face in sorted(group, key=lambda face: face.values[6]):
        if alike and face.values[6] - alike[-1][0].values[6] < _ALIKE * face.values[6]:
            alike[-1].append(face)
        else:
            alike.append([face])
    for same in alike:
        same.sort(key=lambda face: -gmsh.model.occ.getMass(2, face.tag))
        radius, tags = same[0].values[6], tuple(face.tag for face in same)
        extents = np.array([_extent(face, point, direction) for face in same])
        low, high = float(extents.min()), float(extents.max())
        covered, end = 0.0, -math.inf  # of the axis: a groove divides the wall of a bore into several
        for begin, stop in sorted(map(sorted, extents.tolist())):
            covered += max(0.0, stop - max(begin, end))
            end = max(end, stop)
        areas = np.array([gmsh.model.occ.getMass(2, tag) for tag in tags])
        middles = np.array([gmsh.model.occ.getCenterOfMass(2, tag) for tag in tags])
        center = point + (low + high) / 2 * direction
        apart = [np.cross(np.array(face.values[:3]) - point, direction) for face in same]
        yield CadHole(
            center=center,
            direction=direction,
            radius=radius,
            width=high - low,
            area=float(areas.sum()),
            moment=areas @ (middles - center),
            faces=tags,
            turn=float(areas.sum()) / (2 * math.pi * radius * covered),
            deviation=float(max(np.linalg.norm(apart, axis=1)) + np.ptp([face.values[6] for face in same])),
            fitted=any(face.fitted for face in same),
        )


def _extent(face: Face, point: Floats, direction: Floats) -> Floats:
    if face.fitted:
        along = (edge_points(face.tag) - point) @ direction
        return np.array([along.min(), along.max()])
    (u0, v0), (u1, v1) = gmsh.model.getParametrizationBounds(2, face.tag)
    ends = np.reshape(gmsh.model.getValue(2, face.tag, [u0, v0, u1, v1]), (2, 3))
    return np.asarray((ends - point) @ direction)


def _is_hollow(wall: CadHole, interior: Interior) -> bool:
    """Whether there is material outside the largest face of a wall, and none before it."""
    low, high = (np.array(end) for end in gmsh.model.getParametrizationBounds(2, wall.faces[0]))
    middle = list((low + high) / 2)
    point = np.array(gmsh.model.getValue(2, wall.faces[0], middle))
    out = point - wall.center
    out -= (out @ wall.direction) * wall.direction
    if gmsh.model.getAdjacencies(2, wall.faces[0])[0].size == 1:  # its normal points out of its only volume
        if out @ np.array(gmsh.model.getNormal(wall.faces[0], middle)) > 0:
            return False
        if interior.single:
            return True
    return not interior.contains(point - 2e-3 * out) and interior.contains(point + 2e-3 * out)


@dataclass(frozen=True)
class Walls:
    """Cylindrical walls of a solid.

    Those of the largest radius are looked at first: of a solid with a thousand faces, all take long.
    """

    interior: Interior
    groups: tuple[list[CadHole], ...]  #: walls with the same axis, those with the largest radius first

    def hollow(self) -> Iterator[CadHole]:
        """Find the hollow walls, one per axis, the largest radius first."""
        hollow: list[CadHole] = []
        for group in self.groups:
            least = max(wall.radius for wall in group)
            while hollow and hollow[0].radius >= least:
                yield hollow.pop(0)
            wall = hollow_wall(self.interior, group)
            hollow = sorted([*hollow, *([] if wall is None else [wall])], key=lambda wall: -wall.radius)
        yield from hollow

    def about(self, bore: CadHole, slack: float) -> Iterator[CadHole]:
        """Find the hollow wall on the axis of a bore, up to a distance relative to the bore's radius."""
        for group in self.groups:
            if group[0].parallel(bore) and group[0].apart(bore) < slack * bore.radius:
                wall = hollow_wall(self.interior, group)
                yield from () if wall is None else (wall,)


def walls_of(volume: int) -> Walls:
    """Return the walls of a volume of the open model."""
    groups = wall_groups(recognised_faces((volume,)))
    return Walls(
        Interior((volume,)), tuple(sorted(groups, key=lambda group: -max(wall.radius for wall in group)))
    )
