"""The faces of a solid: their shapes, points on them, and the named surfaces that they belong to."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import gmsh
import numpy as np

from geometry.arrays import Floats
from geometry.surfaces import PLANE_AXIS, Mirror, Surface

SLACK = 1e-6  # of the rod's length


class FeatureKind(StrEnum):
    """A feature that needs small elements."""

    BORE = "bore"
    HOLE = "hole"  # for a bolt or for oil, along x
    RING_FILLET = "ring_fillet"  # in plan, between a ring and the shank's edge
    BOSS_FILLET = "boss_fillet"  # in plan, between a cap bolt's boss and the ring
    RING_STEP = "ring_step"  # at the foot of the step from ring to shank
    POCKET_CORNER = "pocket_corner"
    POCKET_FLOOR = "pocket_floor"  # the rounded edge of the floor
    WEB = "web"
    ROUND = "round"  # a concave radius of an imported solid
    JOINT = "joint"  # between rod and cap
    FIT = "fit"  # around a bushing, or the shells
    BOLT_SEAT = "bolt_seat"  # under a head or a nut, or the wall of a thread


@dataclass(frozen=True)
class Feature:
    """Faces of one kind, and the measures from which their element size follows."""

    kind: FeatureKind  #: what it is
    faces: tuple[int, ...]  #: gmsh's face tags
    radius: float = math.inf  #: of the arc, mm; infinite where the faces are plane
    sweep: float = 0.0  #: angle of the arc, rad; 0 where the faces are plane
    #: Of the material behind the faces (ring at a bore, whole web, bushing or shell) or across them (ring at
    #: the joint), mm; infinite if it is not thin
    thickness: float = math.inf

    @property
    def arc_length(self) -> float:
        """Length across the arc, mm."""
        return self.radius * self.sweep if self.sweep else math.inf


@dataclass(frozen=True)
class Face:
    """One face: its gmsh tag, kind of surface, bounding box and the numbers that describe it."""

    tag: int
    shape: str  #: gmsh's name: ``"Plane"``, ``"Cylinder"``, ``"Torus"``, …
    #: low, high: corners of the bounding box, mm (a little loose, as the kernel gives it)
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    #: Cylinder: axis point (3), direction (3), radius. Torus: centre (3), axis (3), major, minor radius.
    values: tuple[float, ...]
    #: Whether the cylinder is fitted to a surface of another kind, with parameters of its own
    fitted: bool = False

    def from_side(self) -> "Face":
        """Return it as seen from the side: y and z change places."""

        def turned(point: tuple[float, ...]) -> tuple[float, float, float]:
            x, y, z = point
            return x, z, y

        values = self.values
        if len(values) > 6:
            values = (*turned(values[:3]), *turned(values[3:6]), *values[6:])
        return replace(self, low=turned(self.low), high=turned(self.high), values=values)

    def upright(self, tilt: float = 0.0) -> bool:
        """Whether it is a cylinder about an axis parallel to z, but for a tilt, rad."""
        return self.shape == "Cylinder" and abs(self.values[5]) > 1 - 1e-9 - tilt**2

    def lengthwise(self, radius: float, slack: float, turn: float = 0.0) -> bool:
        """Whether it is a cylinder of this radius along x, turned about z by an angle, rad."""
        if self.shape != "Cylinder":
            return False
        along = abs(self.values[3] * math.cos(turn) + self.values[4] * math.sin(turn)) > 1 - 1e-9
        return along and abs(self.values[6] - radius) < slack

    def about(self, x: float, y: float, radius: float, slack: float) -> bool:
        """Whether it is a cylinder about the z-parallel axis through (x, ±y)."""
        if not self.upright(slack / radius):
            return False
        off = self.values[0] - x, abs(self.values[1]) - abs(y), self.values[6] - radius
        return max(map(abs, off)) < slack

    def is_torus(self, x: float, major: float, minor: float, slack: float) -> bool:
        """Whether it is a torus with its centre at x and these radii."""
        if self.shape != "Torus":
            return False
        off = self.values[0] - x, self.values[6] - major, self.values[7] - minor
        return max(map(abs, off)) < slack

    def rounds(self, between: tuple[float, float], level: float, radius: float, slack: float) -> bool:
        """Whether it rounds an edge: its axis lies at z = ±level, and between two x."""
        if self.shape not in ("Cylinder", "Torus") or self.upright():
            return False
        off = abs(self.values[2]) - level, self.values[-1] - radius
        return between[0] < self.values[0] < between[1] and max(map(abs, off)) < slack

    def lies_at(self, axis: int, level: float, slack: float) -> bool:
        """Whether it is a plane at ±`level` along a coordinate axis."""
        ends = self.low[axis], self.high[axis]
        return self.shape == "Plane" and max(abs(abs(end) - level) for end in ends) < slack


def faces_of(volumes: Sequence[int]) -> tuple[Face, ...]:
    """Describe the outer faces of volumes of the current model."""
    boundary = gmsh.model.getBoundary([(3, tag) for tag in volumes], combined=True, oriented=False)
    return tuple(face_of(tag) for _, tag in boundary)


@dataclass(frozen=True)
class Bore:
    """A bore about a z-parallel axis through (x, 0)."""

    #: x, radius: mm
    x: float
    radius: float
    width: float  #: mean length along the axis, mm
    taper: float = 0.0  #: the length at the angle φ from +x is width + taper cos φ, mm
    slack: float = 0.0  #: by how much axes and radii of its faces may differ from these, mm


def surfaces(
    bores: tuple[Bore, Bore], mirror: Mirror, faces: Sequence[Face]
) -> dict[Surface, tuple[int, ...]]:
    """Sort faces into the named surfaces, by the bores of big and small end; each belongs to exactly one."""
    slack = SLACK * bores[1].x
    by_name = {Surface.BIG_END_BORE: bores[0], Surface.SMALL_END_BORE: bores[1]}

    def surface(face: Face) -> Surface:
        for plane in mirror.planes:
            if face.lies_at(PLANE_AXIS[plane], 0.0, slack):
                return plane
        for name, bore in by_name.items():
            if face.about(bore.x, 0.0, bore.radius, max(slack, bore.slack)):
                return name
        return Surface.FREE

    named: dict[Surface, tuple[int, ...]] = {}
    for face in faces:
        name = surface(face)
        named[name] = (*named.get(name, ()), face.tag)
    return named


def face_of(tag: int) -> Face:
    """Describe a face of the current model."""
    x0, y0, z0, x1, y1, z1 = gmsh.model.getBoundingBox(2, tag)
    _, values = gmsh.model.getEntityProperties(2, tag)
    return Face(tag, gmsh.model.getType(2, tag), (x0, y0, z0), (x1, y1, z1), tuple(map(float, values)))


# Places along each edge.
_PLACES = np.linspace(0.0, 1.0, 9)


def edge_points(face: int) -> Floats:
    """Points (n, 3) along the edges of a face."""
    return _along(gmsh.model.getBoundary([(2, face)], combined=False, oriented=False))


def loop_points(curves: Iterable[int], count: int = _PLACES.size - 1) -> Floats:
    """Points (n, 3) along curves that form a closed loop, `count` on each, where one begins only once."""
    return _along([(1, int(curve)) for curve in curves], np.linspace(0.0, 1.0, count + 1)[:-1])


def solid_points(volume: int, places: Floats = _PLACES) -> Floats:
    """Points (n, 3) at shares of each edge of a solid."""
    faces = gmsh.model.getBoundary([(3, volume)], combined=False, oriented=False)
    return _along(sorted(set(gmsh.model.getBoundary(faces, combined=False, oriented=False))), places)


def _along(edges: list[tuple[int, int]], places: Floats = _PLACES) -> Floats:
    points = []
    for _, edge in edges:
        (low,), (high,) = gmsh.model.getParametrizationBounds(1, edge)
        points.append(gmsh.model.getValue(1, edge, low + (high - low) * places))
    return np.reshape(np.concatenate(points), (-1, 3)) if points else np.zeros((0, 3))


def parameter_grid(face: int, shares: Floats) -> Floats:
    """Parameters (n, n, 2) of a face at shares (n,) of the range of each."""
    low, high = gmsh.model.getParametrizationBounds(2, face)
    u, v = (a + (b - a) * shares for a, b in zip(low, high, strict=True))
    return np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1)


def face_middle(face: int) -> tuple[Floats, Floats]:
    """Point (3,) and unit normal (3,) of a face at the middle of its parameters."""
    middle = parameter_grid(face, np.array([0.5])).ravel()
    normal = np.array(gmsh.model.getNormal(face, middle))
    return np.array(gmsh.model.getValue(2, face, middle)), normal / np.linalg.norm(normal)
