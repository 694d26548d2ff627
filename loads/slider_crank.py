"""Exact kinematics of the slider-crank over the crank angle.

Engine frame: x along the cylinder from crank to head, y to the side. With crank angle θ, crank radius r,
rod length l and pin offset e, the crank pin is at (r cos θ, r sin θ), the piston pin at (x, e), and

    l sin β = r sin θ − e,      x = r cos θ + l cos β.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from geometry.arrays import Floats
from geometry.errors import InvalidValue
from loads.engine import Engine


@dataclass(frozen=True)
class Kinematics:
    """Motion of piston and rod; every array has the broadcast shape of crank angle and speed."""

    #: crank_angle, speed: rad; rad/s
    crank_angle: Floats
    speed: Floats
    #: piston_position, piston_velocity, piston_acceleration: of the piston pin along engine +x from the crank
    #: axis: mm, mm/s, mm/s²
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

    `crank_angle`: rad, any shape; `speed`: of the crank, rad/s, zero or positive, broadcast against
    `crank_angle`: ``speeds[:, None]`` gives arrays of (speeds, angles). Raises `InvalidValue`: an angle is
    not finite or a speed is negative or not finite.
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


def cycle_angles() -> Floats:
    """Crank angles of one four-stroke cycle, every degree, both ends included, rad."""
    return np.arange(721.0) * (math.pi / 180)
