"""Cylinder pressure over the crank angle: what was measured, and the ideal cycles.

Pressures are gauge (against an open crankcase), MPa; crank angles rad from TDC, firing TDC at 2π,
one cycle every 4π.
"""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from geometry.invalid import InvalidValue, require, require_number, require_positive
from loads.engine import Engine

Floats = npt.NDArray[np.float64]

CYCLE = 4 * math.pi
ATMOSPHERE = 0.101325  # MPa
HEAT_RATIO_AIR = 1.4

# No piston engine in service peaks above 400 bar, and none that compresses at all stays below 1 bar.
_LARGEST_PEAK, _SMALLEST_PEAK = 40.0, 0.1
# A trace may start and end its cycle apart by this part of its peak (drift of the transducer).
_CLOSURE = 0.05


class GasModel(Protocol):
    """Anything that gives a gauge pressure over crank angle and speed."""

    def pressure(self, crank_angle: Floats, speed: Floats) -> Floats:
        """Gauge pressure, MPa, in the broadcast shape of `crank_angle` (rad) and `speed` (rad/s)."""

    def note(self, speed: float) -> str:
        """Say what a reader must know about the pressure at this speed (rad/s); mostly nothing."""


@dataclass(frozen=True)
class NoGas:
    """An open cylinder: inertia alone."""

    def pressure(self, crank_angle: Floats, speed: Floats) -> Floats:
        """Zero everywhere."""
        return np.zeros(np.broadcast_shapes(np.shape(crank_angle), np.shape(speed)))

    def note(self, speed: float) -> str:  # noqa: ARG002
        """Nothing to say."""
        return ""


@dataclass(frozen=True)
class Trace:
    """Measured pressure, periodic over one cycle and linear between its samples.

    Attributes
    ----------
    crank_angles
        (n,) rad, increasing, within one cycle 0…4π.
    pressures
        (k, n) gauge, MPa: one row per measured speed.
    speeds
        (k,) rad/s, increasing; linear in speed between them, the nearest one outside. With one row it
        may be empty: the trace then holds at any speed and nothing is flagged.

    Raises
    ------
    InvalidValue
        When the samples are too few, unsorted, do not cover or close the cycle, or hold a pressure that
        no engine has (the message then guesses the unit).
    """

    crank_angles: Floats
    pressures: Floats
    speeds: Floats

    def __post_init__(self) -> None:
        """Refuse a trace that is not one cycle of an engine; drop a sample that repeats the first."""
        angles = np.asarray(self.crank_angles, dtype=np.float64)
        pressures = np.atleast_2d(np.asarray(self.pressures, dtype=np.float64))
        speeds = np.asarray(self.speeds, dtype=np.float64).reshape(-1)
        _require_shapes(angles, pressures, speeds)
        _require_increasing_angles(angles)
        _require_plausible(pressures)
        angles, pressures = _closed(angles, pressures)
        _require_coverage(angles)
        object.__setattr__(self, "crank_angles", angles)
        object.__setattr__(self, "pressures", pressures)
        object.__setattr__(self, "speeds", speeds)

    def pressure(self, crank_angle: Floats, speed: Floats) -> Floats:
        """Gauge pressure, MPa, in the broadcast shape of `crank_angle` (rad) and `speed` (rad/s)."""
        rows = [np.interp(crank_angle, self.crank_angles, p, period=CYCLE) for p in self.pressures]
        if len(rows) == 1:
            return np.broadcast_to(
                rows[0], np.broadcast_shapes(np.shape(crank_angle), np.shape(speed))
            ).copy()
        # np.interp on unit vectors gives each row's weight: linear between, the nearest outside.
        weights = (np.interp(speed, self.speeds, unit) for unit in np.eye(len(rows)))
        return np.asarray(sum(w * p for w, p in zip(weights, rows, strict=True)), dtype=np.float64)

    def note(self, speed: float) -> str:
        """Say when the speed lies outside the measured ones."""
        if self.speeds.size == 0 or self.speeds[0] * (1 - 1e-9) <= speed <= self.speeds[-1] * (1 + 1e-9):
            return ""
        nearest = self.speeds[0] if speed < self.speeds[0] else self.speeds[-1]
        return (
            f"gas pressure was not measured at {_rpm(speed):.6g} rpm: "
            f"the trace of {_rpm(float(nearest)):.6g} rpm, the nearest, is used"
        )


@dataclass(frozen=True)
class Boyle:
    """Isothermal compression and expansion at every turn: p V = const from the atmosphere at BDC.

    It has no combustion and repeats each turn (Columba 2022, whose gas force it is).

    Attributes
    ----------
    engine
        Gives the volume over the crank angle.
    compression_ratio
        Largest over smallest volume.
    atmosphere
        Absolute pressure at BDC and in the crankcase, MPa.
    """

    engine: Engine
    compression_ratio: float
    atmosphere: float = ATMOSPHERE

    def __post_init__(self) -> None:
        """Refuse a ratio or a pressure that cannot be."""
        _require_compression(self.compression_ratio)
        require_positive("engine.atmosphere_bar", self.atmosphere)

    def pressure(self, crank_angle: Floats, speed: Floats) -> Floats:
        """Gauge pressure, MPa, in the broadcast shape of `crank_angle` (rad) and `speed` (rad/s)."""
        ratio = self.compression_ratio / relative_volume(self.engine, self.compression_ratio, crank_angle)
        return _at_every(speed, self.atmosphere * (ratio - 1))

    def note(self, speed: float) -> str:  # noqa: ARG002
        """Nothing to say."""
        return ""


@dataclass(frozen=True)
class Otto:
    """Ideal four-stroke constant-volume cycle of a perfect gas (Heywood 1988, §5.2 and table 5.1).

    Intake 0…π at the intake pressure, isentropic compression π…2π, heat at constant volume at the
    firing TDC, isentropic expansion 2π…3π, blow-down at BDC, exhaust 3π…4π at atmospheric pressure.
    Strokes end at the piston's own dead centres, which a pin offset moves.

    Attributes
    ----------
    engine
        Gives the volume over the crank angle.
    compression_ratio
        Largest over smallest volume.
    peak
        Absolute pressure after combustion, MPa; None for a motored engine (compression without combustion).
    intake, atmosphere
        Absolute pressures, MPa.
    heat_ratio
        γ = c_p/c_v of the charge.
    """

    engine: Engine
    compression_ratio: float
    peak: float | None = None
    intake: float = ATMOSPHERE
    atmosphere: float = ATMOSPHERE
    heat_ratio: float = HEAT_RATIO_AIR

    def __post_init__(self) -> None:
        """Refuse a cycle that thermodynamics does not allow."""
        _require_compression(self.compression_ratio)
        require_positive("engine.intake_pressure_bar", self.intake)
        require_positive("engine.atmosphere_bar", self.atmosphere)
        gamma = require_number("engine.heat_ratio", self.heat_ratio)
        require(
            1 <= gamma <= 5 / 3,
            "engine.heat_ratio",
            gamma,
            "must lie between 1 (isothermal) and 5/3 (monatomic)",
        )
        if self.peak is not None:
            self._require_peak(require_positive("engine.peak_pressure_bar", self.peak))

    def _require_peak(self, peak: float) -> None:
        bar = 10 * peak
        require(
            peak >= self.compressed,
            "engine.peak_pressure_bar",
            bar,
            f"must not lie below the end of compression, {10 * self.compressed:.4g} bar absolute",
            'Without combustion the model is gas = "motored".',
        )
        require(peak <= _LARGEST_PEAK, "engine.peak_pressure_bar", bar, _too_high(peak))

    @property
    def compressed(self) -> float:
        """Absolute pressure at the end of compression, MPa: p₁ r^γ."""
        return float(self.intake * self.compression_ratio**self.heat_ratio)

    def pressure(self, crank_angle: Floats, speed: Floats) -> Floats:
        """Gauge pressure, MPa, in the broadcast shape of `crank_angle` (rad) and `speed` (rad/s)."""
        top, bottom = dead_centres(self.engine)
        turn = np.mod(crank_angle - top, CYCLE)  # from the gas-exchange TDC
        stroke = np.searchsorted([bottom - top, 2 * math.pi, 2 * math.pi + bottom - top], turn, side="right")
        shrunk = relative_volume(self.engine, self.compression_ratio, crank_angle) ** -self.heat_ratio
        peak = self.compressed if self.peak is None else self.peak
        strokes = (
            np.full_like(shrunk, self.intake),
            self.compressed * shrunk,
            peak * shrunk,
            np.full_like(shrunk, self.atmosphere),
        )
        return _at_every(speed, np.choose(stroke, strokes) - self.atmosphere)

    def note(self, speed: float) -> str:  # noqa: ARG002
        """Nothing to say."""
        return ""


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


def _at_every(speed: Floats, pressure: Floats) -> Floats:
    return np.broadcast_to(pressure, np.broadcast_shapes(pressure.shape, np.shape(speed))).copy()


def _rpm(speed: float) -> float:
    return speed * 30 / math.pi


def _require_compression(ratio: float) -> None:
    require_number("engine.compression_ratio", ratio)
    require(1 < ratio <= 100, "engine.compression_ratio", ratio, "must lie above 1 and not above 100")


def _require_shapes(angles: Floats, pressures: Floats, speeds: Floats) -> None:
    require(
        angles.ndim == 1 and angles.size >= 3,
        "gas trace",
        f"{angles.size} sample{'s' * (angles.size != 1)}",
        "needs three samples or more over the cycle",
    )
    rows, columns = pressures.shape
    require(
        columns == angles.size,
        "gas trace",
        f"{columns} pressures",
        f"must match its {angles.size} crank angles",
    )
    fits = speeds.size == rows or (speeds.size == 0 and rows == 1)
    require(fits, "gas trace", f"{rows} traces", f"must match its {speeds.size} speeds")
    finite = all(np.isfinite(a).all() for a in (angles, pressures, speeds))
    require(finite, "gas trace", "not finite", "must hold finite numbers only")
    rising = speeds.size == 0 or (speeds[0] > 0 and bool((np.diff(speeds) > 0).all()))
    require(
        rising,
        "gas trace",
        f"speeds {[round(_rpm(s), 3) for s in speeds]} rpm",
        "must be positive and increasing",
    )


def _require_increasing_angles(angles: Floats) -> None:
    back = np.flatnonzero(np.diff(angles) <= 0)
    if back.size:
        i = int(back[0]) + 1
        raise InvalidValue(
            "gas trace crank_deg",
            math.degrees(angles[i]),
            f"must increase from sample to sample (it follows {math.degrees(angles[i - 1]):g})",
            "Sort the samples and drop repeated angles.",
        )
    outside = angles[(angles < 0) | (angles > CYCLE * (1 + 1e-12))]
    if outside.size:
        raise InvalidValue(
            "gas trace crank_deg",
            math.degrees(outside[0]),
            "must lie within one cycle, 0…720°",
            "Angles count from the gas-exchange TDC; firing TDC is at 360°.",
        )


def _require_plausible(pressures: Floats) -> None:
    lowest, peak = float(pressures.min()), float(pressures.max(axis=1).min())
    highest = float(pressures.max())
    require(highest <= _LARGEST_PEAK, "gas trace pressure_bar", 10 * highest, _too_high(highest))
    require(
        lowest >= -ATMOSPHERE * 1.05,
        "gas trace pressure_bar",
        10 * lowest,
        "a gauge pressure cannot lie below a vacuum (−1 bar)",
    )
    require(
        peak >= _SMALLEST_PEAK,
        "gas trace pressure_bar",
        10 * peak,
        "peaks below 1 bar, which no engine that compresses does",
        'If these are MPa, multiply by 10; for no gas at all, say gas = "none".',
    )


def _too_high(peak: float) -> str:
    bar = 10 * peak
    unit, in_bar = ("Pa", 1e-5) if bar >= 1e5 else ("kPa", 1e-2) if bar >= 3000 else ("psi", 0.0689476)
    return (
        f"peaks above {10 * _LARGEST_PEAK:g} bar, which no engine reaches; "
        f"if these are {unit}, the peak is {bar * in_bar:.4g} bar"
    )


def _closed(angles: Floats, pressures: Floats) -> tuple[Floats, Floats]:
    """Without the sample a full cycle after the first, which must (nearly) repeat it."""
    if angles[-1] - angles[0] < CYCLE * (1 - 1e-9):
        return angles, pressures
    gap = float(np.max(np.abs(pressures[:, -1] - pressures[:, 0]) / pressures.max(axis=1)))
    require(
        gap <= _CLOSURE,
        "gas trace",
        f"{100 * gap:.3g} % of the peak apart at 0° and 720°",
        f"must close to {100 * _CLOSURE:g} % of its peak (the value at 0° is then used for both)",
    )
    return angles[:-1], pressures[:, :-1]


def _require_coverage(angles: Floats) -> None:
    steps = np.diff(angles)
    closing = CYCLE - (angles[-1] - angles[0])
    require(
        closing <= 1.5 * float(steps.max()),
        "gas trace crank_deg",
        f"{math.degrees(angles[0]):g}…{math.degrees(angles[-1]):g}",
        f"must cover a four-stroke cycle of 720°: {math.degrees(closing):.4g}° are missing",
    )
