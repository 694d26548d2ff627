"""The outline of a rod in plan (rings, tapered shank, fillets) and its side faces: steps, pockets, slant."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import Floats
from geometry.dimensions import Dimensions
from geometry.segments import Arc, Line, Point, Segment, half_chord, mirrored
from geometry.steps import Rib, rib, ring_steps


@dataclass(frozen=True)
class Bosses:
    """The upper (y > 0) boss in plan."""

    half_length: float  #: from the plane x = 0 to either seat of bolt and nut, mm
    top: float  #: y of the outer face, mm
    fillet: float  #: radius between a seat and the ring, mm
    ring: float  #: outer radius of the ring, mm
    #: bolt_at, bolt_radius: y of the bolt's axis and radius of its hole, mm
    bolt_at: float
    bolt_radius: float
    width: float  #: half of it, along the pins, mm
    round: float  #: radius of its edges along the bolt, mm; 0 where they are sharp

    def half_width(self, y: Floats) -> Floats:
        """Return z of its faces at heights `y` up to its top, mm."""
        return self.width - self.round + half_chord(self.round, np.maximum(y - self.top + self.round, 0.0))

    @property
    def seat(self) -> float:
        """Least y of the plane seats, where the fillets begin, mm; 0 where they miss the ring."""
        reach, across = self.ring + self.fillet, self.half_length + self.fillet
        return math.sqrt(max(reach**2 - across**2, 0.0))

    def fillets(self) -> tuple[Arc, Arc]:
        """Return the fillets on the cap's and the shank's side, running towards +x."""
        x, y, origin = self.half_length + self.fillet, self.seat, (0.0, 0.0)
        return (
            Arc.towards((-x, y), self.fillet, origin, (math.inf, y), anticlockwise=True),
            Arc.towards((x, y), self.fillet, (-math.inf, y), origin, anticlockwise=True),
        )

    @property
    def from_middle(self) -> float:
        """Angle from the middle of the cap at which the boss's fillet begins, seen from the bore, rad."""
        x, y = self.fillets()[0].start
        return math.atan2(y, -x)

    def outline(self) -> tuple[Segment, ...]:
        """Return the pieces from ring to ring, over the boss."""
        cap, shank = self.fillets()
        corners = (-self.half_length, self.top), (self.half_length, self.top)
        return (cap, Line(cap.end, corners[0]), Line(*corners), Line(corners[1], shank.start), shank)


def bosses(rod: Dimensions) -> Bosses | None:
    """Return the bosses, which extend one bolt diameter beyond the bolt's axis; None without cap bolts."""
    if rod.cap_bolt == 0:
        return None
    at = rod.cap_bolt_spacing / 2
    return Bosses(
        half_length=rod.cap_boss_length / 2,
        top=at + rod.cap_bolt,
        fillet=rod.cap_boss_fillet,
        ring=rod.big_end_radius,
        bolt_at=at,
        bolt_radius=rod.cap_bolt / 2,
        width=rod.big_end_width / 2,
        round=rod.cap_boss_round,
    )


@dataclass(frozen=True)
class Edge:
    """The straight upper edge of the shank, normal · point = offset."""

    #: along, normal: unit vectors to the small end and outwards
    along: Point
    normal: Point
    offset: float  #: distance from the crank-pin centre, mm

    def inset(self, distance: float) -> "Edge":
        """Return the parallel edge `distance` mm inside."""
        return Edge(self.along, self.normal, self.offset - distance)

    def distance(self, point: Point) -> float:
        """Return how far the edge passes above a point, mm."""
        return self.offset - self.normal[0] * point[0] - self.normal[1] * point[1]

    def height(self, x: float) -> float:
        """Return y of the edge at `x`, mm."""
        return (self.offset - self.normal[0] * x) / self.normal[1]


def fillet_center(edge: Edge, ring: Point, ring_radius: float, radius: float, side: int) -> Point:
    """Find the centre of the arc that touches an edge, which cuts a ring, and from outside that ring.

    `side` is +1 for the corner on the small end's side of the ring, −1 for the other.
    """
    # The centre lies `radius` outside the edge and `ring_radius + radius` from the ring's centre.
    out = edge.distance(ring) + radius
    across = side * math.sqrt((ring_radius + radius) ** 2 - out**2)
    (u, v), (nx, ny) = edge.along, edge.normal
    return ring[0] + across * u + out * nx, ring[1] + across * v + out * ny


def foot(edge: Edge, point: Point) -> Point:
    """Return the point of the edge nearest to a point above it."""
    distance = -edge.distance(point)
    return point[0] - distance * edge.normal[0], point[1] - distance * edge.normal[1]


@dataclass(frozen=True)
class Outline:
    """The upper half (y ≥ 0) of the outline and of the bores of a rod, and its whole loop."""

    rod: Dimensions  #: its dimensions
    turn: float = 0.0  #: angle by which an oblique split turns the bosses about the big end's axis, rad

    @cached_property
    def edge(self) -> Edge:
        """The shank's upper edge; its depth is given where the axis meets each ring."""
        x0, y0 = self.rod.big_end_radius, self.rod.shank_depth_big_end / 2
        x1, y1 = self.rod.length - self.rod.small_end_radius, self.rod.shank_depth_small_end / 2
        span = math.hypot(x1 - x0, y1 - y0)
        along = ((x1 - x0) / span, (y1 - y0) / span)
        normal = (-along[1], along[0])
        return Edge(along, normal, normal[0] * x0 + normal[1] * y0)

    @cached_property
    def fillets(self) -> tuple[Arc, Arc]:
        """The fillets between shank and big-end and small-end ring, running towards +x."""
        rod, origin, pin = self.rod, (0.0, 0.0), (self.rod.length, 0.0)
        big = fillet_center(self.edge, origin, rod.big_end_radius, rod.big_end_fillet, +1)
        small = fillet_center(self.edge, pin, rod.small_end_radius, rod.small_end_fillet, -1)
        return (
            Arc.towards(big, rod.big_end_fillet, origin, foot(self.edge, big), anticlockwise=True),
            Arc.towards(small, rod.small_end_fillet, foot(self.edge, small), pin, anticlockwise=True),
        )

    @cached_property
    def bosses(self) -> Bosses | None:
        """The bosses of the cap bolts."""
        return bosses(self.rod)

    @cached_property
    def rib(self) -> Rib | None:
        """The rib over the back of the cap."""
        if self.bosses is None or not self.rod.cap_rib:
            return None
        return rib(self.rod, self.bosses.from_middle)

    @property
    def back(self) -> tuple[Arc, ...]:
        """The upper half of the rib's back, from (−, 0) to where it ends on the ring."""
        return () if self.rib is None else (self.rib.crown, self.rib.end)

    @cached_property
    def shank_sector(self) -> float:
        """Half the angle about the crank pin that holds the shank and no boss, rad; π without bosses."""
        if self.bosses is None:
            return math.pi
        boss, shank = self.bosses.fillets()[1].end, self.fillets[0].start
        return (math.atan2(boss[1], boss[0]) - abs(self.turn) + math.atan2(shank[1], shank[0])) / 2

    @cached_property
    def upper(self) -> tuple[Segment, ...]:
        """The outline from (−, 0) at the cap over the shank to (+, 0) at the crown."""
        rod, (big, small) = self.rod, self.fillets
        origin, pin = (0.0, 0.0), (rod.length, 0.0)
        left, right = (-math.inf, 0.0), (math.inf, 0.0)
        ring = Arc.towards(origin, rod.big_end_radius, left, big.center, anticlockwise=False)
        around: tuple[Segment, ...] = (ring,)
        if self.bosses is not None:
            cap, shank = self.bosses.fillets()
            left = left if self.rib is None else self.rib.end.center
            around = (
                *self.back,
                Arc.towards(origin, rod.big_end_radius, left, cap.center, anticlockwise=False),
                *self.bosses.outline(),
                Arc.towards(origin, rod.big_end_radius, shank.center, big.center, anticlockwise=False),
            )
        return (
            *around,
            big,
            Line(big.end, small.start),
            small,
            Arc.towards(pin, rod.small_end_radius, small.center, right, anticlockwise=False),
        )

    @cached_property
    def whole(self) -> tuple[Segment, ...]:
        """The closed outline, clockwise."""
        if self.bosses is None or not self.turn:
            return (*self.upper, *mirrored(self.upper))
        origin, ring, boss = (0.0, 0.0), self.rod.big_end_radius, self.bosses
        big, *shank = self.upper[-4:]
        above = tuple(piece.turned(self.turn) for piece in boss.outline())
        below = tuple(piece.turned(self.turn) for piece in mirrored(boss.outline()))
        rib = tuple(piece.turned(self.turn) for piece in (*mirrored(self.back), *self.back))

        def along_ring(first: Segment, last: Segment) -> Arc:
            return Arc.towards(origin, ring, first.end, last.start, anticlockwise=False)

        over, under = (big, *shank), mirrored((big, *shank))
        return (
            along_ring(below[-1], (*rib, above[0])[0]),
            *((*rib, along_ring(rib[-1], above[0])) if rib else ()),
            *above,
            along_ring(above[-1], big),
            *over,
            *under,
            along_ring(under[-1], below[0]),
            *below,
        )

    @cached_property
    def bores(self) -> tuple[Arc, Arc]:
        """Upper halves of the bores, big end first, running towards +x."""
        rod = self.rod
        return (
            Arc((0.0, 0.0), rod.big_end_bore / 2, math.pi, -math.pi),
            Arc((rod.length, 0.0), rod.small_end_bore / 2, math.pi, -math.pi),
        )

    def height(self, x: Floats) -> Floats:
        """Return the largest y of the outline at `x`, mm; 0 outside the rod."""
        highest = np.max([piece.height(x) for piece in self.upper], axis=0)
        return np.asarray(np.maximum(highest, 0.0))


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
    floor: float  #: z of its floor, mm
    floor_radius: float  #: radius along the edge of the floor, mm
    in_sides: bool = False  #: whether it is cut into the sides (±y), not into the faces (±z)

    @property
    def tangents(self) -> tuple[float, float]:
        """Lengths that rounding takes from the sides at the corners of the big and the small end, mm."""
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
    aside, steps = rod.has_side_pockets, ring_steps(rod)
    radii = rod.big_end_radius, rod.small_end_radius
    rims = zip(steps, radii, strict=True)
    big, small = (radius if aside or step.height <= 0 else step.foot for step, radius in rims)
    side = Edge((1.0, 0.0), (0.0, 1.0), rod.shank_width / 2) if aside else edge
    return Pocket(
        big_end=big + rod.pocket_setback,
        small_end=rod.length - small - rod.pocket_setback,
        edge=side.inset(rod.flange_thickness),
        corner=rod.pocket_corner_radius,
        floor=rod.web_thickness / 2,
        floor_radius=rod.pocket_floor_radius,
        in_sides=aside,
    )


def slant_half_width(rod: Dimensions, x: Floats) -> Floats:
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
