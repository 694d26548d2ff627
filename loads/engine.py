"""The engine: crank, rod and piston of one cylinder, the phase of the others, and its exact kinematics.

Engine frame: x along the cylinder from crank to head, y to the side. With crank angle θ, crank radius r,
rod length l and pin offset e, the crank pin is at (r cos θ, r sin θ), the piston pin at (x, e), and

    l sin β = r sin θ − e,      x = r cos θ + l cos β.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from geometry.arrays import Floats
from geometry.errors import InvalidValue, require, require_number, require_positive

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
    strokes: int = 4  #: of a cycle: 4, or 2, with which every revolution is a cycle

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
        require(self.strokes in (2, 4), "engine.strokes", self.strokes, "must be 2 or 4")

    @property
    def cycle(self) -> float:
        """Crank angle of a cycle, rad: 4π, or 2π of a two-stroke engine."""
        return self.strokes * math.pi

    @property
    def cycle_degrees(self) -> int:
        """Crank angle of a cycle, degrees: 720, or 360 of a two-stroke engine."""
        return 180 * self.strokes

    @property
    def cycles_per_hour(self) -> float:
        """Cycles an hour at 1 rpm: 30, or 60 of a two-stroke engine."""
        return 120.0 / self.strokes

    @property
    def cycle_angles(self) -> Floats:
        """Crank angles of a cycle, every degree, both ends included, rad."""
        return np.arange(self.cycle_degrees + 1.0) * (math.pi / 180)

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


@dataclass(frozen=True)
class Kinematics:
    """Motion of piston and rod; every array has the broadcast shape of crank angle and speed."""

    #: crank_angle, speed: rad; rad/s
    crank_angle: Floats
    speed: Floats
    #: piston_position, piston_velocity, piston_acceleration: of its pin, along engine +x: mm, mm/s, mm/s²
    piston_position: Floats
    piston_velocity: Floats
    piston_acceleration: Floats
    #: rod_angle, rod_rate, rod_acceleration: β, β̇, β̈: rad, rad/s, rad/s²; β > 0 while the crank pin lies on
    #: the +y side of the cylinder axis. The rod itself turns by −β about engine +z.
    rod_angle: Floats
    rod_rate: Floats
    rod_acceleration: Floats


def kinematics(engine: Engine, crank_angle: npt.ArrayLike, speed: npt.ArrayLike) -> Kinematics:
    """Exact motion at given crank angles and constant speeds.

    `crank_angle`: rad; `speed`: rad/s, broadcast against it: ``speeds[:, None]`` gives (speeds, angles).
    Raises `InvalidValue`: an angle or a speed is not finite, or a speed is negative.
    """
    theta = np.asarray(crank_angle, dtype=np.float64)
    if not np.isfinite(theta).all():
        raise InvalidValue("crank angle", "not finite", "every angle must be finite")
    omega = np.asarray(speed, dtype=np.float64)
    if not (np.isfinite(omega) & (omega >= 0)).all():
        worst = float(omega.min()) if np.isfinite(omega).all() else "not finite"
        raise InvalidValue("crank speed (rad/s)", worst, "must be finite and not negative")
    theta, omega = np.broadcast_arrays(theta, omega)
    r, l, e = engine.crank_radius, engine.rod_length, engine.pin_offset
    sin_t, cos_t = np.sin(theta), np.cos(theta)
    sin_b = (r * sin_t - e) / l
    cos_b = np.sqrt(1 - sin_b**2)
    beta_d = r * omega * cos_t / (l * cos_b)
    beta_dd = (beta_d**2 * sin_b - r / l * omega**2 * sin_t) / cos_b
    return Kinematics(
        crank_angle=theta,
        speed=omega,
        piston_position=r * cos_t + l * cos_b,
        piston_velocity=-r * omega * sin_t - l * beta_d * sin_b,
        piston_acceleration=-r * omega**2 * cos_t - l * (beta_d**2 * cos_b + beta_dd * sin_b),
        rod_angle=np.arcsin(sin_b),
        rod_rate=beta_d,
        rod_acceleration=beta_dd,
    )
