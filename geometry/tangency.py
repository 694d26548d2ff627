"""The straight edge of the shank, and arcs that blend it into a ring; in closed form."""

import math
from dataclasses import dataclass

from geometry.dimensions import Dimensions
from geometry.segments import Point


@dataclass(frozen=True)
class Edge:
    """The straight upper edge of the shank, normal · point = offset.

    Attributes
    ----------
    along, normal
        Unit vectors to the small end and outwards.
    offset
        Distance from the crank-pin centre, mm.
    """

    along: Point
    normal: Point
    offset: float

    def inset(self, distance: float) -> "Edge":
        """Return the parallel edge `distance` mm inside."""
        return Edge(self.along, self.normal, self.offset - distance)

    def distance(self, point: Point) -> float:
        """Return how far the edge passes above a point, mm."""
        return self.offset - self.normal[0] * point[0] - self.normal[1] * point[1]

    def height(self, x: float) -> float:
        """Return y of the edge at `x`, mm."""
        return (self.offset - self.normal[0] * x) / self.normal[1]


def shank_edge(rod: Dimensions) -> Edge:
    """Return the upper edge of the shank, whose depth is given where the axis meets each ring."""
    x0, y0 = rod.big_end_radius, rod.shank_depth_big_end / 2
    x1, y1 = rod.length - rod.small_end_radius, rod.shank_depth_small_end / 2
    span = math.hypot(x1 - x0, y1 - y0)
    along = ((x1 - x0) / span, (y1 - y0) / span)
    normal = (-along[1], along[0])
    return Edge(along, normal, normal[0] * x0 + normal[1] * y0)


def fillet_center(edge: Edge, ring: Point, ring_radius: float, radius: float, side: int) -> Point:
    """Find the centre of the arc that is tangent to an edge and, from outside, to a ring.

    Parameters
    ----------
    edge
        It must cut the ring: ``edge.distance(ring) < ring_radius``.
    ring, ring_radius
        Centre and outer radius of the ring, mm.
    radius
        Of the arc, mm.
    side
        +1 for the corner on the small end's side of the ring, −1 for the other.
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
