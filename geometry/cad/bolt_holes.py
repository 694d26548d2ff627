"""The holes that run through the joint of rod and cap, and what a bolt in each of them presses on."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import Floats
from geometry.cad.cylinders import recognised
from geometry.cad.holes import Hole, Interior, hollow_wall, place_text, wall_groups
from geometry.cad.joint import Joint
from geometry.errors import GeometryError
from geometry.faces import Face, edge_points, faces_of, loop_points, solid_points

# Cosine of the angle between a seat's normal and the axis; its distance from the end of the hole's wall (a
# chamfer may lie between), and its inner radius, over the hole's radius.
_SQUARE, _BEYOND, _INNER = 1 - 1e-6, 0.5, 1.6
# Places along each edge of a seat.
_PLACES = 64
# Difference of levels and radii that are the same, mm.
_SAME = 1e-4


@dataclass(frozen=True)
class Seat:
    """An annular part of a plane face around a hole."""

    level: float  # position along the axis, mm
    # inner, outer: radii of the largest whole annulus, mm
    inner: float
    outer: float
    round: bool = False  # whether its outer edge is a circle


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
    annuli = [seat for face in faces if face.shape == "Plane" and (seat := _annulus(face, point, direction))]
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


def _annulus(face: Face, point: Floats, direction: Floats) -> Seat | None:
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


# Angle between the axis of a hole and the joint's normal, rad; distance of two axes over the radius.
_PARALLEL, _COAXIAL = 2e-3, 0.1
# Largest radius of a bolt's hole over that of the bore, and distance of its wall from the joint over the
# hole's radius: chamfers and counterbores for dowels may lie between.
_LARGEST, _NEAR = 0.35, 4.0
# Length of a lip over its radius, at most.
_LIP = 0.2


@dataclass(frozen=True, eq=False)
class BoltHole:
    """A hole through the joint; positions count from the joint plane, towards the cap."""

    # point, direction: where its axis meets the joint plane (3,), mm, and the unit vector (3,) from the rod
    # to the cap
    point: Floats
    direction: Floats
    radius: float  # of its narrowest wall in the cap, mm
    # rod_radius, rod_wall: radius and ends of its narrowest wall in the rod, mm, the end away from the joint
    # first
    rod_radius: float
    rod_wall: tuple[float, float]
    cap_end: float  # where its wall in the cap ends, mm
    # head, nut: plane seats at its ends, if it has them
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


# A fastener's axis is that of its hole within this part of the hole's radius.
_ALONG_ONE_AXIS = 0.2


@dataclass(frozen=True, eq=False)
class Fastener:
    """A solid that may be a bolt, a nut or a washer."""

    points: Floats  # (n, 3) along its edges, mm
    planes: tuple[Floats, ...]  # per plane face, points (n, 3) along its edges, mm

    @classmethod
    def of(cls, volume: int) -> "Fastener":
        """Measure a volume of the open model."""
        faces = [recognised(face) for face in faces_of((volume,))]
        planes = tuple(edge_points(face.tag) for face in faces if face.shape == "Plane")
        return cls(solid_points(volume), planes)

    def is_in(self, hole: BoltHole) -> bool:
        """Whether its axis is that of a hole."""
        middle = (self.points.min(axis=0) + self.points.max(axis=0)) / 2
        return bool(hole.beside(middle[None])[0] < _ALONG_ONE_AXIS * hole.radius)

    def contact(self, hole: BoltHole, level: float) -> float | None:
        """Outer radius, mm, of its plane face at a position along a hole, if it has one wider than the hole.

        Of a hexagon it is that of the inscribed circle.
        """
        slack = 0.05 * hole.radius
        radii = []
        for points in self.planes:
            beside = hole.beside(points)
            if np.abs(hole.along(points) - level).max() < slack and beside.max() > 1.05 * hole.radius:
                rim = points[beside > (beside.min() + beside.max()) / 2]
                radii.append(_inscribed(hole, rim))
        return max(radii, default=None)

    def end(self, hole: BoltHole) -> float:
        """Least position along a hole, mm: where it ends in the rod."""
        return float(hole.along(self.points).min())


def _inscribed(hole: BoltHole, rim: Floats) -> float:
    return float(hole.beside(rim).min())


def removed(volumes: Sequence[int]) -> list[Fastener]:
    """Measure solids and take them out of the model."""
    found = [Fastener.of(volume) for volume in volumes]
    gmsh.model.occ.remove([(3, volume) for volume in volumes], recursive=True)
    gmsh.model.occ.synchronize()
    return found


# Radius of the seat over the hole's: the usual one (hexagons and cylinders of M8 to M12: 1.4 to 1.6), the
# least, and the step between those that are tried.
USUAL, _LEAST, _STEP = 1.5, 1.2, 0.05
# Depth of the cut where it is shallowest, over the hole's radius; least level over the height of the hole;
# levels that differ by less, over the hole's radius, become one.
_DEPTH, _LOWEST, _ALIKE = 0.1, 0.3, 0.2


def spot_faced(cap: int, holes: Sequence[BoltHole], wanted: float | None) -> tuple[int, list[BoltHole]]:
    """Cut plane seats for heads around the ends of those holes in a cap that have none.

    Parameters
    ----------
    cap
        Its volume tag; it is used up.
    holes
        Through the joint.
    wanted
        Radius of the seats, mm; None for the usual one, or less where the cap is narrow.

    Returns
    -------
    int, list of BoltHole
        The new volume, and the holes, all with seats.

    Raises
    ------
    GeometryError
        There is no material for a seat.
    """
    bare = [hole for hole in holes if hole.head is None]
    seats = [_seat(cap, hole, wanted) for hole in bare]
    if not seats:
        return cap, list(holes)
    radius = min(seat.outer for seat in seats)
    lowest = min(seat.level for seat in seats)
    found = {}
    for hole, seat in zip(bare, seats, strict=True):
        level = lowest if seat.level - lowest < _ALIKE * hole.radius else seat.level
        found[id(hole)] = Seat(level, hole.radius, radius, round=True)
    with kernel.attempt("cut seats for the bolts' heads into the cap"):
        cap = kernel.cut(cap, [_tool(hole, found[id(hole)]) for hole in bare])
        gmsh.model.occ.synchronize()
    return cap, [
        replace(hole, head=found[id(hole)], cap_end=found[id(hole)].level) if id(hole) in found else hole
        for hole in holes
    ]


def _seat(cap: int, hole: BoltHole, wanted: float | None) -> Seat:
    """The highest seat of the largest radius for which there is material."""
    usual = np.arange(USUAL, _LEAST, -_STEP) * hole.radius
    radii = usual.tolist() if wanted is None else [wanted]
    for radius in radii:
        level = _level(cap, hole, radius)
        if level > _LOWEST * hole.cap_end:
            return Seat(level, hole.radius, radius, round=True)
    raise GeometryError(
        f"the cap has no plane seat for the head of the bolt at {place_text(hole.point)}, and no material "
        f"around its hole of {2 * hole.radius:.4g} mm to cut one of {2 * radii[-1]:.4g} mm. Add a seat in "
        "the CAD program"
    )


def _level(cap: int, hole: BoltHole, radius: float) -> float:
    """Position below which a cylinder around the hole lies in the material, mm."""
    occ = gmsh.model.occ
    core, inner = (
        occ.addCylinder(*hole.point, *(1.1 * hole.cap_end * hole.direction), r)
        for r in (radius, 1.01 * hole.radius)
    )
    with kernel.attempt("look for a seat for a bolt's head on the cap"):
        tube, _ = occ.cut([(kernel.SOLID, core)], [(kernel.SOLID, inner)])
        void, _ = occ.cut(tube, [(kernel.SOLID, cap)], removeTool=False)
        occ.synchronize()
    # A round or a chamfer of the hole's edge at the joint is no end of the material.
    lowest = [float(hole.along(solid_points(tag)).min()) for dim, tag in void if dim == kernel.SOLID]
    tops = [float(hole.along(solid_points(tag)).max()) for dim, tag in void if dim == kernel.SOLID]
    occ.remove(void, recursive=True)
    occ.synchronize()
    ends = [low for low, top in zip(lowest, tops, strict=True) if top > _LOWEST * hole.cap_end]
    return min(ends, default=hole.cap_end) - _DEPTH * hole.radius


def _tool(hole: BoltHole, seat: Seat) -> int:
    start = hole.point + seat.level * hole.direction
    height = 2 * (hole.cap_end - seat.level) + 4 * seat.outer
    return int(gmsh.model.occ.addCylinder(*start, *(height * hole.direction), seat.outer))
