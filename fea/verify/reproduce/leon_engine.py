"""León 2001: the engine as printed, and its exact dynamics.

J. L. León, *Análisis por elemento finito en una biela de motor de combustión interna*, UNAM, 2001.
"""

import math

import numpy as np
import numpy.typing as npt

from fea.study.traces import shipped_trace
from fea.units import DEG, KG, KG_M2, RPM
from geometry.mass import MassProperties
from loads.dynamics import EngineInstants, cycle
from loads.engine import Engine
from loads.slider_crank import Kinematics, kinematics

SOURCE = "leon-2001"
SPEEDS = (6000, 3000, 800)

R, L = 0.047, 0.141  # crank radius and rod length, m
LAMBDA = R / L
BORE = 76.0  # mm, as printed
PISTON = 1.3345  # kg, with pin and rings
M_B = 0.356312  # kg: the rod's mass at the piston pin
INERTIA = 3.868e-3  # kg·m², which is m·a·b of the two masses

# Values used in the thesis.
M_RECIPROCATING = 1.690  # kg, PISTON + M_B truncated
M_A_USED = 0.428  # kg: the rod's mass at the crank pin, 0.428687, truncated
AREA_USED = 5944.0  # mm²: a bore of 87 mm

ROD = MassProperties(
    mass=0.785 * KG,
    center=(64.0, 0.0, 0.0),
    inertia=((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, INERTIA * KG_M2)),
)


def engine(bore: float = BORE) -> Engine:
    """Return the printed engine, optionally with another bore (mm) for the sensitivity study."""
    return Engine(
        crank_radius=1e3 * R,
        rod_length=1e3 * L,
        bore=bore,
        piston_mass=PISTON * KG,
        cylinders=4,
        phase=math.pi,
    )


def exact_motion(rpm: float, degrees: npt.ArrayLike) -> Kinematics:
    """Kinematics of the mechanism at crank angles in degrees."""
    return kinematics(engine(), np.asarray(degrees, dtype=np.float64) * DEG, rpm * RPM)


def exact_forces(rpm: float, degrees: npt.ArrayLike) -> EngineInstants:
    """Forces with the measured gas pressure at crank angles in degrees."""
    angles = np.asarray(degrees, dtype=np.float64) * DEG
    return cycle(engine(), ROD, shipped_trace(SOURCE), rpm * RPM, angles)


def along_cylinder(instants: EngineInstants) -> npt.NDArray[np.float64]:
    """Force on the rod at the piston pin along the cylinder, N."""
    return instants.in_engine_axes(instants.pin).x
