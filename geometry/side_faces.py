"""Steps from the rings' faces down to the narrower shank, the pockets of the shank, and the slant."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geometry.arrays import Floats
from geometry.dimensions import Dimensions
from geometry.outline import Edge
from geometry.segments import Arc, Line, Point, Segment, half_chord, mirrored

# The step begins outside the ring, by this fraction of its outer radius, so that it crosses the outline at
# an angle; at the ring itself it would touch the outline tangentially.
LAND = 0.06


@dataclass(frozen=True)
class RingStep:
    """A ring's side face and the step at its rim, as half-width z over the distance from the bore's axis."""

    center: float  #: x of the bore's axis, mm
    rim: float  #: distance at which the ring's face ends, mm
    foot: float  #: distance from which on the shank's face is flat, mm; equals `rim` where there is no step
    #: ring, shank: half-widths of ring and shank, mm
    ring: float
    shank: float
    radius: float  #: of the concave arc at the foot, mm

    @property
    def height(self) -> float:
        """Height of the step, mm."""
        return self.ring - self.shank

    @property
    def sweep(self) -> float:
        """Angle of the concave arc, rad."""
        return math.acos(1 - min(self.height / self.radius, 1.0)) if self.height else 0.0

    def half_width(self, distance: Floats) -> Floats:
        """Return z of the faces at distances from the bore's axis, mm."""
        short = np.clip(self.foot - distance, 0.0, self.radius)
        flank = self.shank + self.radius - half_chord(self.radius, short)
        return np.where(distance <= self.rim, self.ring, flank)

    def space_above(self, top: float, far: float) -> tuple[Segment, ...]:
        """Closed profile (distance, z) of what lies above these faces, up to `top` and out to `far`, mm."""
        ceiling = 1.1 * max(top, self.shank + self.radius)
        beyond, roof = (far, self.shank), (far, ceiling)
        center, quarter = (self.foot, self.shank + self.radius), math.pi / 2
        if self.height == 0:
            return _chain([(0.0, self.shank), beyond, roof, (0.0, ceiling), (0.0, self.shank)])
        if self.ring < top:  # the ring's own face is part of it
            arc = Arc(center, self.radius, -quarter - self.sweep, self.sweep)
            wall = [(self.rim, self.ring)] if self.height > self.radius else []
            axis = [(0.0, ceiling), (0.0, self.ring)]
            return (arc, *_chain([arc.end, beyond, roof, *axis, *wall, arc.start]))
        # The arc goes on above the ring's face to the vertical: it then crosses that face cleanly.
        arc = Arc(center, self.radius, -2 * quarter, quarter)
        return (arc, *_chain([arc.end, beyond, roof, (arc.start[0], ceiling), arc.start]))


def ring_steps(rod: Dimensions) -> tuple[RingStep, RingStep]:
    """Return the steps of big and small end."""
    return (
        _step(0.0, rod.big_end_radius, rod.big_end_width / 2, rod),
        _step(rod.length, rod.small_end_radius, rod.small_end_width / 2, rod),
    )


def _step(center: float, ring_radius: float, ring: float, rod: Dimensions) -> RingStep:
    shank = rod.shank_width / 2
    height = ring - shank
    # A wall lower than a twentieth of the radius would be a sliver: the arc then takes the whole step.
    radius = rod.ring_step_radius
    radius = height if radius < height < 1.05 * radius else radius
    rim = (1 + LAND) * ring_radius
    rise = min(height, radius)
    reach = math.sqrt(radius**2 - (radius - rise) ** 2)
    return RingStep(center, rim, rim + reach, ring, shank, radius)


def _chain(points: list[Point]) -> tuple[Line, ...]:
    return tuple(Line(a, b) for a, b in pairwise(points))


@dataclass(frozen=True)
class Pocket:
    """The pocket in one face or one side of the shank, and its image in the opposite one.

    It is described as seen from outside: y is measured across the rod, z from the middle to the floor. For
    one in the sides, y and z of the rod change places.
    """

    #: big_end, small_end: x of its two ends, mm
    big_end: float
    small_end: float
    edge: Edge  #: its upper long side
    corner: float  #: corner radius, mm
    #: floor, face: z of its floor and of the shank's face (or, of a side, where it is nearest), mm
    floor: float
    face: float
    floor_radius: float  #: radius along the edge of the floor, mm
    in_sides: bool = False  #: whether it is cut into the sides (±y), not into the faces (±z)

    @property
    def tangents(self) -> tuple[float, float]:
        """What the rounding takes from the sides at the corners of the big and the small end, mm."""
        slope = math.atan2(self.edge.along[1], self.edge.along[0])
        big, small = math.pi / 4 - slope / 2, math.pi / 4 + slope / 2
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

    def upper_side(self, x: Floats, inset: float | Floats = 0.0) -> Floats:
        """Return y of the outline, moved inwards by `inset` ≤ `corner`, at `x`; 0 beyond its ends."""
        (x0, y0), (x1, y1) = self.corner_centers()
        radius = self.corner - inset
        nx = self.edge.normal[0]

        def arc(center: float, height: float) -> Floats:
            return height + half_chord(radius, x - center)

        straight = (self.edge.offset - inset - nx * x) / self.edge.normal[1]
        y = np.where(x < x0 + radius * nx, arc(x0, y0), np.where(x > x1 + radius * nx, arc(x1, y1), straight))
        return np.where((x >= x0 - radius) & (x <= x1 + radius), y, 0.0)

    def half_height(self, x: Floats, z: Floats) -> Floats:
        """Return how far the pocket reaches from the rod's middle at depths `z`, mm; 0 outside it."""
        rise = np.clip(z - self.floor, 0.0, self.floor_radius)
        inset = self.floor_radius - half_chord(self.floor_radius, self.floor_radius - rise)
        return np.where(z > self.floor, self.upper_side(x, inset), 0.0)

    def floor_begins(self, x: Floats) -> Floats:
        """Return the least z of the pocket at `x`, mm: that of its floor but near its ends."""
        within = np.minimum(x - self.big_end, self.small_end - x)
        short = self.floor_radius - np.clip(within, 0.0, self.floor_radius)
        return self.floor + self.floor_radius - half_chord(self.floor_radius, short)

    def inside(self, x: Floats, y: Floats) -> Floats:
        """Return how far points lie inside the outline, mm; `corner` and more count as `corner`."""
        (x0, y0), (x1, y1) = self.corner_centers()
        nx, ny = self.edge.normal
        y = np.abs(y)
        # The outline is the offset, by the corner radius, of the trapezium of the corners' centres.
        share = np.clip((x - x0) * ny - (y - y0) * nx, 0.0, math.dist((x0, y0), (x1, y1)))
        above = np.hypot(x - x0 - share * ny, y - y0 + share * nx)
        big = np.hypot(x - x0, y - np.minimum(y, y0))
        small = np.hypot(x - x1, y - np.minimum(y, y1))
        within = (x >= x0) & (x <= x1) & (nx * (x - x0) + ny * (y - y0) <= 0)
        return self.corner - np.where(within, 0.0, np.minimum(above, np.minimum(big, small)))

    def half_width(self, x: Floats, y: Floats) -> Floats:
        """Return z of the pocket's surface at points of the plan, mm; infinite outside it."""
        inside = self.inside(x, y)
        short = np.clip(self.floor_radius - inside, 0.0, self.floor_radius)
        z = self.floor + self.floor_radius - half_chord(self.floor_radius, short)
        return np.where(inside > 0, z, np.inf)


def web_pocket(rod: Dimensions, edge: Edge) -> Pocket:
    """Return the pocket of a rod whose shank has the upper edge `edge`."""
    if rod.has_side_pockets:
        return Pocket(
            big_end=rod.big_end_radius + rod.pocket_setback,
            small_end=rod.length - rod.small_end_radius - rod.pocket_setback,
            edge=Edge((1.0, 0.0), (0.0, 1.0), rod.shank_width / 2 - rod.flange_thickness),
            corner=rod.pocket_corner_radius,
            floor=rod.web_thickness / 2,
            face=rod.least_depth / 2,
            floor_radius=rod.pocket_floor_radius,
            in_sides=True,
        )
    big, small = ring_steps(rod)
    return Pocket(
        big_end=(big.foot if big.height > 0 else rod.big_end_radius) + rod.pocket_setback,
        small_end=rod.length
        - (small.foot if small.height > 0 else rod.small_end_radius)
        - rod.pocket_setback,
        edge=edge.inset(rod.flange_thickness),
        corner=rod.pocket_corner_radius,
        floor=rod.web_thickness / 2,
        face=rod.shank_width / 2,
        floor_radius=rod.pocket_floor_radius,
    )


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
