"""Columba 2022: dynamic forces of the Suzuki Forsa 1 (G10), ESPE Latacunga.

The worksheet solves the 8×8 Newton–Euler system with a gas force of the wrong sign, friction of a fixed
sign and a wrong moment of inertia; the corrected figures come from the closed form. The driving torque T12 is
the negative of the torque on the crank.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fea.base.units import DEG, KG, KG_M2, RPM
from fea.verify.reproduce.tables import PublishedStudy
from geometry.arrays import Floats
from geometry.mass import MassProperties
from loads.dynamics import cycle
from loads.engine import Engine, kinematics
from loads.gas import Boyle, GasModel, NoGas


@dataclass(frozen=True)
class Reactions:
    """The eight unknowns in the engine frame, N and N·mm; arrays over the crank angle.

    Crank (2), rod (3) and slider (4) on the frame (1); F_ij is the force of body i on body j and T12 the
    torque that drives the crank (Norton, Design of Machinery, §11.4; Columba 2022). The rows of `solve`:

        crank   F12 + F32 = 0,   T12 + R_crankpin × F32 = 0              (balanced, constant speed)
        rod     F43 − F32 = m₃ a_G,   R_B/G × F43 − R_A/G × F32 = I α
        slider  F14 − F43 + (F_p, 0) = (m₄ ẍ, 0),   F14x = s F14y
    """

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


SOURCE = "columba-2022"
SPEEDS = (800, 3200, 5100)

R, L = 38.5, 120.0  # mm
PISTON_AREA = 4254.47  # mm²
PISTON = 0.208  # kg
FRICTION = 0.15
ATMOSPHERE = 0.0739  # MPa, Quito
CLEARANCE = 204.757 - 28.0 - L - R  # mm of cylinder above the piston at TDC
COMPRESSION_RATIO = 1 + 2 * R / CLEARANCE
INERTIA_PRINTED = 0.001308541  # kg·m²
INERTIA = 939740.05e-9  # kg·m², Izz


def engine(friction: float = FRICTION) -> Engine:
    """Return the printed engine: three cylinders at 240°."""
    bore = math.sqrt(4 * PISTON_AREA / math.pi)
    return Engine(R, L, bore, PISTON * KG, friction=friction, cylinders=3, phase=240 * DEG)


def rod(inertia: float = INERTIA) -> MassProperties:
    """Return the printed rod with a moment of inertia, kg·m²."""
    zero = (0.0, 0.0, 0.0)
    return MassProperties(0.384 * KG, (31.77, 0.0, 0.0), (zero, zero, (0.0, 0.0, inertia * KG_M2)))


def boyle() -> Boyle:
    """Isothermal compression from the atmosphere of Quito."""
    return Boyle(engine(), COMPRESSION_RATIO, ATMOSPHERE)


def gas_force(degrees: Floats) -> Floats:
    """Gas force on the piston at crank angles in degrees, N."""
    return boyle().pressure(degrees * DEG, np.array(0.0)) * PISTON_AREA


def as_published(rpm: float, degrees: Floats, *, gas: bool = True) -> Reactions:
    """Solve the worksheet's system: gas pulls the piston towards the head, F14x = +μ F14y throughout."""
    theta = degrees * DEG
    force = gas_force(degrees) if gas else np.zeros_like(theta)
    return solve(engine(), rod(INERTIA_PRINTED), force, np.full_like(theta, FRICTION), (theta, rpm * RPM))


def corrected(rpm: float, degrees: Floats, *, gas: bool = True) -> Reactions:
    """Return the same quantities from correct mechanics."""
    model: GasModel = boyle() if gas else NoGas()
    c = cycle(engine(), rod(), model, rpm * RPM, degrees * DEG)
    pin, crank = c.in_engine_axes(c.pin), c.in_engine_axes(c.crank)
    return Reactions(crank.x, crank.y, -crank.x, -crank.y, pin.x, pin.y, c.wall, -c.torque)


STUDY = PublishedStudy(SOURCE, globals())
