"""The rod's outline in plan (x–y): two rings, a tapered shank, fillets tangent to both; in closed form."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import Floats
from geometry.dimensions import Dimensions
from geometry.segments import Arc, Line, Point, Segment, mirrored


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

    def outline(self) -> tuple[Segment, ...]:
        """Return the pieces from ring to ring, over the boss."""
        cap, shank = self.fillets()
        corners = (-self.half_length, self.top), (self.half_length, self.top)
        return (
            cap,
            Line(cap.end, corners[0]),
            Line(*corners),
            Line(corners[1], shank.start),
            shank,
        )


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
    return (
        ring[0] + across * edge.along[0] + out * edge.normal[0],
        ring[1] + across * edge.along[1] + out * edge.normal[1],
    )


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
            around = (
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

        def along_ring(first: Segment, last: Segment) -> Arc:
            """Join the ends of two pieces that touch the ring."""
            return Arc.towards(origin, ring, first.end, last.start, anticlockwise=False)

        over, under = (big, *shank), mirrored((big, *shank))
        return (
            along_ring(below[-1], above[0]),
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
