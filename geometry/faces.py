"""What each face of a drawn rod is, identified by its shape and position and never by its number."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import gmsh

from geometry.outline import Outline
from geometry.rod import Rod
from geometry.segments import Arc
from geometry.side_faces import Pocket, ring_steps, web_pocket
from geometry.surfaces import PLANE_AXIS, Mirror, Surface

_SLACK = 1e-6  # of the rod's length


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
    """Faces of one kind, and the measures from which their element size follows.

    Attributes
    ----------
    kind
        What it is.
    faces
        gmsh's face tags.
    radius
        Of the arc, mm; infinite where the faces are plane.
    sweep
        Angle of the arc, rad; 0 where the faces are plane.
    thickness
        Of the material behind the faces (ring at a bore, whole web, bushing or shell) or across them (ring
        at the joint), mm; infinite if it is not thin.
    """

    kind: FeatureKind
    faces: tuple[int, ...]
    radius: float = math.inf
    sweep: float = 0.0
    thickness: float = math.inf

    @property
    def arc_length(self) -> float:
        """Length across the arc, mm."""
        return self.radius * self.sweep if self.sweep else math.inf


@dataclass(frozen=True)
class Face:
    """One face: its gmsh tag, kind of surface, bounding box and the numbers that describe it.

    Attributes
    ----------
    shape
        gmsh's name: ``"Plane"``, ``"Cylinder"``, ``"Torus"``, …
    low, high
        Corners of the bounding box, mm (a little loose, as the kernel gives it).
    values
        Cylinder: axis point (3), direction (3), radius. Torus: centre (3), axis (3), major, minor radius.
    fitted
        Whether the cylinder is fitted to a surface of another kind, with parameters of its own.
    """

    tag: int
    shape: str
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    values: tuple[float, ...]
    fitted: bool = False

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
        cx, cy, found = self.values[0], abs(self.values[1]), self.values[6]
        return max(abs(cx - x), abs(cy - abs(y)), abs(found - radius)) < slack


def faces_of(volumes: Sequence[int]) -> tuple[Face, ...]:
    """Describe the outer faces of volumes of the current model."""
    boundary = gmsh.model.getBoundary([(3, tag) for tag in volumes], combined=True, oriented=False)
    return tuple(face_of(tag) for _, tag in boundary)


@dataclass(frozen=True)
class Bore:
    """A bore about a z-parallel axis through (x, 0).

    Attributes
    ----------
    x, radius
        mm.
    width
        Mean length along the axis, mm.
    taper
        The length at the angle φ from +x is width + taper cos φ, mm.
    slack
        By how much axes and radii of its faces may differ from these, mm.
    """

    x: float
    radius: float
    width: float
    taper: float = 0.0
    slack: float = 0.0


def surfaces(
    bores: tuple[Bore, Bore], mirror: Mirror, faces: Sequence[Face]
) -> dict[Surface, tuple[int, ...]]:
    """Sort faces into the named surfaces; each face belongs to exactly one.

    Parameters
    ----------
    bores
        Of the big and the small end.
    """
    slack = _SLACK * bores[1].x
    names = (Surface.BIG_END_BORE, Surface.SMALL_END_BORE)
    places = {
        name: (bore.x, 0.0, bore.radius, max(slack, bore.slack))
        for name, bore in zip(names, bores, strict=True)
    }

    def surface(face: Face) -> Surface:
        for plane in mirror.planes:
            axis = PLANE_AXIS[plane]
            if face.shape == "Plane" and max(abs(face.low[axis]), abs(face.high[axis])) < slack:
                return plane
        return next((name for name, place in places.items() if face.about(*place)), Surface.FREE)

    found: dict[Surface, tuple[int, ...]] = {}
    for face in faces:
        name = surface(face)
        found[name] = (*found.get(name, ()), face.tag)
    return found


def features(rod: Rod, faces: Sequence[Face], turn: float = 0.0) -> tuple[Feature, ...]:
    """Find the faces that need small elements; kinds that the rod lacks are absent.

    Bosses and bolts are turned about the big end's axis by `turn`, rad.
    """
    slack = _SLACK * rod.length
    outline = Outline(rod)

    def cylinders(kind: FeatureKind, arc: Arc, sweep: float, thickness: float = math.inf) -> Feature:
        tags = tuple(face.tag for face in faces if face.about(*arc.center, arc.radius, slack))
        return Feature(kind, tags, arc.radius, sweep, thickness)

    found = [
        cylinders(FeatureKind.BORE, outline.bores[0], 2 * math.pi, rod.big_end_ring),
        cylinders(FeatureKind.BORE, outline.bores[1], 2 * math.pi, rod.bushing or rod.small_end_ring),
        *(cylinders(FeatureKind.RING_FILLET, arc, abs(arc.sweep)) for arc in outline.fillets),
    ]
    for diameter, angle in ((rod.cap_bolt, turn), (rod.oil_hole, 0.0)):
        if diameter:
            tags = tuple(face.tag for face in faces if face.lengthwise(diameter / 2, slack, angle))
            found.append(Feature(FeatureKind.HOLE, tags, diameter / 2, 2 * math.pi))
    if outline.bosses is not None:
        arcs = list(outline.bosses.fillets())
        if turn:
            arcs = [one.turned(turn) for arc in arcs for one in (arc, arc.mirrored())]
        found += [cylinders(FeatureKind.BOSS_FILLET, arc, abs(arc.sweep)) for arc in arcs]
    for step in ring_steps(rod):
        tags = tuple(face.tag for face in faces if _torus(face, step.center, step.foot, step.radius, slack))
        found.append(Feature(FeatureKind.RING_STEP, tags, step.radius, step.sweep))
    if rod.has_pockets:
        pocket = web_pocket(rod, outline.edge)
        found += [cylinders(FeatureKind.POCKET_CORNER, arc, abs(arc.sweep)) for arc in pocket.corners()]
        floor = tuple(face.tag for face in faces if _rounds_floor(face, pocket, slack))
        found.append(Feature(FeatureKind.POCKET_FLOOR, floor, pocket.floor_radius, math.pi / 2))
        web = tuple(face.tag for face in faces if _lies_at(face, pocket.floor, slack))
        found.append(Feature(FeatureKind.WEB, web, thickness=rod.web_thickness))
    return tuple(feature for feature in found if feature.faces)


def face_of(tag: int) -> Face:
    """Describe a face of the current model."""
    x0, y0, z0, x1, y1, z1 = gmsh.model.getBoundingBox(2, tag)
    _, values = gmsh.model.getEntityProperties(2, tag)
    return Face(tag, gmsh.model.getType(2, tag), (x0, y0, z0), (x1, y1, z1), tuple(map(float, values)))


def _torus(face: Face, x: float, major: float, minor: float, slack: float) -> bool:
    if face.shape != "Torus":
        return False
    return max(abs(face.values[0] - x), abs(face.values[6] - major), abs(face.values[7] - minor)) < slack


def _lies_at(face: Face, z: float, slack: float) -> bool:
    return face.shape == "Plane" and max(abs(abs(face.low[2]) - z), abs(abs(face.high[2]) - z)) < slack


def _rounds_floor(face: Face, pocket: Pocket, slack: float) -> bool:
    """Whether a face is a cylinder or torus whose tube runs along the edge of a pocket's floor."""
    if face.shape not in ("Cylinder", "Torus") or face.upright():
        return False
    x, z, radius = face.values[0], abs(face.values[2]), face.values[-1]
    along = pocket.big_end < x < pocket.small_end
    level = max(abs(z - pocket.floor - pocket.floor_radius), abs(radius - pocket.floor_radius))
    return along and level < slack
