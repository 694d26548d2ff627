"""Cylinder pressure of a two-stroke engine: the ideal cycle with an exhaust port."""

import math
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats
from geometry.errors import require, require_number
from loads.engine import Engine
from loads.gas import Otto, at_every, dead_centres, relative_volume


@dataclass(frozen=True)
class TwoStrokeOtto(Otto):
    """Ideal two-stroke constant-volume cycle of a perfect gas (Heywood 1988, §5.3 and §6.6).

    Heat at constant volume at TDC, isentropic expansion until the piston uncovers the exhaust port, blow-down
    to the pressure of scavenging (`intake`), which lasts until the piston has covered the port again, and
    isentropic compression of what is trapped then. Pulses in the ports are left out.
    """

    port: float = math.radians(95)  #: crank angle after TDC at which the exhaust port opens, rad

    def __post_init__(self) -> None:
        _require_port(self.engine, self.port)
        super().__post_init__()

    @property
    def trapped_ratio(self) -> float:
        """Volume at which the exhaust port closes over the clearance volume."""
        top, _ = dead_centres(self.engine)
        return float(relative_volume(self.engine, self.compression_ratio, np.asarray(top + self.port)))

    @property
    def compressed(self) -> float:
        """Absolute pressure at the end of compression, MPa: p₁ r^γ with the trapped compression ratio."""
        return float(self.intake * self.trapped_ratio**self.heat_ratio)

    def pressure(self, crank_angle: Floats, speed: Floats) -> Floats:
        """Gauge pressure, MPa, in the broadcast shape of `crank_angle` (rad) and `speed` (rad/s)."""
        top, bottom = dead_centres(self.engine)
        turn = np.mod(crank_angle - top, 2 * math.pi)
        volume = relative_volume(self.engine, self.compression_ratio, crank_angle)
        shrunk = volume**-self.heat_ratio
        shut = np.where(turn < bottom - top, self.expanding(shrunk), self.compressed * shrunk)
        return at_every(speed, np.where(volume < self.trapped_ratio, shut, self.intake) - self.atmosphere)


def _require_port(engine: Engine, port: float) -> None:
    top, bottom = dead_centres(engine)
    degrees = math.degrees(require_number("engine.exhaust_port_deg", port))
    rule = f"must lie between TDC and BDC, {math.degrees(bottom - top):.4g}° after it"
    require(0 < port < bottom - top, "engine.exhaust_port_deg", degrees, rule)
