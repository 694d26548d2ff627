"""The operating points of a map: engine speed, and the gas load as a multiple of the study's."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from fea.base.units import BAR, RPM
from fea.rod.loading import CLOSED_THROTTLE, EngineLoading
from geometry.arrays import Floats
from geometry.mass import MassProperties
from loads.crank_cycle import CrankCycle
from loads.gas import HEAT_RATIO_AIR, NoGas, Otto, Scaled, scaled

# Compression ratio where the study has none: the pull at the dead centre of gas exchange does not need it.
_COMPRESSION = 10.0
# Share of the torque that friction and the drive of auxiliaries leave (Heywood 1988, §2.4: 0.9 at full load
# and low speed to 0.75 at the highest).
MECHANICAL_EFFICIENCY = 0.85
# Mean piston speeds, m/s, of idling, and far above those of racing engines (28).
_IDLING, _FASTEST = 2.2, 50.0
_Number = TypeVar("_Number", float, Floats)


@dataclass(frozen=True, eq=False)
class ScaledEngine:
    """An engine at any speed and gas load factor (`scale`, the key `gas_scale` of [engine])."""

    loading: EngineLoading
    rod: MassProperties

    def cycle(self, rpm: float, scale: float) -> CrankCycle:
        """Return the crank cycle at a speed, rpm, and a gas load factor."""
        loading = replace(self.loading, gas=scaled(self.loading.gas, scale))
        return loading.crank_cycle(self.rod, rpm)

    def peak(self, rpm: float, scale: float = 1.0) -> float:
        """Absolute peak pressure, MPa."""
        gas = self.loading.gas
        if isinstance(gas, Otto):  # with a pin offset the dead centre lies between degrees
            return scale * (gas.compressed if gas.peak is None else gas.peak)
        angles = np.concatenate([self.loading.engine.cycle_angles, gas.samples])
        gauge = float(gas.pressure(angles, np.asarray(rpm * RPM)).max())
        return scale * gauge + self.loading.table.atmosphere

    def scale(self, rpm: float, peak: _Number) -> _Number:
        """Return the gas load factor that gives an absolute peak pressure, or each of many, MPa."""
        none = self.peak(rpm, 0.0)
        return (peak - none) / (self.peak(rpm) - none)

    @property
    def burns(self) -> bool:
        """Whether there is gas whose pressure can be scaled."""
        gas = self.loading.gas
        return not isinstance(gas.gas if isinstance(gas, Scaled) else gas, NoGas)

    @property
    def idle(self) -> float:
        """Speed, rpm, at the mean piston speed of idling engines."""
        return self._at(_IDLING)

    @property
    def fastest(self) -> float:
        """Speed, rpm, above that of any engine of this stroke."""
        return self._at(_FASTEST)

    def _at(self, piston_speed: float) -> float:
        return piston_speed * 30_000 / (2 * self.loading.engine.crank_radius)

    def boost(self, scale: _Number) -> _Number:
        """Gauge pressure in the intake, bar: absolute pressures are in proportion to the gas load factor."""
        gas, table = self.loading.gas, self.loading.table
        factor = gas.factor if isinstance(gas, Scaled) else 1.0
        today = gas.intake if isinstance(gas, Otto) else factor * table.intake
        return (scale * today - table.atmosphere) / BAR

    @cached_property
    def full_load(self) -> tuple[Floats, Floats] | None:
        """Speeds (n,), rpm, and absolute peak pressures (n,), MPa, that the study gives for full load."""
        points = sorted(self.loading.table.full_load or (), key=lambda point: point["rpm"])
        if not points or not self.burns:
            return None
        peaks = [
            point["peak_pressure_bar"] * BAR
            if "peak_pressure_bar" in point
            else self.peak(point["rpm"], self._scale_of_torque(point["rpm"], point["torque_Nm"]))
            for point in points
        ]
        return np.array([point["rpm"] for point in points]), np.array(peaks)

    def _scale_of_torque(self, rpm: float, torque: float) -> float:
        """Return the gas load factor at which the engine gives a mean torque, N·m."""
        engine = self.loading.engine
        count, angles = engine.cylinders, engine.cycle_angles[:-1]
        cycles = (self.cycle(rpm, scale) for scale in (0.5, 1.0))
        low, high = (count * float(cycle.at(angles).torque.mean()) / 1e3 for cycle in cycles)
        return 0.5 + 0.5 * (torque / MECHANICAL_EFFICIENCY - low) / (high - low)

    def full_load_scale(self, rpm: float) -> float:
        """Return the gas load factor of full load at a speed, by default 1; 0 without gas."""
        if self.full_load is None:
            return float(self.burns)
        return self.scale(rpm, float(np.interp(rpm, *self.full_load)))

    def closed_throttle(self) -> "ScaledEngine":
        """Return the engine as its vehicle drives it, with the throttle closed and no combustion."""
        table, engine = self.loading.table, self.loading.engine
        ratio = table.compression_ratio or _COMPRESSION
        # The exhaust port of a two-stroke engine opens to the atmosphere in every revolution.
        intake = table.atmosphere if engine.strokes == 2 else CLOSED_THROTTLE * BAR
        gas = table.ideal_cycle(engine, ratio, None, intake, HEAT_RATIO_AIR)
        return ScaledEngine(EngineLoading(engine, gas, table), self.rod)
