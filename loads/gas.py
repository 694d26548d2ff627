"""Cylinder pressure over the crank angle: ideal cycles.

Pressures are gauge (against an open crankcase), MPa; crank angles rad from TDC, firing TDC at 2π,
one cycle every 4π, or every 2π of a two-stroke engine.
"""

import math
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from geometry.arrays import Floats
from geometry.errors import require, require_number, require_positive
from loads.engine import Engine

ATMOSPHERE = 0.101325  # MPa
HEAT_RATIO_AIR = 1.4

LARGEST_PEAK = 40.0  # MPa: no piston engine in service reaches it


class GasModel(Protocol):
    """Anything that gives a gauge pressure over crank angle and speed; ideal cycles inherit the rest."""

    @property
    def samples(self) -> Floats:
        """Crank angles, rad, that include every peak of a sampled pressure; empty for a smooth one."""
        return np.zeros(0)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a user must know about where the pressure comes from."""
        return ()

    @property
    def doubts(self) -> tuple[str, ...]:
        """What may be wrong with it."""
        return ()

    def pressure(self, crank_angle: Floats, speed: Floats) -> Floats:
        """Gauge pressure, MPa, in the broadcast shape of `crank_angle` (rad) and `speed` (rad/s)."""

    def note(self, speed: float) -> str:  # noqa: ARG002
        """Return a note for the user about the pressure at this speed (rad/s); usually empty."""
        return ""


@dataclass(frozen=True)
class NoGas(GasModel):
    """An open cylinder: inertia alone."""

    def pressure(self, crank_angle: Floats, speed: Floats) -> Floats:
        """Zero everywhere."""
        return np.zeros(np.broadcast_shapes(np.shape(crank_angle), np.shape(speed)))


@dataclass(frozen=True)
class Boyle(GasModel):
    """Isothermal p V = const, atmospheric at BDC, every revolution; no combustion (Columba 2022)."""

    engine: Engine  #: gives the volume over the crank angle
    compression_ratio: float  #: largest over smallest volume
    atmosphere: float = ATMOSPHERE  #: absolute pressure at BDC and in the crankcase, MPa

    def __post_init__(self) -> None:
        _require_compression(self.compression_ratio)
        require_positive("engine.atmosphere_bar", self.atmosphere)
        _require_reached("engine.atmosphere_bar", self.atmosphere, self.atmosphere * self.compression_ratio)

    def pressure(self, crank_angle: Floats, speed: Floats) -> Floats:
        """Gauge pressure, MPa, in the broadcast shape of `crank_angle` (rad) and `speed` (rad/s)."""
        ratio = self.compression_ratio / relative_volume(self.engine, self.compression_ratio, crank_angle)
        return at_every(speed, self.atmosphere * (ratio - 1))


@dataclass(frozen=True)
class Compressor(GasModel):
    """Ideal cycle of a reciprocating compressor with clearance, every revolution.

    The gas in the clearance expands to the pressure of the intake, and what is drawn in is compressed to the
    delivery pressure, by p V^γ = const; valves open at once. Per revolution it takes the work γ/(γ − 1) p₁ V₁
    [(p₂/p₁)^((γ−1)/γ) − 1], with the volume V₁ that is drawn in.
    """

    engine: Engine  #: gives the volume over the crank angle
    compression_ratio: float  #: largest over smallest volume
    delivery: float  #: absolute pressure at which it delivers, MPa
    #: intake, atmosphere: absolute pressures, MPa
    intake: float = ATMOSPHERE
    atmosphere: float = ATMOSPHERE
    heat_ratio: float = HEAT_RATIO_AIR  #: exponent γ of compression and expansion

    def __post_init__(self) -> None:
        _require_compression(self.compression_ratio)
        require_positive("engine.intake_pressure_bar", self.intake)
        reached = self.intake * self.compression_ratio**self.heat_ratio
        rule = f"must lie above the intake and be reached by compression, at most {10 * reached:.4g} bar"
        name, remedy = "engine.delivery_pressure_bar", "Raise compression_ratio, which leaves less clearance."
        require(self.intake < self.delivery <= reached, name, 10 * self.delivery, rule, remedy)
        require(self.delivery <= LARGEST_PEAK, name, 10 * self.delivery, too_high(self.delivery))

    def pressure(self, crank_angle: Floats, speed: Floats) -> Floats:
        """Gauge pressure, MPa, in the broadcast shape of `crank_angle` (rad) and `speed` (rad/s)."""
        top, bottom = dead_centres(self.engine)
        volume = relative_volume(self.engine, self.compression_ratio, crank_angle)
        expanding = np.maximum(self.delivery * volume**-self.heat_ratio, self.intake)
        compressed = self.intake * (self.compression_ratio / volume) ** self.heat_ratio
        compressing = np.minimum(compressed, self.delivery)
        outwards = np.mod(crank_angle - top, 2 * math.pi) < bottom - top
        return at_every(speed, np.where(outwards, expanding, compressing) - self.atmosphere)


@dataclass(frozen=True)
class Otto(GasModel):
    """Ideal four-stroke constant-volume or limited-pressure cycle of a perfect gas (Heywood 1988, §5.2).

    Intake 0…π at the intake pressure, isentropic compression π…2π, heat at constant volume at the firing TDC
    and then, up to the cut-off, at constant pressure, isentropic expansion 2π…3π, blow-down at BDC, exhaust
    3π…4π at atmospheric pressure. Strokes end at the piston's own dead centres, which a pin offset moves.
    """

    engine: Engine  #: gives the volume over the crank angle
    compression_ratio: float  #: largest over smallest volume
    #: Absolute pressure after combustion, MPa; None for a motored engine (compression without combustion)
    peak: float | None = None
    #: intake, atmosphere: absolute pressures, MPa
    intake: float = ATMOSPHERE
    atmosphere: float = ATMOSPHERE
    heat_ratio: float = HEAT_RATIO_AIR  #: γ = c_p/c_v of the charge
    remark: str = ""  #: where the peak comes from, if that is to be said
    cut_off: float = 1.0  #: volume at which heat at constant pressure ends, over the clearance volume

    @property
    def remarks(self) -> tuple[str, ...]:
        """Where the peak comes from."""
        return (self.remark,) if self.remark else ()

    def __post_init__(self) -> None:
        _require_compression(self.compression_ratio)
        require_positive("engine.intake_pressure_bar", self.intake)
        require_positive("engine.atmosphere_bar", self.atmosphere)
        gamma = require_number("engine.heat_ratio", self.heat_ratio)
        rule = "must lie between 1 (isothermal) and 5/3 (monatomic gas)"
        require(1 <= gamma <= 5 / 3, "engine.heat_ratio", gamma, rule)
        _require_reached("engine.intake_pressure_bar", self.intake, self.compressed)
        if self.peak is not None:
            key, peak = "engine.peak_pressure_bar", require_positive("engine.peak_pressure_bar", self.peak)
            rule = f"must be at least {10 * self.compressed:.4g} bar absolute, the pressure after compression"
            remedy = 'For an engine without combustion use gas = "motored".'
            require(peak >= self.compressed, key, 10 * peak, rule, remedy)
            require(peak <= LARGEST_PEAK, key, 10 * peak, too_high(peak))

    @property
    def compressed(self) -> float:
        """Absolute pressure at the end of compression, MPa: p₁ r^γ."""
        return float(self.intake * self.compression_ratio**self.heat_ratio)

    def expanding(self, shrunk: Floats) -> Floats:
        """Return the absolute pressure, MPa, after TDC, from the volume relative to that there, to −γ."""
        peak = self.compressed if self.peak is None else self.peak
        return np.asarray(peak * np.minimum(self.cut_off**self.heat_ratio * shrunk, 1.0))

    def pressure(self, crank_angle: Floats, speed: Floats) -> Floats:
        """Gauge pressure, MPa, in the broadcast shape of `crank_angle` (rad) and `speed` (rad/s)."""
        top, bottom = dead_centres(self.engine)
        turn = np.mod(crank_angle - top, 4 * math.pi)  # from the gas-exchange TDC
        stroke = np.searchsorted([bottom - top, 2 * math.pi, 2 * math.pi + bottom - top], turn, side="right")
        shrunk = relative_volume(self.engine, self.compression_ratio, crank_angle) ** -self.heat_ratio
        intake, exhaust = np.full_like(shrunk, self.intake), np.full_like(shrunk, self.atmosphere)
        strokes = intake, self.compressed * shrunk, self.expanding(shrunk), exhaust
        return at_every(speed, np.choose(stroke, strokes) - self.atmosphere)


@dataclass(frozen=True)
class TwoStrokeOtto(Otto):
    """Ideal two-stroke constant-volume cycle of a perfect gas (Heywood 1988, §5.3 and §6.6).

    Heat at constant volume at TDC, isentropic expansion until the exhaust port opens, the pressure of
    scavenging (`intake`) until it shuts, and isentropic compression. Pulses in the ports are left out.
    """

    port: float = math.radians(95)  #: crank angle after TDC at which the exhaust port opens, rad

    def __post_init__(self) -> None:
        top, bottom = dead_centres(self.engine)
        degrees = math.degrees(require_number("engine.exhaust_port_deg", self.port))
        rule = f"must lie between TDC and BDC, {math.degrees(bottom - top):.4g}° after it"
        require(0 < self.port < bottom - top, "engine.exhaust_port_deg", degrees, rule)
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


@dataclass(frozen=True)
class Scaled:
    """A multiple of the gauge pressure of another gas: a measured trace at another load."""

    gas: GasModel
    factor: float

    @property
    def samples(self) -> Floats:
        """Those of the gas."""
        return self.gas.samples

    @property
    def doubts(self) -> tuple[str, ...]:
        """Those of the gas."""
        return self.gas.doubts

    @property
    def remarks(self) -> tuple[str, ...]:
        """Those of the gas, and the multiple."""
        said = f"the gauge pressure of the gas is multiplied by {self.factor:.4g} at every crank angle"
        return (*self.gas.remarks, said)

    def pressure(self, crank_angle: Floats, speed: Floats) -> Floats:
        """Gauge pressure, MPa, in the broadcast shape of `crank_angle` (rad) and `speed` (rad/s)."""
        return self.factor * self.gas.pressure(crank_angle, speed)

    def note(self, speed: float) -> str:
        """Return that of the gas."""
        return self.gas.note(speed)


def scaled(gas: GasModel, factor: float) -> GasModel:
    """Return the gas at a multiple of its charge.

    In the ideal constant-volume cycle every pressure between intake and blow-down is in proportion to the
    intake pressure, if mixture and intake temperature stay the same: p₃/p₁ = r^γ + (γ − 1) r q/(R T₁)
    (Heywood 1988, §5.3). The gauge pressure of any other gas is multiplied.
    """
    if factor == 1.0:
        return gas
    if isinstance(gas, Otto):
        peak = None if gas.peak is None else factor * gas.peak
        return replace(gas, intake=factor * gas.intake, peak=peak)
    return Scaled(gas, factor)


def dead_centres(engine: Engine) -> tuple[float, float]:
    """Crank angles of top and bottom dead centre, rad: crank and rod in one line."""
    top = math.asin(engine.pin_offset / (engine.rod_length + engine.crank_radius))
    bottom = math.pi + math.asin(engine.pin_offset / (engine.rod_length - engine.crank_radius))
    return top, bottom


def relative_volume(engine: Engine, compression_ratio: float, crank_angle: Floats) -> Floats:
    """Cylinder volume over clearance volume: 1 at TDC, the compression ratio at BDC."""
    sin_b = (engine.crank_radius * np.sin(crank_angle) - engine.pin_offset) / engine.rod_length
    position = engine.crank_radius * np.cos(crank_angle) + engine.rod_length * np.sqrt(1 - sin_b**2)
    travel = (engine.top_position - position) / engine.stroke
    return np.asarray(1 + (compression_ratio - 1) * travel, dtype=np.float64)


def at_every(speed: Floats, pressure: Floats) -> Floats:
    """Return a pressure over the crank angle in the broadcast shape of it and of speeds."""
    return np.broadcast_to(pressure, np.broadcast_shapes(pressure.shape, np.shape(speed))).copy()


def _require_compression(ratio: float) -> None:
    require_number("engine.compression_ratio", ratio)
    require(1 < ratio <= 100, "engine.compression_ratio", ratio, "must be above 1 and at most 100")


def _require_reached(name: str, before: float, compressed: float) -> None:
    rule = f"gives {10 * compressed:.4g} bar after compression; no engine exceeds {10 * LARGEST_PEAK:g} bar"
    require(compressed <= LARGEST_PEAK, name, 10 * before, rule, "Give it in bar absolute.")


def too_high(peak: float) -> str:
    """The rule for a peak pressure (MPa) above that of any engine, and the unit it may have been given in."""
    bar = 10 * peak
    unit, in_bar = ("Pa", 1e-5) if bar >= 1e5 else ("kPa", 1e-2) if bar >= 3000 else ("psi", 0.0689476)
    return (
        f"must not exceed {10 * LARGEST_PEAK:g} bar, more than any engine reaches. If the values are in "
        f"{unit}, convert them: the peak is then {bar * in_bar:.4g} bar. For hydraulic lock, give [forces]"
    )
