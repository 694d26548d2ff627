"""All cylinders of an engine: each has its own cycle, shifted by its phase."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from geometry.arrays import Floats
from geometry.mass import MassProperties
from loads.dynamics import Cycle, cycle
from loads.engine import Engine
from loads.gas import GasModel


@dataclass(frozen=True)
class WholeEngine:
    """All cylinders of an in-line engine over the crank angle of the first.

    Attributes
    ----------
    cylinders
        One cycle per cylinder, all evaluated at the same instants.
    torque
        On the crank, N·mm.
    shaking_x, shaking_y
        Force of the mechanism on the frame, N. Moments between cylinders are not included: they depend on
        the distances of the cylinders.
    """

    cylinders: tuple[Cycle, ...]
    torque: Floats
    shaking_x: Floats
    shaking_y: Floats


def whole_engine(
    engine: Engine, rod: MassProperties, gas: GasModel, speed: npt.ArrayLike, crank_angle: npt.ArrayLike
) -> WholeEngine:
    """Compute every cylinder of an engine; cylinder k is at the crank angle θ − k·phase.

    Parameters
    ----------
    rod
        Mass properties of each rod.
    speed
        rad/s, broadcast against `crank_angle` (rad, of the first cylinder).

    Raises
    ------
    InvalidValue
        When an angle or a speed is not finite or a speed is negative.
    """
    theta = np.asarray(crank_angle, dtype=np.float64)
    cycles = tuple(cycle(engine, rod, gas, speed, theta - k * engine.phase) for k in range(engine.cylinders))
    return WholeEngine(
        cylinders=cycles,
        torque=np.sum([c.torque for c in cycles], axis=0),
        shaking_x=np.sum([c.shaking_x for c in cycles], axis=0),
        shaking_y=np.sum([c.shaking_y for c in cycles], axis=0),
    )
