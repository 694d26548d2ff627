"""The engine: crank, rod and piston of one cylinder, and the phase of the others."""

import math
from dataclasses import dataclass

from geometry.errors import require, require_number, require_positive

# More than any engine has; every cylinder is computed.
MOST_CYLINDERS = 100


@dataclass(frozen=True)
class Engine:
    """Crank, rod and piston of one cylinder, and how the cylinders are phased.

    Raises `InvalidValue`: a value breaks its rule: the crank must be able to turn, so (r + |offset|)/l < 1,
    and with friction the piston must not jam, so μ tan β < 1 over the whole turn.
    """

    #: crank_radius, rod_length, bore: mm; the rod is longer than the crank radius plus the pin offset
    crank_radius: float
    rod_length: float
    bore: float
    piston_mass: float  #: piston with pin and rings, t
    pin_offset: float = 0.0  #: distance of the cylinder axis from the crank axis along engine +y (désaxé), mm
    friction: float = 0.0  #: coulomb coefficient between piston and wall
    cylinders: int = 1  #: how many; cylinder k fires `phase`·k after the first
    phase: float = 0.0  #: crank angle between consecutive cylinders, rad
    #: axis of each cylinder from that of the first in the sense of rotation, rad; empty for an in-line engine
    axes: tuple[float, ...] = ()
    #: crank angle at which each cylinder fires after the first, rad; empty for equal intervals of `phase`
    firing: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        require_positive("engine.stroke_mm", self.crank_radius)
        require_positive("rod.length_mm", self.rod_length)
        require_positive("engine.bore_mm", self.bore)
        require_positive("engine.piston_mass_kg", self.piston_mass)
        require_number("engine.pin_offset_mm", self.pin_offset)
        reach = self.crank_radius + abs(self.pin_offset)
        rule = (
            f"must exceed {reach:g} mm, the crank radius plus the pin offset, or the crank cannot turn "
            f"(λ = {reach / self.rod_length:.4g} must be below 1)"
        )
        remedy = "Lengthen the rod or reduce engine.stroke_mm."
        require(reach < self.rod_length, "rod.length_mm", self.rod_length, rule, remedy)
        friction = require_number("engine.friction", self.friction)
        require(friction >= 0, "engine.friction", friction, "must not be negative")
        jam = friction * self.largest_rod_tangent
        rule = f"the piston jams: μ tan β must stay below 1 over the cycle, but reaches {jam:.4g}"
        require(jam < 1, "engine.friction", friction, rule, "Reduce the friction or lengthen the rod.")
        whole = isinstance(self.cylinders, int) and not isinstance(self.cylinders, bool)
        rule = f"must be a whole number from 1 to {MOST_CYLINDERS}"
        require(whole and 1 <= self.cylinders <= MOST_CYLINDERS, "engine.cylinders", self.cylinders, rule)
        require_number("engine.phase_deg", self.phase)

    @property
    def firing_angles(self) -> tuple[float, ...]:
        """Crank angle at which each cylinder fires after the first, rad."""
        return self.firing or tuple(k * self.phase for k in range(self.cylinders))

    @property
    def largest_rod_tangent(self) -> float:
        """The largest |tan β| of a turn."""
        return math.tan(math.asin((self.crank_radius + abs(self.pin_offset)) / self.rod_length))

    @property
    def piston_area(self) -> float:
        """mm²."""
        return math.pi * self.bore**2 / 4

    @property
    def top_position(self) -> float:
        """Distance of the piston pin from the crank axis at top dead centre, along the cylinder, mm."""
        return math.sqrt((self.rod_length + self.crank_radius) ** 2 - self.pin_offset**2)

    @property
    def stroke(self) -> float:
        """Travel of the piston, mm (2r; slightly more with a pin offset)."""
        return self.top_position - math.sqrt((self.rod_length - self.crank_radius) ** 2 - self.pin_offset**2)
