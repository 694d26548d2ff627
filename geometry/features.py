"""The features of a rod that need small elements: their faces, and the areas that the dimensions give.

A face that the CAD kernel lost, or drew twice, shows in its area.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import partial
from typing import TypeVar

import gmsh
import numpy as np

from geometry.arrays import Floats
from geometry.assembly import Assembly
from geometry.errors import GeometryError
from geometry.faces import SLACK, Face, Feature, FeatureKind
from geometry.outline import Outline
from geometry.parts import Interface
from geometry.rod import Rod
from geometry.section import HeightField
from geometry.segments import Arc
from geometry.side_faces import Pocket, RingStep, slanted_half_width
from geometry.surfaces import Mirror, Surface

# Relative. The expected areas are sampled, because the integrands have kinks; a face that is missing or
# drawn twice is off by far more.
TOLERANCE = 0.01
_ALONG = (np.arange(2000) + 0.5) / 2000
_ACROSS = (np.arange(40) + 0.5) / 40
_ANGLES = 60  # places of a rule that is exact for periodic functions

_Name = TypeVar("_Name", bound=StrEnum)


@dataclass(frozen=True)
class _Expected:
    """Faces that the dimensions give, and their area on the whole rod, mm²; None: not compared."""

    kind: FeatureKind
    matches: Callable[..., bool]  #: of a face, with the ``slack`` of lengths, mm
    area: float | None = None
    radius: float = math.inf
    sweep: float = 0.0
    thickness: float = math.inf


def _cylinder(
    kind: FeatureKind, arc: Arc, area: float, sweep: float, thickness: float = math.inf
) -> _Expected:
    matches = partial(Face.about, x=arc.center[0], y=arc.center[1], radius=arc.radius)
    return _Expected(kind, matches, area, arc.radius, sweep, thickness)


def _expected(rod: Rod, turn: float = 0.0) -> Iterator[_Expected]:
    """Faces of each feature; bosses and bolts are turned about the big end's axis by `turn`, rad."""
    field = HeightField(rod)
    outline, full = field.outline, 2 * math.pi
    big, small = outline.bores
    drilled = _window(big.radius, max(rod.oil_gallery, rod.shank_bore) / 2)
    area = full * big.radius * rod.crank_bearing_width - drilled
    yield _cylinder(FeatureKind.BORE, big, area, full, rod.big_end_ring)
    drilled = _window(small.radius, rod.oil_gallery / 2)
    area = full * small.radius * rod.pin_bearing_width - math.pi * rod.oil_hole**2 / 4 - drilled
    yield _cylinder(FeatureKind.BORE, small, area, full, rod.bushing or rod.small_end_ring)
    for arc in outline.fillets:
        angles = arc.begin + _ALONG * arc.sweep
        x, y = arc.center[0] + arc.radius * np.cos(angles), arc.center[1] + arc.radius * np.sin(angles)
        area = 4 * arc.length * float((field.face(x, y) - field.void(x, y)).mean())
        yield _cylinder(FeatureKind.RING_FILLET, arc, area, abs(arc.sweep))
    holes = [(rod.cap_bolt, turn), *((hole, 0.0) for hole in (rod.oil_hole, rod.oil_gallery, rod.shank_bore))]
    for diameter, angle in holes:
        if diameter:
            matches = partial(Face.lengthwise, radius=diameter / 2, turn=angle)
            yield _Expected(FeatureKind.HOLE, matches, None, diameter / 2, full)
    if outline.bosses is not None:
        arcs = list(outline.bosses.fillets())
        if turn:
            arcs = [one.turned(turn) for arc in arcs for one in (arc, arc.mirrored())]
        for arc in arcs:
            area = 4 / len(arcs) * arc.length * rod.big_end_width
            yield _cylinder(FeatureKind.BOSS_FILLET, arc, area, abs(arc.sweep))
    for step in field.steps:
        matches = partial(Face.is_torus, x=step.center, major=step.foot, minor=step.radius)
        yield _Expected(FeatureKind.RING_STEP, matches, _ring_step(field, step), step.radius, step.sweep)
    if field.pocket is not None:
        yield from _of_pocket(field.pocket, field.outline, rod.web_thickness)


def _of_pocket(pocket: Pocket, outline: Outline, web: float) -> Iterator[_Expected]:
    """Corners, floor edges and web floors of the two pockets; areas by Steiner's formula."""
    r = pocket.floor_radius
    perimeter = sum(piece.length for piece in pocket.outline())
    for arc in pocket.corners():
        angles = arc.begin + _ALONG * arc.sweep
        side = outline.height(arc.center[0] + arc.radius * np.cos(angles))
        top = float(side.mean()) if pocket.in_sides else pocket.face
        area = 4 * arc.length * (top - pocket.floor - r)

        def is_corner(face: Face, slack: float, arc: Arc = arc) -> bool:
            return seen(face).about(*arc.center, arc.radius, slack)

        yield _Expected(FeatureKind.POCKET_CORNER, is_corner, area, arc.radius, abs(arc.sweep))

    def seen(face: Face) -> Face:
        return face.from_side() if pocket.in_sides else face

    def rounds_floor(face: Face, slack: float) -> bool:
        """Whether it is a cylinder or torus whose tube runs along the edge of a floor."""
        face = seen(face)
        if face.shape not in ("Cylinder", "Torus") or face.upright():
            return False
        off = abs(face.values[2]) - pocket.floor - r, face.values[-1] - r
        return pocket.big_end < face.values[0] < pocket.small_end and max(map(abs, off)) < slack

    def is_floor(face: Face, slack: float) -> bool:
        return seen(face).lies_at(2, pocket.floor, slack)

    # Offsetting a convex curve inwards by s leaves perimeter − 2πs: integrate over the quarter arc.
    area = 2 * r * (perimeter * math.pi / 2 - 2 * math.pi * r * (math.pi / 2 - 1))
    yield _Expected(FeatureKind.POCKET_FLOOR, rounds_floor, area, r, math.pi / 2)
    (x0, y0), (x1, y1) = pocket.corner_centers()
    inner = (x1 - x0) * (y0 + y1)
    around = 2 * (y0 + y1 + math.dist((x0, y0), (x1, y1)))
    enclosed = inner + around * pocket.corner + math.pi * pocket.corner**2
    area = 2 * (enclosed - perimeter * r + math.pi * r**2)
    yield _Expected(FeatureKind.WEB, is_floor, area, thickness=web)


def checked_features(
    rod: Rod, mirror: Mirror, faces: Sequence[Face], turn: float = 0.0
) -> tuple[Feature, ...]:
    """Find the faces that need small elements; kinds that the rod lacks are absent.

    Bosses and bolts are turned about the big end's axis by `turn`, rad. Raises `GeometryError`: faces are
    missing, or their area is off by more than `TOLERANCE`.
    """
    slack, every = SLACK * rod.length, list(_expected(rod, turn))
    matching = [tuple(face.tag for face in faces if one.matches(face, slack=slack)) for one in every]
    features = [
        Feature(one.kind, tags, one.radius, one.sweep, one.thickness)
        for one, tags in zip(every, matching, strict=True)
        if tags
    ]
    drawn: dict[FeatureKind, list[int]] = {}
    for feature in features:
        drawn.setdefault(feature.kind, []).extend(feature.faces)
    _compare(drawn, _by_kind(every), mirror, "feature")
    return tuple(features)


def feature_areas(rod: Rod) -> dict[FeatureKind, float]:
    """Return the area of every kind of feature on the whole rod, mm²."""
    return _by_kind(_expected(rod))


def _by_kind(every: Iterable[_Expected]) -> dict[FeatureKind, float]:
    areas: dict[FeatureKind, float] = {}
    for one in every:
        if one.area is not None:
            areas[one.kind] = areas.get(one.kind, 0.0) + one.area
    return areas


def _compare(
    drawn: Mapping[_Name, Iterable[int]], expected: Mapping[_Name, float], mirror: Mirror, what: str
) -> None:
    for name, given in expected.items():
        area = mirror.copies * sum(gmsh.model.occ.getMass(2, face) for face in drawn.get(name, ()))
        if not abs(area - given) <= TOLERANCE * given:
            raise GeometryError(
                f"the CAD kernel drew {name.replace('_', ' ')} faces of {area:.4g} mm², but the dimensions "
                f"give {given:.4g} mm². Change the dimensions of this {what} slightly"
            )


def _ring_step(field: HeightField, step: RingStep) -> float:
    """Area of the concave arc at the foot of a step within the outline, on both faces."""
    if step.height == 0:
        return 0.0
    side = 1 if step is field.steps[0] else -1
    azimuth, rise = np.meshgrid(_ALONG * math.pi / 2, _ACROSS * step.sweep)
    distance = step.foot - step.radius * np.sin(rise)
    x = step.center + side * distance * np.cos(azimuth)
    height = step.shank + step.radius * (1 - np.cos(rise))
    y = distance * np.sin(azimuth)
    within = (np.arctan2(y, x) < field.outline.shank_sector) & (y < field.outline.height(x))
    within &= height < slanted_half_width(field.rod, x)
    return 4 * step.radius * step.sweep * (math.pi / 2) * float((within * distance).mean())


def check_contacts(
    rod: Rod,
    assembly: Assembly,
    mirror: Mirror,
    interfaces: Sequence[Interface],
    named: Mapping[Surface, tuple[int, ...]],
) -> None:
    """Compare the faces between parts and under bolts with the areas that the dimensions give.

    Raises `GeometryError`: faces are missing, or their area is off by more than `TOLERANCE`.
    """
    drawn = {surface: [*named.get(surface, ())] for surface in (Surface.BOLT_HEAD, Surface.BOLT_THREAD)}
    for interface in interfaces:
        drawn.setdefault(interface.sides[0], []).extend(interface.faces)
    _compare(drawn, contact_areas(rod, assembly), mirror, "part")


def contact_areas(rod: Rod, assembly: Assembly) -> dict[Surface, float]:
    """Return the area of every interface and of the bolts' seats on the whole rod, mm²."""
    areas: dict[Surface, float] = {}
    if assembly.split is not None:
        areas[Surface.JOINT] = HeightField(rod).section(0.0).area  # a ring's is the same at every angle
    if assembly.bushing:
        radius = rod.small_end_bore / 2 + rod.bushing
        whole = 2 * math.pi * radius * rod.mean_small_end_width
        drilled = _window(radius, rod.oil_hole / 2) + _window(radius, rod.oil_gallery / 2)
        areas[Surface.BUSHING_SEAT] = whole - drilled
    if assembly.shell:
        radius = rod.big_end_bore / 2 + assembly.shell
        whole = 2 * math.pi * radius * rod.big_end_width
        areas[Surface.SHELL_SEAT] = whole - _window(radius, max(rod.oil_gallery, rod.shank_bore) / 2)
    if (seat := assembly.bolt) is not None:
        areas[Surface.BOLT_HEAD] = _annuli(seat.head_diameter, rod.cap_bolt)
        wall = 2 * math.pi * rod.cap_bolt * seat.engaged
        areas[Surface.BOLT_THREAD] = wall or _annuli(seat.nut_diameter, rod.cap_bolt)
    return areas


def _annuli(outer: float, inner: float) -> float:
    return math.pi / 2 * (outer**2 - inner**2)


def _window(radius: float, hole: float) -> float:
    """Area that a hole across the axis of a cylinder cuts out of one side of it, mm²."""
    angle: Floats = (np.arange(_ANGLES) + 0.5) * math.pi / _ANGLES
    depth = (1 - (hole / radius * np.sin(angle)) ** 2) ** -0.5
    return float(2 * math.pi * (hole * np.cos(angle)) ** 2 @ depth) / _ANGLES
