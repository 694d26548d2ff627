"""Steps from the side faces of a ring to the narrower shank, or to a rib, with a concave arc at the foot."""

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
