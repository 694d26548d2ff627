"""The holes that run through the joint of rod and cap, and what a bolt in each of them presses on."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats
from geometry.cad.holes import Hole, hollow_wall, wall_groups
from geometry.cad.interior import Interior
from geometry.cad.joint import Joint
from geometry.cad.seats import Seat, seat_at
from geometry.faces import Face

# Angle between the axis of a hole and the joint's normal, rad; distance of two axes over the radius.
_PARALLEL, _COAXIAL = 2e-3, 0.1
# Largest radius of a bolt's hole over that of the bore, and distance of its wall from the joint over the
# hole's radius: chamfers and counterbores for dowels may lie between.
_LARGEST, _NEAR = 0.35, 4.0
# Length of a lip over its radius, at most.
_LIP = 0.2


@dataclass(frozen=True, eq=False)
class BoltHole:
    """A hole through the joint; positions count from the joint plane, towards the cap.

    Attributes
    ----------
    point, direction
        Where its axis meets the joint plane (3,), mm, and the unit vector (3,) from the rod to the cap.
    radius
        Of its narrowest wall in the cap, mm.
    rod_radius, rod_wall
        Radius and ends of its narrowest wall in the rod, mm, the end away from the joint first.
    cap_end
        Where its wall in the cap ends, mm.
    head, nut
        Plane seats at its ends, if it has them.
    """

    point: Floats
    direction: Floats
    radius: float
    rod_radius: float
    rod_wall: tuple[float, float]
    cap_end: float
    head: Seat | None
    nut: Seat | None

    def along(self, points: Floats) -> Floats:
        """Positions (n,) of points (n, 3), mm."""
        return np.asarray((points - self.point) @ self.direction)

    def beside(self, points: Floats) -> Floats:
        """Distances (n,) of points (n, 3) from the axis, mm."""
        away = points - self.point
        return np.asarray(np.linalg.norm(away - self.along(points)[:, None] * self.direction, axis=1))


def bolt_holes(
    rod: Sequence[int],
    cap: Sequence[int],
    faces: tuple[Sequence[Face], Sequence[Face]],
    joint: Joint,
    bore: float,
) -> list[BoltHole]:
    """Find them; holes at larger y come first.

    Parameters
    ----------
    rod, cap
        Volume tags.
    faces
        Of the rod and of the cap.
    joint
        Between the two.
    bore
        Radius of the big end's bore, mm.
    """
    direction = -joint.normal
    origin = joint.offset * joint.normal
    in_rod, in_cap = (
        _groups(volumes, own, direction, bore) for volumes, own in zip((rod, cap), faces, strict=True)
    )
    material = Interior(cap)
    found = []
    for near in in_cap:
        for far in in_rod:
            if _axes_apart(near, far, direction) < _COAXIAL * near.radius:
                hole = _hole(near, far, direction, origin, faces)
                if hole is not None and _is_open(hole, material):
                    found.append(hole)
    return sorted(found, key=lambda hole: (-round(float(hole.point[1]), 6), -float(hole.point[2])))


def _is_open(hole: BoltHole, material: Interior) -> bool:
    """Whether a hole leads out of the cap; those of dowels do not."""
    beyond = [hole.point + (hole.cap_end + step * hole.radius) * hole.direction for step in (0.2, 0.6, 1.0)]
    return not any(material.contains(point) for point in beyond)


def _groups(volumes: Sequence[int], faces: Sequence[Face], direction: Floats, bore: float) -> list[Hole]:
    """Narrowest hollow walls, one per axis, of the size and direction of a bolt's hole."""
    interior = Interior(volumes)
    walls = [
        [wall for wall in group if wall.radius < _LARGEST * bore]
        for group in wall_groups(faces)
        if np.linalg.norm(np.cross(group[0].direction, direction)) < _PARALLEL
    ]
    narrowest = [_narrowest(interior, group) for group in walls]
    return [wall for wall in narrowest if wall is not None]


def _narrowest(interior: Interior, group: Sequence[Hole]) -> Hole | None:
    """Return the narrowest hollow wall that is no lip: heads may be sunk deep into wider ones."""
    longer = [wall for wall in group if wall.width > _LIP * wall.radius]
    return next(
        (wall for wall in sorted(longer, key=lambda wall: wall.radius) if hollow_wall(interior, [wall])), None
    )


def _axes_apart(one: Hole, other: Hole, direction: Floats) -> float:
    between = other.center - one.center
    return float(np.linalg.norm(between - (between @ direction) * direction))


def _hole(
    near: Hole,
    far: Hole,
    direction: Floats,
    origin: Floats,
    faces: tuple[Sequence[Face], Sequence[Face]],
) -> BoltHole | None:
    """Join the walls in cap and rod, if both reach to about the joint plane."""
    point = near.center - ((near.center - origin) @ direction) * direction
    middle = [float((wall.center - point) @ direction) for wall in (near, far)]
    cap = middle[0] - near.width / 2, middle[0] + near.width / 2
    rod = middle[1] - far.width / 2, middle[1] + far.width / 2
    reach = _NEAR * near.radius
    if not (abs(cap[0]) < reach and abs(rod[1]) < reach and middle[0] > 0 > middle[1]):
        return None
    head = seat_at(faces[1], point, direction, cap[1], near.radius)
    nut = seat_at(faces[0], point, -direction, -rod[0], far.radius)
    return BoltHole(point, direction, near.radius, far.radius, rod, cap[1], head, nut)
