"""The joint of rod and cap of an imported assembly, and the holes for bolts that run through it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import Floats
from geometry.cad.bores import CadHole, hollow_wall, wall_groups
from geometry.cad.shapes import Interior, recognised_faces
from geometry.errors import GeometryError
from geometry.faces import Face, edge_points, face_middle, loop_points, parameter_grid, solid_points
from geometry.holes import Axis, basis_across, place_text
from geometry.kernel import SOLID
from geometry.parts import boundary

# A plane lies farther from the big end's centre than this part of the bore's radius only by mistake; faces
# of serrations and fractures lie within this part of it from their mean plane.
_OFF, _ROUGH = 0.5, 0.2


@dataclass(frozen=True, eq=False)
class Joint:
    """The mean plane of the faces that rod and cap share."""

    normal: Floats  #: unit vector (3,) from the cap to the rod
    offset: float  #: distance of the plane from the big end's centre along the normal, mm
    area: float  #: of the faces, mm²
    flatness: float  #: distance of the two planes parallel to it that enclose the faces' edges, mm
    faces: int  #: how many there are

    @property
    def angle(self) -> float:
        """Of the normal in the plane of motion from +x, degrees."""
        return float(np.degrees(np.arctan2(self.normal[1], self.normal[0]))) + 0.0

    def text(self) -> str:
        """Say where it is."""
        plane = "plane" if self.flatness < 1e-3 else f"within {self.flatness:.3g} mm of a plane"
        turned = "straight" if abs(self.angle) < 0.05 else f"oblique by {self.angle:.4g}°"
        off = f", {self.offset:+.3g} mm from the big end's centre" if abs(self.offset) > 5e-4 else ""
        return f"joint: {turned}{off}, {self.area:.4g} mm² on {self.faces} faces, {plane}"


def joint_of(rod: Sequence[int], cap: Sequence[int], radius: float) -> Joint:
    """Find the joint of rod and cap at a bore's radius, mm. Raises `GeometryError`: there is none."""
    faces = sorted(boundary(rod) & boundary(cap))
    if not faces:
        gap = min(gmsh.model.occ.getDistance(kernel.SOLID, a, kernel.SOLID, b)[0] for a in rod for b in cap)
        raise GeometryError(
            f"rod and cap do not touch (gap {gap:.3g} mm), so there is no joint. Close the gap in the CAD "
            "program"
        )
    points = np.concatenate([edge_points(face) for face in faces])
    areas = np.array([gmsh.model.occ.getMass(2, face) for face in faces])
    normal = _normal(faces, points, areas)
    away = np.mean([gmsh.model.occ.getCenterOfMass(3, tag) for tag in cap], axis=0) - points.mean(axis=0)
    normal = -normal if normal @ away > 0 else normal
    height = points @ normal
    middles = np.array([gmsh.model.occ.getCenterOfMass(2, face) for face in faces])
    offset, area = float(areas @ (middles @ normal) / areas.sum()), float(areas.sum())
    joint = Joint(normal + 0.0, offset, area, float(np.ptp(height)), len(faces))
    if abs(joint.normal[2]) > 1e-3 or joint.flatness > _ROUGH * radius or abs(joint.offset) > _OFF * radius:
        raise GeometryError(
            f"the faces that rod and cap share are no joint across the big end: their mean normal is "
            f"({', '.join(f'{value:.3g}' for value in joint.normal)}) in the rod's frame (x to the small "
            f"end, z along the pins), {joint.offset:.3g} mm from the bore's centre, and they lie within "
            f"{joint.flatness:.3g} mm of a plane. Name the solids that belong to the rod with rod.solids"
        )
    return joint


def _normal(faces: Sequence[int], points: Floats, areas: Floats) -> Floats:
    """Mean normal (3,) of faces that roughly lie in a plane, whichever way each is oriented."""
    rough = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][2]
    total = np.zeros(3)
    for face, area in zip(faces, areas, strict=True):
        places = parameter_grid(face, np.linspace(0.1, 0.9, 5)).ravel()
        normals = np.reshape(gmsh.model.getNormal(face, places), (-1, 3))
        mean = normals.mean(axis=0)
        total += area * mean * np.sign(mean @ rough)
    return np.asarray(total / np.linalg.norm(total))


# Largest distance of the joint from the bore's axis, and from the wall of the bore, over its radius.
_CAP_OFF = 0.05


def assumed_cap(faces: Sequence[Face], wall: CadHole) -> int:
    """Draw a half ring that closes a wall; its volume tag. Raises `GeometryError`: no two plane faces."""
    planes = [(face, edge_points(face.tag)) for face in faces if face.shape == "Plane"]
    angles = [(face, wall.joint_angle(at, at.mean(axis=0), _CAP_OFF)) for face, at in planes]
    joints = [(face, angle) for face, angle in angles if angle is not None]
    if len(joints) != 2:
        raise GeometryError(
            f"no cap can be assumed: {len(joints)} plane faces, not 2, lie at the open ends of the bore's "
            f"wall ({wall.text()}). Add the cap to the file"
        )
    (face, start), (_, end) = joints
    sweep = (end - start) % (2 * math.pi)
    x, y = basis_across(wall.direction)
    middle = math.cos(start + sweep / 2) * x + math.sin(start + sweep / 2) * y
    if wall.moment @ middle > 0:  # the wall lies there: the other way round
        sweep -= 2 * math.pi
    occ = gmsh.model.occ
    with kernel.attempt("draw the assumed cap"):
        _, curves = occ.getCurveLoops(face.tag)
        boxes = [[occ.getBoundingBox(1, int(tag)) for tag in loop] for loop in curves]
        extents = [np.ptp(np.reshape(box, (-1, 3)), axis=0).max() for box in boxes]
        outer = curves[int(np.argmax(extents))]  # the others are bolt holes
        section = occ.addPlaneSurface([occ.addCurveLoop([int(tag) for tag in outer])])
        swept = occ.revolve([(2, section)], *wall.center, *wall.direction, sweep)
        occ.remove([(2, section)])
        occ.synchronize()
    return next(int(tag) for dim, tag in swept if dim == kernel.SOLID)


# Cosine of the angle between a seat's normal and the axis; its distance from the end of the hole's wall (a
# chamfer may lie between), and its inner radius, over the hole's radius.
_SQUARE, _BEYOND, _INNER = 1 - 1e-6, 0.5, 1.6
# Places along each edge of a seat.
_PLACES = 64
# Difference of levels and radii that are the same, mm.
_SAME = 1e-4
# Angle between the axis of a hole and the joint's normal, rad; distance of two axes over the radius.
_PARALLEL, _COAXIAL = 2e-3, 0.1
# Largest radius of a bolt's hole over that of the bore, and distance of its wall from the joint over the
# hole's radius: chamfers and counterbores for dowels may lie between.
_LARGEST, _NEAR = 0.35, 4.0
# Length of a lip over its radius, at most.
_LIP = 0.2


@dataclass(frozen=True)
class Seat:
    """An annular part of a plane face around a hole."""

    level: float  #: position along the axis, mm
    inner: float  #: radius of the largest whole annulus, mm
    outer: float  #: likewise
    round: bool = False  #: whether its outer edge is a circle


@dataclass(frozen=True, eq=False, kw_only=True)
class BoltHole(Axis):
    """A hole through the joint; its centre lies in the joint plane, its direction leads from rod to cap."""

    radius: float  #: of its narrowest wall in the cap, mm
    rod_radius: float  #: of its narrowest wall in the rod, mm
    rod_wall: tuple[float, float]  #: ends of that wall, mm, the one away from the joint first
    cap_end: float  #: where its wall in the cap ends, mm
    head: Seat | None  #: plane seat at its end in the cap
    nut: Seat | None  #: plane seat at its end in the rod


def bolt_holes(rod: Sequence[int], cap: Sequence[int], joint: Joint, bore: float) -> list[BoltHole]:
    """Find the bolt holes in rod and cap, those at larger y first. `bore`: radius of the big end, mm."""
    direction = -joint.normal
    origin = joint.offset * joint.normal
    faces = recognised_faces(rod), recognised_faces(cap)
    in_rod = _narrowest_walls(rod, faces[0], direction, bore)
    material = Interior(cap)
    holes = []
    for near in _narrowest_walls(cap, faces[1], direction, bore):
        for far in in_rod:
            if Axis(center=near.center, direction=direction).apart(far) < _COAXIAL * near.radius:
                hole = _hole(near, far, direction, origin, faces)
                if hole is None:
                    continue
                beyond = [hole.at(hole.cap_end + step * hole.radius) for step in (0.2, 0.6, 1.0)]
                if not any(material.contains(point) for point in beyond):  # those of dowels end in the cap
                    holes.append(hole)
    return sorted(holes, key=lambda hole: (-round(float(hole.center[1]), 6), -float(hole.center[2])))


def _narrowest_walls(
    volumes: Sequence[int], faces: Sequence[Face], direction: Floats, bore: float
) -> list[CadHole]:
    """Narrowest hollow walls but lips, one per axis, of a bolt's size: heads may be sunk into wider ones."""
    interior, narrowest = Interior(volumes), []
    for group in wall_groups(faces):
        if np.linalg.norm(np.cross(group[0].direction, direction)) < _PARALLEL:
            walls = [w for w in group if w.radius < _LARGEST * bore and w.width > _LIP * w.radius]
            walls.sort(key=lambda wall: wall.radius)
            narrowest.append(next((wall for wall in walls if hollow_wall(interior, [wall])), None))
    return [wall for wall in narrowest if wall is not None]


def _hole(
    near: CadHole,
    far: CadHole,
    direction: Floats,
    origin: Floats,
    faces: tuple[Sequence[Face], Sequence[Face]],
) -> BoltHole | None:
    point = near.center - ((near.center - origin) @ direction) * direction
    middle = [float((wall.center - point) @ direction) for wall in (near, far)]
    cap = middle[0] - near.width / 2, middle[0] + near.width / 2
    rod = middle[1] - far.width / 2, middle[1] + far.width / 2
    reach = _NEAR * near.radius
    if not (abs(cap[0]) < reach and abs(rod[1]) < reach and middle[0] > 0 > middle[1]):
        return None
    return BoltHole(
        center=point,
        direction=direction,
        radius=near.radius,
        rod_radius=far.radius,
        rod_wall=rod,
        cap_end=cap[1],
        head=_seat_at(faces[1], point, direction, cap[1], near.radius),
        nut=_seat_at(faces[0], point, -direction, -rod[0], far.radius),
    )


def _seat_at(
    faces: Sequence[Face], point: Floats, direction: Floats, end: float, radius: float
) -> Seat | None:
    annuli = [seat for face in faces if face.shape == "Plane" and (seat := _annulus(face, point, direction))]
    near = [seat for seat in annuli if -1e-3 * radius <= seat.level - end <= _BEYOND * radius]
    near = [seat for seat in near if seat.inner < _INNER * radius]
    seat = min(near, key=lambda seat: (round(seat.level, 6), seat.inner), default=None)
    if seat is not None:  # imprinted circles may divide the face into several annuli
        for other in sorted(annuli, key=lambda seat: seat.inner):
            beside = abs(other.level - seat.level) < _SAME and abs(other.inner - seat.outer) < _SAME
            seat = replace(seat, outer=other.outer, round=other.round) if beside else seat
    return seat


def _annulus(face: Face, point: Floats, direction: Floats) -> Seat | None:
    if abs(face_middle(face.tag)[1] @ direction) < _SQUARE:
        return None
    _, loops = gmsh.model.occ.getCurveLoops(face.tag)
    if len(loops) < 2:
        return None
    level = float((loop_points(loops[0])[0] - point) @ direction)
    center = point + level * direction
    apart = [np.linalg.norm(loop_points(loop, _PLACES) - center, axis=1) for loop in loops]
    reach = [(float(distances.min()), float(distances.max())) for distances in apart]
    inner = min(range(len(loops)), key=lambda number: reach[number][1])
    away = loop_points(loops[inner]) - center
    across = basis_across(direction)
    angle = np.sort(np.arctan2(away @ across[1], away @ across[0]))
    gaps = np.diff(np.append(angle, angle[0] + 2 * np.pi))
    if gaps.max() >= np.pi:  # the axis is not inside of it
        return None
    nearest, farthest = min(ends for number, ends in enumerate(reach) if number != inner)
    return Seat(level, reach[inner][1], nearest, round=farthest - nearest < _SAME)


# Radius of the seat over the hole's: the usual one (hexagons and cylinders of M8 to M12: 1.4 to 1.6), the
# least, and the step between those that are tried.
USUAL, _LEAST, _STEP = 1.5, 1.2, 0.05
# Depth of the cut where it is shallowest, over the hole's radius; least level over the height of the hole;
# levels that differ by less, over the hole's radius, become one.
_DEPTH, _LOWEST, _ALIKE = 0.1, 0.3, 0.2


def spot_faced(cap: int, holes: Sequence[BoltHole], wanted: float | None) -> tuple[int, list[BoltHole]]:
    """Cut plane seats for heads around those holes in a cap that have none; return the cap and all holes.

    The cap is used up. `wanted` is the radius of the seats, mm; None for the usual one, or less where the cap
    is narrow. Raises `GeometryError`: there is no material for a seat.
    """
    bare = [hole for hole in holes if hole.head is None]
    if not bare:
        return cap, list(holes)
    seats = [_cut_seat(cap, hole, wanted) for hole in bare]
    radius = min(outer for _, outer in seats)
    lowest = min(level for level, _ in seats)
    faced: dict[int, BoltHole] = {}
    tools: list[int] = []
    for hole, (level, _) in zip(bare, seats, strict=True):
        level = lowest if level - lowest < _ALIKE * hole.radius else level  # noqa: PLW2901
        head = Seat(level, hole.radius, radius, round=True)
        faced[id(hole)] = replace(hole, head=head, cap_end=level)
        height = 2 * (hole.cap_end - level) + 4 * radius
        tools.append(gmsh.model.occ.addCylinder(*hole.at(level), *(height * hole.direction), radius))
    with kernel.attempt("cut seats for the bolts' heads into the cap"):
        cap = kernel.cut(cap, tools)
        gmsh.model.occ.synchronize()
    return cap, [faced.get(id(hole), hole) for hole in holes]


def _cut_seat(cap: int, hole: BoltHole, wanted: float | None) -> tuple[float, float]:
    """Level and radius of a seat that can be cut around a hole, mm."""
    usual = np.arange(USUAL, _LEAST, -_STEP) * hole.radius
    radii = usual.tolist() if wanted is None else [wanted]
    for radius in radii:
        level = _level(cap, hole, radius)
        if level > _LOWEST * hole.cap_end:
            return level, radius
    raise GeometryError(
        f"the cap has no plane seat for the head of the bolt at {place_text(hole.center)}, and no material "
        f"around its hole of {2 * hole.radius:.4g} mm to cut one of {2 * radii[-1]:.4g} mm. Add a seat in "
        "the CAD program"
    )


def _level(cap: int, hole: BoltHole, radius: float) -> float:
    """Position below which a cylinder around the hole lies in the material, mm."""
    occ = gmsh.model.occ
    along = 1.1 * hole.cap_end * hole.direction
    core, inner = (occ.addCylinder(*hole.center, *along, r) for r in (radius, 1.01 * hole.radius))
    with kernel.attempt("look for a seat for a bolt's head on the cap"):
        tube, _ = occ.cut([(SOLID, core)], [(SOLID, inner)])
        void, _ = occ.cut(tube, [(SOLID, cap)], removeTool=False)
        occ.synchronize()
    # A round or a chamfer of the hole's edge at the joint is no end of the material.
    heights = [hole.along(solid_points(tag)) for dim, tag in void if dim == SOLID]
    occ.remove(void, recursive=True)
    occ.synchronize()
    ends = [float(height.min()) for height in heights if height.max() > _LOWEST * hole.cap_end]
    return min(ends, default=hole.cap_end) - _DEPTH * hole.radius
