"""Pressure traces from files of measurements: what keys and headings leave open is decided and told."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fea.base.choices import PressureReference, PressureUnit
from fea.base.shipped import shipped_text
from fea.base.units import BAR, DEG, RPM
from fea.study.trace_columns import DOCUMENTED, Columns, TraceKeys, speed_of, trace_columns
from fea.study.trace_cycles import Recording, completed, firing_offset, recorded, smoothed
from fea.study.trace_table import Form, Line, TraceTable, cells_of, find_table, lines_of, read_rows, read_text
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require
from loads.gas import ATMOSPHERE, LARGEST_PEAK
from loads.trace import Exponent, Trace, compression_exponent

_LOWEST_PEAK = 3.0  # bar gauge: a throttled engine that idles reaches no more
# Least absolute pressures, bar: those of any engine, of nearly all, and of most. A reading is preferred only
# where it is among the last and no other is among the second.
_ANY, _NEARLY_ALL, _MOST = (0.1, 6.5), (0.2, 4.5), (0.3, 3.5)
# Least pressures as they stand in the file, bar: below the first they are gauge, from the second to the third
# absolute, unless the compression says otherwise.
_NEAR_ZERO, _THROTTLED, _AMBIENT = 0.15, 0.4, 1.05
# Percentiles: the level at which the cylinder is filled, above the noise, and the least pressure of all.
_FILLING, _LEAST = 10.0, 1.0


@dataclass(frozen=True)
class Reading:
    """One way to read the pressures, by the values of the keys."""

    unit: PressureUnit
    reference: PressureReference

    def absolute(self, pressures: Floats, atmosphere: float) -> Floats:
        """Absolute pressures, bar, of pressures in the unit of the file; `atmosphere` in bar."""
        shift = atmosphere if self.reference is PressureReference.GAUGE else 0.0
        return pressures * self.unit.bar + shift

    def gauge(self, pressures: Floats, atmosphere: float) -> Floats:
        """Gauge pressures, bar, of pressures in the unit of the file; `atmosphere` in bar."""
        shift = atmosphere if self.reference is PressureReference.ABSOLUTE else 0.0
        return pressures * self.unit.bar - shift


def read_as(
    angles: Floats,
    pressures: Floats,
    unit: PressureUnit | None,
    reference: PressureReference | None,
    *,
    atmosphere: float,
    ratio: float | None,
    source: str,
) -> tuple[Reading, str, str]:
    """Decide unit and reference; say why, and where the result is in doubt.

    Angles (n,) are in degrees from firing TDC, pressures (n,) in the unit of the file, the atmosphere in bar;
    unit, reference and compression ratio are None where they are not known. Raises `InvalidValue`: no
    reading, or more than one, is possible.
    """
    units = [unit] if unit else list(PressureUnit)
    references = [reference] if reference else list(PressureReference)
    readings = [Reading(*each) for each in product(units, references)]
    possible = [r for r in readings if _is_plausible(r, pressures, atmosphere, known_unit=unit is not None)]
    absolute = {r: r.absolute(pressures, atmosphere) for r in possible or readings}
    exponents = {r: compression_exponent(angles, values, ratio) for r, values in absolute.items()}
    if len(readings) == 1:
        return readings[0], "", _doubt(exponents[readings[0]])
    fitting = [r for r in possible if exponents[r].is_compression]
    if len(fitting) == 1:
        return fitting[0], f"compression then follows p·V^{exponents[fitting[0]].middle:.3g}", ""
    left = _preferred(fitting or possible, pressures, atmosphere)
    if len(left) != 1:
        raise _no_reading(left, pressures, atmosphere, source)
    why = f"the least pressure is {_level(pressures, _LEAST):.3g} {left[0].unit}"
    return left[0], why, _doubt(exponents[left[0]])


def _doubt(exponent: Exponent) -> str:
    if exponent.is_compression or not exponent.known:
        return ""
    return (
        f"between 110° and 60° before firing TDC the pressure follows p·V^{exponent.middle:.3g}, which is "
        "not that of a compression (about 1.3): check pressure_reference and angle_offset_deg"
    )


def _level(pressures: Floats, percentile: float = _FILLING) -> float:
    return float(np.percentile(pressures, percentile))


def _is_plausible(reading: Reading, pressures: Floats, atmosphere: float, *, known_unit: bool) -> bool:
    absolute = reading.absolute(pressures, atmosphere)
    least, peak = _level(absolute), float(absolute.max()) - atmosphere
    usual = _within(least, _ANY) and _LOWEST_PEAK <= peak <= LARGEST_PEAK / BAR
    return least > 0 if known_unit else usual


def _within(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] <= value <= limits[1]


def _preferred(readings: list[Reading], pressures: Floats, atmosphere: float) -> list[Reading]:
    """Keep the readings that the least pressure indicates; all where it does not decide."""
    least = {r: _level(r.absolute(pressures, atmosphere)) for r in readings}
    near = [r for r in readings if _within(least[r], _NEARLY_ALL)]
    units = {r.unit for r in near}
    if len(units) == 1 and any(_within(least[r], _MOST) for r in near):
        readings = near
    return _by_level(readings, pressures) if len({r.unit for r in readings}) == 1 else readings


def _by_level(readings: list[Reading], pressures: Floats) -> list[Reading]:
    if len(readings) == 1:
        return readings
    least = _level(pressures, _LEAST) * readings[0].unit.bar
    if least < _NEAR_ZERO:
        return [r for r in readings if r.reference is PressureReference.GAUGE]
    if _THROTTLED <= least <= _AMBIENT:
        return [r for r in readings if r.reference is PressureReference.ABSOLUTE]
    return readings


def _no_reading(readings: list[Reading], pressures: Floats, atmosphere: float, source: str) -> InvalidValue:
    name, value = f"{source}: pressures", f"{pressures.min():.4g}…{pressures.max():.4g}"
    if not readings:
        rule = "are those of a cylinder in none of bar, kPa, MPa, Pa and psi, neither absolute nor gauge"
        remedy = "Set engine.pressure_column, or engine.pressure_unit and engine.pressure_reference."
        return InvalidValue(name, value, rule, remedy)
    first, second = (
        f"{r.unit} {r.reference} (peak {float(r.gauge(pressures.max(), atmosphere)):.4g} bar gauge)"
        for r in readings[:2]
    )
    remedy = "Set engine.pressure_reference, or give engine.compression_ratio."
    if readings[0].unit is not readings[1].unit:
        remedy = "Set engine.pressure_unit and engine.pressure_reference."
    return InvalidValue(name, value, f"may be {first} or {second}", remedy)


_REMEDY = "A pressure trace needs a column of crank angles in degrees and one of pressures."
_TURN, _CYCLE = 360.0, 720.0
_FOUR_STROKES = 4
SHIPPED = ("leon-2001",)
# What a file of measurements may be called.
SUFFIXES = (".csv", ".txt", ".dat", ".tsv", ".asc", ".prn")
# A naturally aspirated engine draws in below the atmosphere: gauge pressures that stay above it by this much,
# bar, may be absolute.
_ABOVE = 0.2


@dataclass(frozen=True)
class Surroundings:
    """What else the study says of the gas: absolute pressure in the crankcase, MPa, and compression ratio."""

    atmosphere: float = ATMOSPHERE
    compression_ratio: float | None = None


@dataclass(frozen=True)
class Imported:
    """A trace, and the keys by which it is read in the same way again."""

    trace: Trace
    keys: TraceKeys


_NONE = TraceKeys()
_NOWHERE = Surroundings()


def shipped_trace(name: str) -> Trace:
    """Load a trace that comes with the program. Raises `InvalidValue`: it is none of `SHIPPED`."""
    require(name in SHIPPED, "engine.gas", name, f"must be one of {', '.join(SHIPPED)} or a CSV file")
    return parse_trace(shipped_text(f"studies/{name}-gas.csv"), "").trace


def read_trace(path: Path, keys: TraceKeys = _NONE, around: Surroundings = _NOWHERE) -> Imported:
    """Read a user's trace by its keys, and decide the rest. Raises `InvalidValue` with file and line."""
    return parse_trace(read_text(path, _REMEDY), path.name, keys, around)


def parse_trace(text: str, source: str, keys: TraceKeys = _NONE, around: Surroundings = _NOWHERE) -> Imported:
    """Turn the text of a file into a trace; `source` is its name in messages."""
    lines = lines_of(text)
    start, header = next(((i, line) for i, line in enumerate(lines) if not line.is_comment), (0, Line(0, "")))
    names = cells_of(header.text, ",")
    speeds = [name for name in names[1:] if speed_of(name) is not None]
    of_speeds = names[:1] == [DOCUMENTED[0]] and 0 < len(speeds) == len(names) - 1
    documented = of_speeds or names == [*DOCUMENTED]
    if documented and not keys.given:
        form = Form(",", comma=False, cells=len(names), numbers=tuple(range(len(names))), exact=True)
        table = read_rows(lines[start + 1 :], form, tuple(names), source)
        angles = table.values[:, 0]
        if not (angles.size and (angles.min() < 0 or angles.max() > _CYCLE)):
            return Imported(_documented(table, speeds), keys)
    if documented and speeds and keys.pressure_column is None:
        first = _import(lines, source, replace(keys, pressure_column=speeds[0]), around)
        others = [replace(first.keys, pressure_column=column) for column in speeds[1:]]
        rest = [_import(lines, source, each, around) for each in others]
        trace = replace(
            first.trace,
            pressures=np.concatenate([each.trace.pressures for each in (first, *rest)]),
            speeds=np.array([speed_of(column) for column in speeds], dtype=np.float64) * RPM,
        )
        return Imported(trace, replace(first.keys, pressure_column=None))
    return _import(lines, source, keys, around)


def _documented(table: TraceTable, speeds: list[str]) -> Trace:
    """The trace of a file in our own format: gauge pressures over 0…720°."""
    angles, source = table.values[:, 0], table.source
    back = np.flatnonzero(np.diff(angles) <= 0)
    if back.size:
        after = int(back[0]) + 1
        raise InvalidValue(
            f"{source}: line {table.lines[after]}, crank_deg",
            float(angles[after]),
            f"must increase from line to line (it follows {angles[after - 1]:g})",
            "Sort the lines and drop repeated angles.",
        )
    rpm = np.array([speed_of(name) for name in speeds], dtype=np.float64)
    trace = _checked(angles, table.values[:, 1:].T * BAR, rpm * RPM, source)
    least = float(trace.pressures.min()) / BAR
    if not source or least < _ABOVE:
        return trace
    told = f"the gauge pressure in {source} never falls below the atmosphere (at least {least:.3g} bar)"
    remark = f'{told}: if the file holds absolute pressures, set pressure_reference = "absolute"'
    return replace(trace, remarks=(remark,))


def _checked(angles: Floats, pressures: Floats, speeds: Floats, source: str) -> Trace:
    try:
        return Trace(angles * DEG, pressures, speeds, source)
    except InvalidValue as error:
        raise InvalidValue(f"{source}: {error.name}", error.value, error.rule, error.remedy) from error


class _Assumption(NamedTuple):
    """The value of a key that neither the study nor the file gives, and why it was chosen."""

    key: str
    value: str | float
    why: str

    @property
    def text(self) -> str:
        value = f"{self.value:g}" if isinstance(self.value, int | float) else f'"{self.value}"'
        return f"{self.key} = {value} ({self.why})"


def _import(lines: Sequence[Line], source: str, keys: TraceKeys, around: Surroundings) -> Imported:
    table = find_table(lines, source, _REMEDY)
    columns = trace_columns(table, keys)
    recording = recorded(columns.angles, columns.pressures, source, table.lines)
    offset, assumed = _offset(recording, keys, source)
    strokes = _FOUR_STROKES if keys.strokes is None else keys.strokes
    angles, pressures, held = completed(recording, _TURN - offset, strokes, source)
    smooth = smoothed(angles, pressures, recording.step, keys.smoothing_deg)
    reading, units, doubt = _reading(columns, (angles, smooth.pressures), keys, around, source)
    chosen = f"of {len(table.names)} columns"
    assumptions = [_Assumption(key, value, chosen) for key, value in columns.chosen.items()] + units + assumed
    if not np.isnan(held) and keys.strokes is None:
        why = f"the gas exchange is held at {held:.4g} {reading.unit}, where compression begins"
        assumptions.append(_Assumption("strokes", _FOUR_STROKES, f"one revolution is recorded; {why}"))
    if smooth.width and keys.smoothing_deg is None:
        peaks = f"the peak from {pressures.max():.4g} to {smooth.pressures.max():.4g} {reading.unit}"
        why = f"changes no pressure by more than {smooth.change:.2g} {reading.unit}, {peaks}"
        assumptions.append(_Assumption("smoothing_deg", smooth.width, why))
    gauge = reading.gauge(smooth.pressures, around.atmosphere / BAR) * BAR
    turned = np.mod(angles + _TURN, _CYCLE)
    order = np.argsort(turned, kind="stable")
    trace = _checked(turned[order], gauge[order], np.zeros(0), source)
    remarks = (_told(trace, recording, reading, around, assumptions), doubt if assumptions else "")
    decided: dict[str, Any] = {each.key: each.value for each in assumptions}
    return Imported(replace(trace, remarks=tuple(filter(None, remarks))), replace(keys, **decided))


def _offset(recording: Recording, keys: TraceKeys, source: str) -> tuple[float, list[_Assumption]]:
    if keys.angle_offset_deg is not None:
        return keys.angle_offset_deg, []
    offset = firing_offset(recording, source)
    peak = recording.peak
    tdc = _TURN - offset + _CYCLE * round((peak - _TURN + offset) / _CYCLE)
    why = f"firing TDC at {tdc:g}° in the file, where the peak is at {peak:.4g}°"
    return offset, [_Assumption("angle_offset_deg", offset, why)]


def _reading(
    columns: Columns, cycle: tuple[Floats, Floats], keys: TraceKeys, around: Surroundings, source: str
) -> tuple[Reading, list[_Assumption], str]:
    unit, reference = columns.unit(keys, source), columns.reference(keys)
    _, pressures = cycle
    atmosphere, ratio = around.atmosphere / BAR, around.compression_ratio
    reading, why, doubt = read_as(*cycle, unit, reference, atmosphere=atmosphere, ratio=ratio, source=source)
    assumptions = []
    if unit is None:
        largest = f"which makes the largest {pressures.max() * reading.unit.bar:.4g} bar"
        assumptions.append(_Assumption("pressure_unit", reading.unit, largest))
    if reference is None:
        assumptions.append(_Assumption("pressure_reference", reading.reference, why))
    return reading, assumptions, doubt


def _told(
    trace: Trace, recording: Recording, reading: Reading, around: Surroundings, assumptions: list[_Assumption]
) -> str:
    cycles = ""
    if recording.cycles > 1:
        highest = float(reading.gauge(np.array(recording.highest), around.atmosphere / BAR))
        cycles = f"the mean of {recording.cycles} cycles, the highest of which reaches {highest:.4g} bar, "
    if not cycles and not assumptions:
        return ""
    pressures = trace.pressures[0]
    at = trace.crank_angles[int(pressures.argmax())] / DEG
    assumed = ", ".join(each.text for each in assumptions)
    return (
        f"pressure trace {trace.source}: {cycles}peak {pressures.max() / BAR:.4g} bar gauge at {at:.4g}°"
        + (f", assuming {assumed}" if assumed else "")
    )
