"""Measured cylinder pressure: one trace for every measured speed."""

import math
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats
from geometry.errors import InvalidValue, require
from loads.gas import ATMOSPHERE, LARGEST_PEAK, GasModel, at_every, too_high

_SMALLEST_PEAK = 0.1  # MPa: every engine that compresses its charge exceeds it
_IDLING_PEAK = 2.0  # MPa: only engines that idle or are motored stay below it
_NO_FIRING = 0.5  # of the peak: a top dead centre with less pressure around it is not the firing one
# Combustion peaks up to some 40° after TDC, motoring just before it; elsewhere the TDC is in doubt.
_EARLIEST, _LATEST = math.radians(355), math.radians(410)
_NEARLY = 0.98  # of the peak: several peaks of this height count as one
# What pressures far below the atmosphere are if neither unit nor reference is wrong.
DOUBLE_ACTING = (
    "A double-acting cylinder (steam, pump), whose other side pushes the piston back, is not supported: "
    "pressure acts above the piston only."
)
# The values at the start and the end of the cycle may differ by this fraction of the peak (transducer drift).
_CLOSURE = 0.05


@dataclass(frozen=True)
class TraceReading:
    """How the pressures of a file were read."""

    unit: str
    reference: str  #: ``absolute`` or ``gauge``
    offset_bar: float  #: added to the pressures of the file
    offset_error_bar: float | None  #: standard deviation of an offset that was found
    compression_exponent: float | None  #: None where the trace shows no compression
    peak_bar: float  #: highest pressure, gauge


@dataclass(frozen=True)
class Trace:
    """Measured pressure, periodic over one cycle and linear between its samples.

    Raises `InvalidValue`: the samples are too few or unsorted, do not cover the cycle, differ between its
    start and end, or no engine reaches them (the message then suggests the unit).
    """

    crank_angles: Floats  #: (n,) rad, increasing, within one cycle, 0 to `cycle`
    pressures: Floats  #: (k, n) gauge, MPa: one row per measured speed
    #: (k,) rad/s, increasing; linear in speed between them, the nearest one outside. With one row it may be
    #: empty: the trace then holds at any speed and nothing is flagged.
    speeds: Floats
    source: str = ""  #: name of the file of a user; empty for a trace that ships
    remarks: tuple[str, ...] = ()  #: what was assumed when it was read
    doubts: tuple[str, ...] = ()  #: what may be wrong with it
    reading: TraceReading | None = None  #: of a user's file
    cycle: float = 4 * math.pi  #: crank angle of a cycle, rad; 2π of a two-stroke engine

    def __post_init__(self) -> None:
        """Refuse a trace that is not one cycle of an engine; drop a sample that repeats the first."""
        angles = np.asarray(self.crank_angles, dtype=np.float64)
        pressures = np.atleast_2d(np.asarray(self.pressures, dtype=np.float64))
        speeds = np.asarray(self.speeds, dtype=np.float64).reshape(-1)
        _require_shapes(angles, pressures, speeds)
        back = np.flatnonzero(np.diff(angles) <= 0)
        if back.size:
            i = int(back[0]) + 1
            rule = f"must increase from sample to sample (it follows {math.degrees(angles[i - 1]):g})"
            remedy = "Sort the samples and drop repeated angles."
            raise InvalidValue("gas trace crank_deg", math.degrees(angles[i]), rule, remedy)
        outside = angles[(angles < 0) | (angles > self.cycle * (1 + 1e-12))]
        whole, two = f"{math.degrees(self.cycle):.0f}°", self._two_stroke
        if outside.size:
            rule = f"must lie within one cycle, 0 to {whole}"
            remedy = "Count angles from the gas-exchange TDC, so that firing TDC is at 360°."
            remedy = "Count angles from firing TDC." if two else remedy
            raise InvalidValue("gas trace crank_deg", math.degrees(outside[0]), rule, remedy)
        lowest, peak = float(pressures.min()), float(pressures.max(axis=1).min())
        highest, key = float(pressures.max()), "gas trace pressure_bar"
        require(highest <= LARGEST_PEAK, key, 10 * highest, too_high(highest))
        rule = "a gauge pressure cannot be below vacuum (−1 bar)"
        remedy = f"Give gauge pressures in bar. {DOUBLE_ACTING}"
        require(lowest >= -ATMOSPHERE * 1.05, key, 10 * lowest, rule, remedy)
        rule = "the peak must exceed 1 bar, as in every engine that compresses its charge"
        remedy = 'If the values are in MPa, multiply them by 10; without gas pressure, use gas = "none".'
        require(peak >= _SMALLEST_PEAK, key, 10 * peak, rule, remedy)
        angles, pressures = _closed(angles, pressures, self.cycle)
        closing = self.cycle - (angles[-1] - angles[0])
        covered = f"{math.degrees(angles[0]):g}…{math.degrees(angles[-1]):g}"
        rule = f"must cover a {'two' if two else 'four'}-stroke cycle of {whole}: "
        rule += f"{math.degrees(closing):.4g}° are missing"
        step = float(np.diff(angles).max())
        turn = not two and abs(closing - 2 * math.pi) <= 2 * step
        remedy = "If the engine is a two-stroke, set engine.strokes = 2." if turn else ""
        require(closing <= 1.5 * step, "gas trace crank_deg", covered, rule, remedy)
        object.__setattr__(self, "crank_angles", angles)
        object.__setattr__(self, "pressures", pressures)
        object.__setattr__(self, "speeds", speeds)

    @property
    def _two_stroke(self) -> bool:
        return self.cycle < 3 * math.pi

    def pressure(self, crank_angle: Floats, speed: Floats) -> Floats:
        """Gauge pressure, MPa, in the broadcast shape of `crank_angle` (rad) and `speed` (rad/s)."""
        rows = [np.interp(crank_angle, self.crank_angles, p, period=self.cycle) for p in self.pressures]
        if len(rows) == 1:
            return at_every(speed, np.asarray(rows[0]))
        # np.interp on unit vectors gives each row's weight: linear between, the nearest outside.
        weights = (np.interp(speed, self.speeds, unit) for unit in np.eye(len(rows)))
        return np.asarray(sum(w * p for w, p in zip(weights, rows, strict=True)), dtype=np.float64)

    @property
    def samples(self) -> Floats:
        """Crank angles of the samples, rad: the pressure is linear between them."""
        return self.crank_angles

    def note(self, speed: float) -> str:
        """Note a speed outside the measured range, and values that suggest another unit or another TDC."""
        notes = []
        speeds = self.speeds
        if speeds.size and not speeds[0] * (1 - 1e-9) <= speed <= speeds[-1] * (1 + 1e-9):
            nearest = speeds[0] if speed < speeds[0] else speeds[-1]
            notes.append(
                f"gas pressure was not measured at {_rpm(speed):.6g} rpm: "
                f"the trace of the nearest speed, {_rpm(float(nearest)):.6g} rpm, is used"
            )
        highest = float(self.pressures.max())
        if highest < _IDLING_PEAK:
            read = self.reading
            sure = read is not None and (read.unit != "bar" or read.compression_exponent is not None)
            remedy = "" if sure else ': if the file is in MPa, set pressure_unit = "MPa"'
            notes.append(
                f"gas pressure peaks at only {10 * highest:.4g} bar, as in an engine at idle{remedy}"
            )
        return "; ".join([*notes, *filter(None, [self._turned()])])

    def _turned(self) -> str:
        highest = self.pressures.max(axis=0)
        # A cycle later: what follows firing TDC at 2π begins at 0 in a two-stroke engine.
        later = np.where(self.crank_angles < _EARLIEST, self.cycle, 0.0)
        near = self.crank_angles + later <= _LATEST
        if highest[near].max(initial=0.0) >= _NEARLY * highest.max():
            return ""
        peak = f"gas pressure peaks at {math.degrees(self.crank_angles[highest.argmax()]):.4g}°"
        firing = np.abs(self.crank_angles - 2 * math.pi) <= math.pi
        if self._two_stroke or highest[firing].max(initial=0.0) >= _NO_FIRING * highest.max():
            return f"{peak}, far from firing TDC at 360°: if that is wrong, set angle_offset_deg"
        return (
            f"{peak}, but firing TDC is at 360°: if the file counts angles from firing TDC, set "
            "angle_offset_deg = 360"
        )


def _rpm(speed: float) -> float:
    return speed * 30 / math.pi


def _require_shapes(angles: Floats, pressures: Floats, speeds: Floats) -> None:
    samples = f"{angles.size} sample{'s' * (angles.size != 1)}"
    rule = "must have at least three samples over the cycle"
    require(angles.ndim == 1 and angles.size >= 3, "gas trace", samples, rule)
    rows, columns = pressures.shape
    rule = f"must match the {angles.size} crank angles"
    require(columns == angles.size, "gas trace", f"{columns} pressures", rule)
    fits = speeds.size == rows or (speeds.size == 0 and rows == 1)
    require(fits, "gas trace", f"{rows} traces", f"must match the {speeds.size} speeds")
    finite = all(np.isfinite(a).all() for a in (angles, pressures, speeds))
    require(finite, "gas trace", "not finite", "must contain finite numbers only")
    rising = speeds.size == 0 or (speeds[0] > 0 and bool((np.diff(speeds) > 0).all()))
    listed = f"speeds {[round(float(_rpm(s)), 3) for s in speeds]} rpm"
    require(rising, "gas trace", listed, "must be positive and increasing")


def _closed(angles: Floats, pressures: Floats, cycle: float) -> tuple[Floats, Floats]:
    """Drop the sample one full cycle after the first, which must (nearly) repeat it."""
    if angles[-1] - angles[0] < cycle * (1 - 1e-9):
        return angles, pressures
    gap = float(np.max(np.abs(pressures[:, -1] - pressures[:, 0]) / pressures.max(axis=1)))
    differ = f"{100 * gap:.3g} % of the peak between 0° and {math.degrees(cycle):.0f}°"
    rule = f"the first and last pressure may differ by at most {100 * _CLOSURE:g} % of the peak"
    require(gap <= _CLOSURE, "gas trace", differ, rule, "Correct the drift of the pressure transducer.")
    return angles[:-1], pressures[:, :-1]


_ROUNDING = 1e-9  # of the largest torque


def absorbed(gas: GasModel, torque: Floats, brake: float | None = None) -> str:
    """Say so where an engine with a measured pressure absorbs power, or gives less than its `brake` torque.

    `gas`: what gave the pressure; computed cycles may absorb power; `torque` (n,) N·mm of a cylinder at equal
    steps over the cycle, whose end repeats its start; `brake`: what is measured of it, N·mm, if known.
    """
    mean = float(np.mean(torque[:-1]))
    if isinstance(gas, Trace) and brake is not None and 0 <= mean < brake:
        return (
            f"the indicated torque of a cylinder, {mean / 1e3:.4g} N·m, is below its brake torque by "
            f"full_load, {brake / 1e3:.4g} N·m: the pressures, their zero or their crank angles are wrong"
        )
    if not isinstance(gas, Trace) or mean >= -_ROUNDING * float(np.abs(torque).max()):
        return ""
    return (
        f"the mean torque over the cycle is {mean / 1e3:.4g} N·m: the engine absorbs power, as a motored one "
        "does. If it fires, the crank angles of the pressure trace are wrong: see angle_offset_deg"
    )
