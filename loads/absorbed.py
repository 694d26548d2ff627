"""A remark on a measured pressure that drives the piston backwards."""

import numpy as np

from geometry.arrays import Floats
from loads.gas import GasModel
from loads.trace import Trace

_ROUNDING = 1e-9  # of the largest torque


def absorbed(gas: GasModel, torque: Floats) -> str:
    """Say so where an engine with a measured pressure absorbs power.

    Parameters
    ----------
    gas
        What gave the pressure; computed cycles may absorb power.
    torque
        (n,) N·mm at equal steps over the cycle, whose end repeats its start.
    """
    mean = float(np.mean(torque[:-1]))
    if not isinstance(gas, Trace) or mean >= -_ROUNDING * float(np.abs(torque).max()):
        return ""
    return (
        f"the mean torque over the cycle is {mean / 1e3:.4g} N·m: the engine absorbs power, as a motored one "
        "does. If it fires, the crank angles of the pressure trace are wrong: see angle_offset_deg"
    )
