"""The crank cycle in engineering units, by the column names of ``loads.csv``."""

import numpy.typing as npt

from fea.units import DEG, M_S, M_S2, N_M, RPM
from geometry.arrays import Floats
from geometry.mass import MassProperties
from loads.dynamics import Cycle, cycle
from loads.engine import Engine
from loads.gas import GasModel
from loads.slider_crank import cycle_angles


def force_columns(
    engine: Engine, rod: MassProperties, gas: GasModel, rpm: float, angles: Floats | None = None
) -> dict[str, npt.ArrayLike]:
    """Kinematics and forces of one cylinder over the cycle at one speed.

    Parameters
    ----------
    engine, rod, gas
        In coherent units.
    rpm
        Speed.
    angles
        (n,) crank angles, rad; every degree by default.
    """
    angles = cycle_angles() if angles is None else angles
    return columns(cycle(engine, rod, gas, rpm * RPM, angles), rpm)


def columns(c: Cycle, rpm: float) -> dict[str, npt.ArrayLike]:
    """Columns of a computed cycle."""
    motion = c.motion
    return {
        "rpm": rpm,
        "crank_deg": motion.crank_angle / DEG,
        "gas_N": c.gas,
        "piston_position_mm": motion.piston_position,
        "piston_velocity_m_s": motion.piston_velocity / M_S,
        "piston_acceleration_m_s2": motion.piston_acceleration / M_S2,
        "rod_deg": motion.rod_angle / DEG,
        "rod_angular_velocity_rad_s": motion.rod_rate,
        "rod_angular_acceleration_rad_s2": motion.rod_acceleration,
        "pin_axial_N": c.pin_axial,
        "pin_transverse_N": c.pin_transverse,
        "crank_axial_N": c.crank_axial,
        "crank_transverse_N": c.crank_transverse,
        "wall_N": c.wall,
        "torque_Nm": c.torque / N_M,
        "shaking_x_N": c.shaking_x,
        "shaking_y_N": c.shaking_y,
    }
