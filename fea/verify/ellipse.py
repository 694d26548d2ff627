"""The outline of LE1 and LE10: a quarter between two ellipses about the origin."""

import math

from geometry.bodies import Side
from geometry.segments import EllipticArc, Line
from geometry.surfaces import Surface

INNER_AXES = (2000.0, 1000.0)  # mm
OUTER_AXES = (3250.0, 2750.0)


def elliptic_outline() -> tuple[Side, ...]:
    """Sides on y = 0, outside, on x = 0, inside."""
    (a, b), (c, d) = INNER_AXES, OUTER_AXES
    quarter = math.pi / 2
    return (
        Side(Line((a, 0.0), (c, 0.0)), Surface.SYMMETRY_Y),
        Side(EllipticArc(OUTER_AXES, 0.0, quarter), Surface.OUTER),
        Side(Line((0.0, d), (0.0, b)), Surface.SYMMETRY_X),
        Side(EllipticArc(INNER_AXES, quarter, 0.0), Surface.INNER),
    )
