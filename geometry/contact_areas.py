"""Expected areas of the faces where parts touch and bolts press, which tell a face that the kernel lost."""

import math
from collections.abc import Mapping, Sequence

import gmsh
import numpy as np

from geometry.areas import TOLERANCE
from geometry.assembly import Assembly
from geometry.contacts import Interface
from geometry.errors import GeometryError
from geometry.mirror import Mirror
from geometry.rod import Rod
from geometry.section import HeightField
from geometry.surfaces import Surface

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
        Faces are missing, or their area is off by more than `geometry.areas.TOLERANCE`.
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
