"""A pressure trace from a table of measurements: what the keys and headings leave open is found and told."""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from fea.base.choices import PressureReference, PressureUnit
from fea.study.trace_columns import (
    Columns,
    TraceKeys,
    is_documented,
    reference_of,
    trace_columns,
    unit_of,
    unknown_unit,
)
from fea.study.trace_cycles import Recording, Smoothed, completed, firing_offset, recorded, smoothed
from fea.study.trace_reading import Reading, read_as
from fea.study.trace_table import Table, read_table
from fea.units import BAR, DEG
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require
from loads.gas import ATMOSPHERE
from loads.trace import Trace

REMEDY = "A pressure trace needs a column of crank angles in degrees and one of pressures."
_TURN, _CYCLE = 360.0, 720.0
_FOUR_STROKES = 4


@dataclass(frozen=True)
class Surroundings:
    """What else the study says of the gas.

    Attributes
    ----------
    atmosphere
        Absolute pressure in the crankcase, MPa.
    compression_ratio
        If it is given.
    """

    atmosphere: float = ATMOSPHERE
    compression_ratio: float | None = None


@dataclass(frozen=True)
class Imported:
    """A trace, and the keys by which it is read in the same way again."""

    trace: Trace
    keys: TraceKeys


class _Assumption(NamedTuple):
    """The value of a key that neither the study nor the file gives, and why it was chosen."""

    key: str
    value: str | float
    why: str

    @property
    def text(self) -> str:
        value = f"{self.value:g}" if isinstance(self.value, int | float) else f'"{self.value}"'
        return f"{self.key} = {value} ({self.why})"


class _Cycle(NamedTuple):
    """A whole cycle: degrees from firing TDC, and pressures in the unit of the file."""

    angles: Floats
    pressures: Floats


def import_trace(text: str, source: str, keys: TraceKeys, around: Surroundings) -> Imported:
    """Read a trace from the text of a file.

    Raises
    ------
    InvalidValue
        The text contains no trace, or one that can be read in several ways.
    """
    table = read_table(text, source, REMEDY)
    columns = trace_columns(table, keys)
    recording = recorded(columns.angles, columns.pressures, source, table.first_line)
    offset, assumed = _offset(recording, keys, source)
    strokes = _FOUR_STROKES if keys.strokes is None else keys.strokes
    angles, pressures, held = completed(recording, _TURN - offset, strokes, source)
    smooth = smoothed(angles, pressures, recording.step, keys.smoothing_deg)
    cycle = _Cycle(angles, smooth.pressures)
    reading, units, doubt = _reading(columns, cycle, keys, around, source)
    assumptions = [*_column_assumptions(columns, table), *units, *assumed]
    if not np.isnan(held) and keys.strokes is None:
        assumptions.append(_held(held, reading))
    if smooth.width and keys.smoothing_deg is None:
        assumptions.append(_smoothing(pressures, smooth, reading))
    trace = _trace(cycle, reading, around, source)
    cycles = _told_cycles(recording, reading, around)
    told = _told(trace, cycles, assumptions) if cycles or assumptions else ""
    trace = replace(trace, remarks=tuple(text for text in (told, doubt if assumptions else "") if text))
    found: dict[str, Any] = {a.key: a.value for a in assumptions}
    return Imported(trace, replace(keys, **found))


def _column_assumptions(columns: Columns, table: Table) -> list[_Assumption]:
    """The columns that were chosen by what they contain."""
    return [_Assumption(key, value, f"of {len(table.names)} columns") for key, value in columns.found.items()]


def _offset(recording: Recording, keys: TraceKeys, source: str) -> tuple[float, list[_Assumption]]:
    if keys.angle_offset_deg is not None:
        return keys.angle_offset_deg, []
    offset = firing_offset(recording, source)
    peak = float(recording.angles[int(np.argmax(recording.pressures))])
    tdc = _TURN - offset + _CYCLE * round((peak - _TURN + offset) / _CYCLE)
    why = f"firing TDC at {tdc:g}° in the file, where the peak is at {peak:.4g}°"
    return offset, [_Assumption("angle_offset_deg", offset, why)]


def _held(pressure: float, reading: Reading) -> _Assumption:
    """A single revolution, completed with a pressure."""
    held = f"the gas exchange is held at {pressure:.4g} {reading.unit}, where compression begins"
    return _Assumption("strokes", _FOUR_STROKES, f"one revolution is recorded; {held}")


def _smoothing(pressures: Floats, found: Smoothed, reading: Reading) -> _Assumption:
    peaks = f"the peak from {pressures.max():.4g} to {found.pressures.max():.4g} {reading.unit}"
    why = f"changes no pressure by more than {found.change:.2g} {reading.unit}, {peaks}"
    return _Assumption("smoothing_deg", found.width, why)


def _reading(
    columns: Columns, cycle: _Cycle, keys: TraceKeys, around: Surroundings, source: str
) -> tuple[Reading, list[_Assumption], str]:
    unit, reference = _known_unit(columns, keys, source), _known_reference(columns, keys)
    reading, why, doubt = read_as(
        cycle.angles,
        cycle.pressures,
        unit,
        reference,
        atmosphere=around.atmosphere / BAR,
        ratio=around.compression_ratio,
        source=source,
    )
    assumptions = []
    if unit is None:
        largest = f"which makes the largest {cycle.pressures.max() * reading.unit.bar:.4g} bar"
        assumptions.append(_Assumption("pressure_unit", reading.unit, largest))
    if reference is None:
        assumptions.append(_Assumption("pressure_reference", reading.reference, why))
    return reading, assumptions, doubt


def _known_unit(columns: Columns, keys: TraceKeys, source: str) -> PressureUnit | None:
    if keys.pressure_unit is not None:
        return keys.pressure_unit
    strange = unknown_unit(columns.pressure_name)
    rule = f"has pressures in an unknown unit, {strange}"
    remedy = "Convert them, or set engine.pressure_unit to bar, kPa, MPa, Pa or psi."
    require(not strange, f"{source}: column", columns.pressure_name, rule, remedy)
    return unit_of(columns.pressure_name)


def _known_reference(columns: Columns, keys: TraceKeys) -> PressureReference | None:
    if keys.pressure_reference is not None:
        return keys.pressure_reference
    if is_documented(columns.angle_name, columns.pressure_name):
        return PressureReference.GAUGE
    return reference_of(columns.pressure_name)


def _trace(cycle: _Cycle, reading: Reading, around: Surroundings, source: str) -> Trace:
    """Gauge pressures over 0…720°."""
    gauge = reading.gauge(cycle.pressures, around.atmosphere / BAR) * BAR
    angles = np.mod(cycle.angles + _TURN, _CYCLE)
    order = np.argsort(angles, kind="stable")
    try:
        return Trace(angles[order] * DEG, gauge[order], np.zeros(0), source)
    except InvalidValue as error:
        raise InvalidValue(f"{source}: {error.name}", error.value, error.rule, error.remedy) from error


def _told_cycles(recording: Recording, reading: Reading, around: Surroundings) -> str:
    """What was averaged; empty for a single cycle."""
    if recording.cycles == 1:
        return ""
    highest = float(reading.gauge(np.array(recording.highest), around.atmosphere / BAR))
    return f"the mean of {recording.cycles} cycles, the highest of which reaches {highest:.4g} bar, "


def _told(trace: Trace, cycles: str, assumptions: list[_Assumption]) -> str:
    """What was found out, in one line."""
    pressures = trace.pressures[0]
    at = trace.crank_angles[int(pressures.argmax())] / DEG
    assumed = ", ".join(a.text for a in assumptions)
    return (
        f"pressure trace {trace.source}: {cycles}peak {pressures.max() / BAR:.4g} bar gauge at {at:.4g}°"
        + (f", assuming {assumed}" if assumed else "")
    )
