"""Ribs over the back of the cap, in the arc between the bosses of its bolts."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geometry.arrays import Floats
from geometry.dimensions import Dimensions
from geometry.segments import Arc, Line, Segment, half_chord
from geometry.steps import RingStep

# Angle of bare ring between the end of a rib and the fillet of a boss, rad.
_BARE = 0.05
# A rib's side begins outside the ring by this part of its radius, so that it crosses the outline at an angle.
_LAND = 0.02
# Radius at the foot of a rib over its height, and least height over the ring's radius to have a side.
_FOOT, LEAST = 0.7, 0.08


@dataclass(frozen=True)
class Rib:
    """A rib, highest in the middle of the cap, from where it falls to the ring; with a groove it is two."""

    #: crown, end: upper halves of its back and of the concave arc in which it ends, running towards +x
    crown: Arc
    end: Arc
    side: RingStep  #: from the ring's faces to those of the rib; no height where the rib is as wide
    groove: float  #: half-width of the groove between two ribs, mm; 0 for one rib
    sector: float  #: half the angle about the crank pin that holds the rib and no boss, rad

    @property
    def rings(self) -> tuple[float, float]:
        """Distances from the crank pin at which the concave arcs beside ribs begin and end, mm."""
        return self.side.rim, self.side.rim + self.side.radius

    def groove_depth(self, distance: Floats) -> Floats:
        """Return z up to which the groove leaves the rib hollow at distances from the crank pin, mm."""
        radius = self.side.radius
        short = np.clip(radius - (distance - self.side.rim), 0.0, radius)
        wall = self.groove - radius + half_chord(radius, short)
        return np.where(distance > self.side.rim, wall if self.groove else 0.0, 0.0)

    def groove_profile(self, far: float) -> tuple[Segment, ...]:
        """Closed profile (distance, z) of the groove, out to `far`, mm."""
        radius, half = self.side.radius, self.groove
        upper = Arc((self.rings[1], half - radius), radius, math.pi, -math.pi / 2)
        lower, far_up, far_down = upper.mirrored(), (far, half), (far, -half)
        corners = [upper.end, far_up, far_down, lower.start]
        return (upper, *(Line(a, b) for a, b in pairwise(corners)), lower, Line(lower.end, upper.start))


def highest(ring: float, boss: float) -> float:
    """Return the greatest height of a rib on a ring of this outer radius, mm.

    `boss`: angle from the middle of the cap at which the fillet of a boss begins, rad. Beyond that height the
    concave arc at the end of the rib would be longer than a quarter turn.
    """
    angle = max(boss - _BARE, 0.0)
    return min(ring / 2, 0.8 * 2 * ring * (math.sin(angle) + math.cos(angle) - 1))


def rib(rod: Dimensions, boss: float) -> Rib:
    """Return the rib of a rod that has one; `boss` as for `highest`."""
    ring, height, angle = rod.big_end_radius, rod.cap_rib, boss - _BARE
    rim, foot, widths = (1 + _LAND) * ring, _FOOT * height, (rod.big_end_width / 2, rod.cap_rib_width / 2)
    # Its ends are rounded with the ring's own radius; the crown touches these arcs and has its middle at c.
    away = 2 * ring
    c = -height * (2 * away + height) / (2 * (away * (1 - math.cos(angle)) + height))
    end, ahead = (-away * math.cos(angle), away * math.sin(angle)), (-math.inf, 0.0)
    return Rib(
        crown=Arc.towards((c, 0.0), ring + height + c, ahead, end, anticlockwise=False),
        end=Arc.towards(end, ring, (c, 0.0), (0.0, 0.0), anticlockwise=True),
        side=RingStep(0.0, rim, rim + foot if rod.cap_rib_width < rod.big_end_width else rim, *widths, foot),
        groove=rod.cap_rib_groove / 2,
        sector=angle + _BARE / 2,
    )
