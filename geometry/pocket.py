"""The web pockets of an I-section shank: a trapezium along the taper with rounded corners, in closed form."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from geometry.segments import Arc, Line, Point, Segment, mirrored
from geometry.step import ring_steps
from geometry.tangency import Edge

if TYPE_CHECKING:
    from geometry.rod import Rod


@dataclass(frozen=True)
class Pocket:
    """The pocket in one face, seen in plan.

    Attributes
    ----------
    big_end, small_end
        x of its two ends, mm.
    edge
        Its upper long side.
    corner
        Corner radius, mm.
    floor, face
        z of its floor and of the shank's face, mm.
    floor_radius
        Radius along the edge of the floor, mm.
    """

    big_end: float
    small_end: float
    edge: Edge
    corner: float
    floor: float
    face: float
    floor_radius: float

    @property
    def depth(self) -> float:
        """Depth below the shank's face, mm."""
        return self.face - self.floor

    @property
    def half_turns(self) -> tuple[float, float]:
        """Half the turning angles at the corners of the big and the small end, rad."""
        slope = math.atan2(self.edge.along[1], self.edge.along[0])
        return math.pi / 4 - slope / 2, math.pi / 4 + slope / 2

    @property
    def tangents(self) -> tuple[float, float]:
        """What the rounding takes from the sides at the corners of the big and the small end, mm."""
        big, small = self.half_turns
        return self.corner * math.tan(big), self.corner * math.tan(small)

    def corner_centers(self) -> tuple[Point, Point]:
        """Return the centres of the upper corners' arcs, big end first."""
        x0, x1 = self.big_end + self.corner, self.small_end - self.corner
        inner = self.edge.inset(self.corner)
        return (x0, inner.height(x0)), (x1, inner.height(x1))

    def corners(self) -> tuple[Arc, Arc]:
        """Return the upper corners' arcs, big end first, running towards +x."""
        big, small = self.corner_centers()
        up = math.atan2(self.edge.normal[1], self.edge.normal[0])
        return Arc(big, self.corner, math.pi, up - math.pi), Arc(small, self.corner, up, -up)

    def outline(self) -> tuple[Segment, ...]:
        """Return the closed outline, clockwise."""
        big, small = self.corners()
        upper: tuple[Segment, ...] = (big, Line(big.end, small.start), small)
        lower = mirrored(upper)
        return (*upper, Line(small.end, lower[0].start), *lower, Line(lower[-1].end, big.start))

    def inside(self, x: float, y: float) -> float:
        """Return the distance of a point from the outline, mm, positive inside."""
        (x0, y0), (x1, y1) = self.corner_centers()
        nx, ny = self.edge.normal
        y = abs(y)
        # Signed distance to the trapezium of the corner centres; the outline is its offset by the radius.
        sides = (x0 - x, x - x1, nx * (x - x0) + ny * (y - y0))
        if max(sides) <= 0:
            return self.corner - max(sides)
        beyond = min(max((x - x0) * ny - (y - y0) * nx, 0.0), math.dist((x0, y0), (x1, y1)))
        on_edge = (x0 + beyond * ny, y0 - beyond * nx)
        on_big, on_small = (x0, min(y, y0)), (x1, min(y, y1))
        return self.corner - min(math.dist((x, y), foot) for foot in (on_edge, on_big, on_small))

    def height(self, x: float, y: float) -> float:
        """Return z of the pocket's surface at a point of its plan, mm; the shank's face outside."""
        inside = self.inside(x, y)
        if inside <= 0:
            return self.face
        short = self.floor_radius - inside
        if short <= 0:
            return self.floor
        return self.floor + self.floor_radius - math.sqrt(self.floor_radius**2 - short**2)


def web_pocket(rod: "Rod", edge: Edge) -> Pocket:
    """Return the pocket of a rod whose shank has the upper edge `edge`."""
    big, small = ring_steps(rod)
    return Pocket(
        big_end=_end(big.foot, rod.big_end_radius, big.height) + rod.pocket_setback,
        small_end=rod.length - _end(small.foot, rod.small_end_radius, small.height) - rod.pocket_setback,
        edge=edge.inset(rod.flange_thickness),
        corner=rod.pocket_corner_radius,
        floor=rod.web_thickness / 2,
        face=rod.shank_width / 2,
        floor_radius=rod.pocket_floor_radius,
    )


def _end(foot: float, ring_radius: float, step: float) -> float:
    return foot if step > 0 else ring_radius
