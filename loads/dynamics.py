"""Forces on piston, rod and crank over the cycle: Newton–Euler in closed form.

Piston (mass m_p), rod (mass m, inertia I about its centre of gravity G) and a balanced crank at constant
speed. With P and C the forces on the rod at piston pin and crank pin, N the force of the wall on the
piston, F_f its friction and F_g the gas force:

    piston  m_p ẍ = −F_g + F_f − P_x,   N = P_y
    rod     m a_G = P + C,              l (P_x sin β + P_y cos β) = I α + (r_G × m a_G)_z
    crank   T = r (C_x sin θ − C_y cos θ)

about the crank pin, so that P follows from piston and rod alone and C from the rod's momentum.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from geometry.arrays import Floats
from geometry.mass import MassProperties
from loads.engine import Engine, Kinematics, kinematics
from loads.gas import GasModel
from loads.instants import Instants


class Vector(NamedTuple):
    """Components in the plane of motion, of the axes named where it is made."""

    #: x, y: one a crank angle and speed
    x: Floats
    y: Floats


@dataclass(frozen=True, kw_only=True, eq=False)
class EngineInstants(Instants):
    """Instants of one cylinder; every array has the broadcast shape of crank angle and speed."""

    motion: Kinematics  #: kinematics of piston and rod
    friction: Floats  #: force of the wall on the piston along engine +x, N; `wall` is along +y
    #: shaking_x, shaking_y: force of the mechanism on the frame, gas on the head included, engine axes, N
    shaking_x: Floats
    shaking_y: Floats

    def in_engine_axes(self, force: Floats) -> Vector:
        """Turn a force (2, n) on the rod, `pin` or `crank`, into engine axes."""
        return to_engine_axes(Vector(*force), self.motion.rod_angle)


def cycle(
    engine: Engine, rod: MassProperties, gas: GasModel, speed: npt.ArrayLike, crank_angle: npt.ArrayLike
) -> EngineInstants:
    """Compute the forces at given crank angles and constant speeds.

    `rod`: mass, centre of gravity (x and y) and I_z; `speed`: rad/s, broadcast against `crank_angle` (rad):
    ``speeds[:, None]`` gives (speeds, angles). Raises `InvalidValue`: not finite, or a negative speed.
    """
    motion = kinematics(engine, crank_angle, speed)
    beta, theta = motion.rod_angle, motion.crank_angle
    gas_force = gas.pressure(theta, motion.speed) * engine.piston_area
    x, y, _ = rod.center
    a_x, a_y = center_acceleration(engine, rod, motion)
    tan_b = np.tan(beta)
    moment = -rod.inertia_z * motion.rod_acceleration + rod.mass * (x * a_y - y * a_x)
    p_x = -gas_force - engine.piston_mass * motion.piston_acceleration
    wall = moment / (engine.rod_length * np.cos(beta)) - p_x * tan_b
    drag = engine.friction * np.sign(motion.piston_velocity)
    wall = wall / (1 - drag * tan_b * np.sign(wall))
    pin = Vector(p_x - drag * np.abs(wall), wall)
    inertia_x, inertia_y = to_engine_axes(Vector(rod.mass * a_x, rod.mass * a_y), beta)
    crank = Vector(inertia_x - pin.x, inertia_y - pin.y)
    return EngineInstants(
        pin=np.stack(to_rod_axes(pin, beta)),
        crank=np.stack(to_rod_axes(crank, beta)),
        acceleration=np.stack(origin_acceleration(engine, motion)),
        angular_velocity=-motion.rod_rate,
        angular_acceleration=-motion.rod_acceleration,
        crank_angle=theta,
        speed=motion.speed,
        gas=gas_force,
        wall=pin.y,
        torque=engine.crank_radius * (crank.x * np.sin(theta) - crank.y * np.cos(theta)),
        motion=motion,
        friction=engine.piston_mass * motion.piston_acceleration + gas_force + pin.x,
        shaking_x=-engine.piston_mass * motion.piston_acceleration - inertia_x,
        shaking_y=-inertia_y,
    )


def to_rod_axes(vector: Vector, rod_angle: Floats) -> Vector:
    """Turn engine components into rod components: rod x is (cos β, −sin β), rod y is (sin β, cos β)."""
    x, y = vector
    cos_b, sin_b = np.cos(rod_angle), np.sin(rod_angle)
    return Vector(x * cos_b - y * sin_b, x * sin_b + y * cos_b)


def to_engine_axes(vector: Vector, rod_angle: Floats) -> Vector:
    """Turn rod components into engine components."""
    return to_rod_axes(vector, -rod_angle)


def center_acceleration(engine: Engine, rod: MassProperties, motion: Kinematics) -> Vector:
    """Acceleration of the rod's centre of gravity in rod axes, mm/s²: a₀ + α×r − ω² r."""
    a_x, a_y = origin_acceleration(engine, motion)
    x, y, _ = rod.center
    alpha, omega2 = -motion.rod_acceleration, motion.rod_rate**2
    return Vector(a_x - alpha * y - omega2 * x, a_y + alpha * x - omega2 * y)


def origin_acceleration(engine: Engine, motion: Kinematics) -> Vector:
    """Centripetal acceleration of the crank pin in rod axes, mm/s²."""
    inward = engine.crank_radius * motion.speed**2
    angle = motion.crank_angle + motion.rod_angle
    return Vector(-inward * np.cos(angle), -inward * np.sin(angle))


@dataclass(frozen=True)
class WholeEngine:
    """All cylinders of an engine over the crank angle of the first."""

    cylinders: tuple[EngineInstants, ...]  #: one cycle per cylinder, all evaluated at the same instants
    torque: Floats  #: on the crank, N·mm
    #: shaking_x, shaking_y: force of the mechanism on the frame, N, in the axes of the first cylinder.
    #: Moments between cylinders are not included: they depend on the distances of the cylinders.
    shaking_x: Floats
    shaking_y: Floats


def whole_engine(
    engine: Engine, rod: MassProperties, gas: GasModel, speed: npt.ArrayLike, crank_angle: npt.ArrayLike
) -> WholeEngine:
    """Compute every cylinder of an engine; each is at θ less its firing angle from its own axis.

    Forces on the frame are turned to the axis of the first cylinder, whose `crank_angle` (rad) is given. The
    `speed`, rad/s, is broadcast against it. Raises `InvalidValue` as `cycle`.
    """
    theta = np.asarray(crank_angle, dtype=np.float64)
    cycles = tuple(cycle(engine, rod, gas, speed, theta - after) for after in engine.firing_angles)
    axes = engine.axes or (0.0,) * engine.cylinders
    frames = [(Vector(c.shaking_x, c.shaking_y), -axis) for c, axis in zip(cycles, axes, strict=True)]
    shaking = [to_engine_axes(force, np.asarray(turn)) for force, turn in frames]
    return WholeEngine(
        cylinders=cycles,
        torque=np.sum([c.torque for c in cycles], axis=0),
        shaking_x=np.sum([force.x for force in shaking], axis=0),
        shaking_y=np.sum([force.y for force in shaking], axis=0),
    )
