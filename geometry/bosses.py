"""Bolt bosses of the big-end cap: lugs on both sides of the ring, drawn in one piece with rod and cap."""

import math
from dataclasses import dataclass

from geometry.dimensions import Dimensions
from geometry.segments import Arc, Line, Segment


@dataclass(frozen=True)
class Bosses:
    """The upper (y > 0) boss in plan.

    Attributes
    ----------
    half_length
        From the plane x = 0 to either seat of bolt and nut, mm.
    top
        y of the outer face, mm.
    fillet
        Radius between a seat and the ring, mm.
    ring
        Outer radius of the ring, mm.
    bolt_at, bolt_radius
        y of the bolt's axis and radius of its hole, mm.
    """

    half_length: float
    top: float
    fillet: float
    ring: float
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
