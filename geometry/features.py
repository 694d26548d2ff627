"""Expected face areas of every feature: a fillet that the CAD kernel lost is found by its missing area."""

import math
from collections.abc import Mapping, Sequence

import gmsh
import numpy as np

from geometry.assembly import Assembly
from geometry.errors import GeometryError
from geometry.faces import Feature, FeatureKind
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


def check_areas(rod: Rod, mirror: Mirror, features: Sequence[Feature]) -> None:
    """Compare the faces of every feature with the areas that the dimensions give.

    Raises
    ------
    GeometryError
        Faces are missing, or their area is off by more than `TOLERANCE`.
    """
    drawn = dict.fromkeys(FeatureKind, 0.0)
    for feature in features:
        drawn[feature.kind] += sum(gmsh.model.occ.getMass(2, face) for face in feature.faces)
    for kind, expected in feature_areas(rod).items():
        found = drawn[kind] * mirror.copies
        if not abs(found - expected) <= TOLERANCE * expected:
            raise GeometryError(
                f"the CAD kernel drew {kind.replace('_', ' ')} faces of {found:.4g} mm², but the dimensions "
                f"give {expected:.4g} mm². Change the dimensions of this feature slightly"
            )


def feature_areas(rod: Rod) -> dict[FeatureKind, float]:
    """Return the area of every kind of feature on the whole rod, mm²; 0 where the rod has none."""
    field = HeightField(rod)
    big, small = field.outline.bores
    areas = {
        FeatureKind.BORE: _bore(big, rod.crank_bearing_width)
        + _bore(small, rod.pin_bearing_width)
        - math.pi * rod.oil_hole**2 / 4,
        FeatureKind.RING_FILLET: sum(_ring_fillet(field, arc) for arc in field.outline.fillets),
        FeatureKind.RING_STEP: sum(_ring_step(field, step) for step in field.steps),
    }
    if (bosses := field.outline.bosses) is not None:
        lengths = sum(arc.length for arc in bosses.fillets())
        areas[FeatureKind.BOSS_FILLET] = 2 * lengths * rod.big_end_width
    return areas | _pocket_areas(field.pocket)


def _bore(bore: Arc, width: float) -> float:
    return 2 * math.pi * bore.radius * width


def _ring_fillet(field: HeightField, arc: Arc) -> float:
    """Area of a fillet in plan, on both edges of the shank, up to the ring step that it crosses."""
    angle = arc.begin + _ALONG * arc.sweep
    x, y = arc.center[0] + arc.radius * np.cos(angle), arc.center[1] + arc.radius * np.sin(angle)
    return 4 * arc.length * float(field.face(x, y).mean())


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


def _pocket_areas(pocket: Pocket | None) -> dict[FeatureKind, float]:
    """Areas of corners, floor edges and web floors of the two pockets, by Steiner's formula."""
    if pocket is None:
        return dict.fromkeys((FeatureKind.POCKET_CORNER, FeatureKind.POCKET_FLOOR, FeatureKind.WEB), 0.0)
    outline, r = pocket.outline(), pocket.floor_radius
    perimeter = sum(piece.length for piece in outline)
    area = _enclosed(pocket)
    wall = 2 * math.pi * pocket.corner * (pocket.depth - r)
    # Offsetting a convex curve inwards by s leaves perimeter − 2πs: integrate over the quarter arc.
    floor_edge = r * (perimeter * math.pi / 2 - 2 * math.pi * r * (math.pi / 2 - 1))
    floor = area - perimeter * r + math.pi * r**2
    return {
        FeatureKind.POCKET_CORNER: 2 * wall,
        FeatureKind.POCKET_FLOOR: 2 * floor_edge,
        FeatureKind.WEB: 2 * floor,
    }


def _enclosed(pocket: Pocket) -> float:
    """Area of a pocket in plan: the trapezium of the corners' centres, grown by their radius."""
    (x0, y0), (x1, y1) = pocket.corner_centers()
    inner = (x1 - x0) * (y0 + y1)
    around = 2 * (y0 + y1 + math.dist((x0, y0), (x1, y1)))
    return inner + around * pocket.corner + math.pi * pocket.corner**2


# Places of a rule that is exact for periodic functions.
_ANGLES = 60


def check_contacts(
    rod: Rod,
    assembly: Assembly,
    mirror: Mirror,
    found: Sequence[Interface],
    named: Mapping[Surface, tuple[int, ...]],
) -> None:
    """Compare the faces between parts and under bolts with the areas that the dimensions give.

    Raises
    ------
    GeometryError
        Faces are missing, or their area is off by more than `geometry.features.TOLERANCE`.
    """
    drawn = {surface: [*named.get(surface, ())] for surface in (Surface.BOLT_HEAD, Surface.BOLT_THREAD)}
    for interface in found:
        drawn.setdefault(interface.sides[0], []).extend(interface.faces)
    for surface, expected in contact_areas(rod, assembly).items():
        area = mirror.copies * sum(gmsh.model.occ.getMass(2, face) for face in drawn.get(surface, []))
        if not abs(area - expected) <= TOLERANCE * expected:
            raise GeometryError(
                f"the CAD kernel drew {surface.replace('_', ' ')} faces of {area:.4g} mm², but the "
                f"dimensions give {expected:.4g} mm². Change the dimensions of this part slightly"
            )


def contact_areas(rod: Rod, assembly: Assembly) -> dict[Surface, float]:
    """Return the area of every interface and of the bolts' seats on the whole rod, mm²."""
    areas: dict[Surface, float] = {}
    if assembly.split is not None:
        areas[Surface.JOINT] = HeightField(rod).section(0.0).area  # a ring's is the same at every angle
    if assembly.bushing:
        areas[Surface.BUSHING_SEAT] = _bushing_seat(rod)
    if assembly.shell:
        radius = rod.big_end_bore / 2 + assembly.shell
        areas[Surface.SHELL_SEAT] = 2 * math.pi * radius * rod.big_end_width
    if (seat := assembly.bolt) is not None:
        areas[Surface.BOLT_HEAD] = _annuli(seat.head_diameter, rod.cap_bolt)
        wall = 2 * math.pi * rod.cap_bolt * seat.engaged
        areas[Surface.BOLT_THREAD] = wall or _annuli(seat.nut_diameter, rod.cap_bolt)
    return areas


def _annuli(outer: float, inner: float) -> float:
    """Area of two annuli with these diameters."""
    return math.pi / 2 * (outer**2 - inner**2)


def _bushing_seat(rod: Rod) -> float:
    """Area of the bushing's outer cylinder, whose ends may be slanted, less the oil hole."""
    mean = (rod.small_end_width + (rod.small_end_crown_width or rod.small_end_width)) / 2
    radius, hole = rod.small_end_bore / 2 + rod.bushing, rod.oil_hole / 2
    return 2 * math.pi * radius * mean - _window(radius, hole)


def _window(radius: float, hole: float) -> float:
    """Area that a hole across the axis of a cylinder cuts out of one side of it, mm²."""
    angle = (np.arange(_ANGLES) + 0.5) * math.pi / _ANGLES
    return (
        float(2 * math.pi * (hole * np.cos(angle)) ** 2 @ (1 - (hole / radius * np.sin(angle)) ** 2) ** -0.5)
        / _ANGLES
    )
