"""The slider-crank as one 8×8 linear system, as in Columba 2022, used to check our closed form.

Crank (2), rod (3) and slider (4) on the frame (1); F_ij is the force of body i on body j and T12 the torque
that drives the crank (Norton, Design of Machinery, §11.4; Columba 2022). Unknowns and rows:

    F12x F12y F32x F32y F43x F43y F14y T12

    crank   F12 + F32 = 0,   T12 + R_crankpin × F32 = 0              (balanced, constant speed)
    rod     F43 − F32 = m₃ a_G,   R_B/G × F43 − R_A/G × F32 = I α
    slider  F14 − F43 + (F_p, 0) = (m₄ ẍ, 0),   F14x = s F14y
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from geometry.arrays import Floats
from geometry.mass import MassProperties
from loads.engine import Engine
from loads.slider_crank import kinematics


@dataclass(frozen=True)
class Reactions:
    """The eight unknowns in the engine frame, N and N·mm; arrays over the crank angle."""

    F12x: Floats
    F12y: Floats
    F32x: Floats
    F32y: Floats
    F43x: Floats
    F43y: Floats
    F14y: Floats
    T12: Floats


def solve(
    engine: Engine,
    rod: MassProperties,
    piston_force: npt.ArrayLike,
    friction_ratio: npt.ArrayLike,
    motion: tuple[Floats, float],
) -> Reactions:
    """Solve the system at crank angles (n,), rad, and a speed, rad/s (`motion`).

    `piston_force` is F_p on the slider along engine +x, N, and `friction_ratio` s = F14x/F14y with its sign.
    """
    theta, omega = motion
    k = kinematics(engine, theta, omega)
    r, l = engine.crank_radius, engine.rod_length
    along = np.array([np.cos(k.rod_angle), -np.sin(k.rod_angle)])
    across = np.array([-along[1], along[0]])
    crank_pin = r * np.array([np.cos(theta), np.sin(theta)])
    to_center = rod.center[0] * along + rod.center[1] * across
    a, b = -to_center, l * along - to_center  # crank pin and piston pin from the centre of gravity
    turn, rate = -k.rod_acceleration, k.rod_rate
    a_center = -(omega**2) * crank_pin + turn * np.array([-to_center[1], to_center[0]]) - rate**2 * to_center
    matrix, right = np.zeros((theta.size, 8, 8)), np.zeros((theta.size, 8))
    matrix[:, 0, [0, 2]] = matrix[:, 1, [1, 3]] = 1
    matrix[:, 2, 2], matrix[:, 2, 3], matrix[:, 2, 7] = -crank_pin[1], crank_pin[0], 1
    matrix[:, 3, 4], matrix[:, 3, 2] = 1, -1
    matrix[:, 4, 5], matrix[:, 4, 3] = 1, -1
    matrix[:, 5, 4], matrix[:, 5, 5] = -b[1], b[0]
    matrix[:, 5, 2], matrix[:, 5, 3] = a[1], -a[0]
    matrix[:, 6, 6], matrix[:, 6, 4] = friction_ratio, -1
    matrix[:, 7, 6], matrix[:, 7, 5] = 1, -1
    right[:, 3], right[:, 4] = rod.mass * a_center
    right[:, 5] = rod.inertia_z * turn
    right[:, 6] = engine.piston_mass * k.piston_acceleration - np.asarray(piston_force)
    return Reactions(*np.linalg.solve(matrix, right[..., None])[..., 0].T)
