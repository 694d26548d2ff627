"""Steps from the faces of the rings to the shank, and ribs over the back of the cap."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geometry.arrays import Floats
from geometry.dimensions import Dimensions
from geometry.segments import Arc, Line, Point, Segment, half_chord

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
