"""The slanted small end: side faces that lean inwards from the start of the ring to its crown."""

import numpy as np

from geometry.arrays import Floats
from geometry.dimensions import Dimensions
from geometry.segments import Line, Segment


def slanted_half_width(rod: Dimensions, x: Floats) -> Floats:
    """Return z of the slanted faces at `x`, mm; infinite where there are none."""
    begin, slope = _slope(rod)
    if slope == 0:
        return np.full_like(x, np.inf)
    return np.where(x < begin, np.inf, rod.small_end_width / 2 - slope * (x - begin))


def space_beside(rod: Dimensions) -> tuple[Segment, ...]:
    """Return the closed profile (x, z) of what the slant cuts off above z = 0; empty without a slant."""
    begin, slope = _slope(rod)
    if slope == 0:
        return ()
    beyond = rod.length + 1.5 * rod.small_end_radius
    top = rod.small_end_width / 2
    # It begins beyond the face's edge, so that it crosses the face at an angle.
    before = begin - 0.2 * rod.small_end_radius
    corners = [
        (before, top + slope * (begin - before)),
        (beyond, top - slope * (beyond - begin)),
        (beyond, 2 * top),
        (before, 2 * top),
    ]
    return tuple(Line(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))


def _slope(rod: Dimensions) -> tuple[float, float]:
    """Return where the slant begins and how much each face leans in, mm/mm."""
    begin = rod.length - rod.small_end_radius
    if rod.small_end_crown_width == 0:
        return begin, 0.0
    return begin, (rod.small_end_width - rod.small_end_crown_width) / (4 * rod.small_end_radius)
