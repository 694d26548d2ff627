"""Pressure traces from files of measurements: what keys and headings leave open is decided and told."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fea.base.choices import PressureReference, PressureUnit
from fea.base.shipped import shipped_text
from fea.base.units import BAR, DEG, RPM
from fea.study.trace_columns import DOCUMENTED, TraceKeys, speed_of, trace_columns
from fea.study.trace_cycles import Recording, completed, firing_offset, recorded, smoothed
from fea.study.trace_reading import Decision, Known, Reading, decide
from fea.study.trace_table import Form, Line, TraceTable, cells_of, find_table, lines_of, read_rows, read_text
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require
from loads.compression import ROD_RATIO, is_motored, peak_angle
from loads.gas import ATMOSPHERE
from loads.trace import Trace, TraceReading

_REMEDY = "A pressure trace needs a column of crank angles in degrees and one of pressures."
_TURN, _CYCLE = 360.0, 720.0
_FOUR_STROKES = 4
SHIPPED = ("leon-2001",)
# What a file of measurements may be called.
SUFFIXES = (".csv", ".txt", ".dat", ".tsv", ".asc", ".prn")
# Degrees from TDC of a motored peak, which heat and leaks bring before it: the latest, as near to TDC as a
# peak can be located, those between which it is not doubted, and where it usually is.
_MOTORED_LATEST, _MOTORED_UNDOUBTED, _MOTORED_USUAL = -0.02, (-2.0, -0.2), -0.6
# Uncertain TDC, degrees, of a trace whose file does not tell it; bar, by which the shock of the flame's heat
# moves the exhaust stroke of a pegged sensor.
_PHASE, _SHOCK = 1.0, "±0.3 to 0.5"
_FLANKS = 60.0  # degrees about firing TDC in which the pressure rises and falls fastest


@dataclass(frozen=True)
class Surroundings:
    """What else the study says of the gas."""

    atmosphere: float = ATMOSPHERE  #: absolute pressure in the crankcase, MPa
    compression_ratio: float | None = None
    intake: float | None = None  #: absolute pressure in the intake, MPa
    rod_ratio: float = ROD_RATIO  #: crank radius over rod length


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
    if documented and keys.given.keys() <= {"pressure_offset_bar"}:
        form = Form(",", comma=False, cells=len(names), numbers=tuple(range(len(names))), exact=True)
        table = read_rows(lines[start + 1 :], form, tuple(names), source)
        angles = table.values[:, 0]
        if not (angles.size and (angles.min() < 0 or angles.max() > _CYCLE)):
            return Imported(_documented(table, speeds, keys, around), keys)
    if documented and speeds and keys.pressure_column is None:
        first = _import(lines, source, replace(keys, pressure_column=speeds[0]), around)
        others = [replace(first.keys, pressure_column=column) for column in speeds[1:]]
        rest = [_import(lines, source, each, around) for each in others]
        trace = replace(
            first.trace,
            pressures=np.concatenate([each.trace.pressures for each in (first, *rest)]),
            speeds=np.array([speed_of(column) for column in speeds], dtype=np.float64) * RPM,
            doubts=tuple(dict.fromkeys(text for each in (first, *rest) for text in each.trace.doubts)),
        )
        return Imported(trace, replace(first.keys, pressure_column=None))
    return _import(lines, source, keys, around)


def _documented(table: TraceTable, speeds: list[str], keys: TraceKeys, around: Surroundings) -> Trace:
    """The trace of a file in our own format: gauge pressures, bar, over 0…720°. A user's zero is found."""
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
    known = replace(_known(keys, around), unit=PressureUnit.BAR, reference=PressureReference.GAUGE)
    rows = (
        [_read(angles - _TURN, row, known, source, keys) for row in table.values[:, 1:].T] if source else []
    )
    gauge = np.array([row.gauge for row in rows]) if rows else table.values[:, 1:].T
    rpm = np.array([speed_of(name) for name in speeds], dtype=np.float64)
    trace = _checked(angles, gauge * BAR, rpm * RPM, source)
    if not rows:
        return trace
    remarks, doubts = (
        [text for row in rows for text in getattr(row, kind)] for kind in ("remarks", "doubts")
    )
    highest = max(rows, key=lambda row: float(row.gauge.max()))
    return replace(
        trace,
        remarks=tuple(dict.fromkeys(remarks)),
        doubts=tuple(dict.fromkeys(doubts)),
        reading=_figures(highest),
    )


def _checked(angles: Floats, pressures: Floats, speeds: Floats, source: str) -> Trace:
    try:
        return Trace(angles * DEG, pressures, speeds, source)
    except InvalidValue as error:
        raise InvalidValue(f"{source}: {error.name}", error.value, error.rule, error.remedy) from error


def _known(keys: TraceKeys, around: Surroundings) -> Known:
    return Known(
        offset=keys.pressure_offset_bar,
        atmosphere=around.atmosphere / BAR,
        intake=None if around.intake is None else around.intake / BAR,
        ratio=around.compression_ratio,
        rod_ratio=around.rod_ratio,
    )


class _Read(NamedTuple):
    """Gauge pressures (n,), bar, how they were read, and what must be known of that."""

    gauge: Floats
    decision: Decision
    remarks: list[str]
    doubts: list[str]


def _read(angles: Floats, pressures: Floats, known: Known, source: str, keys: TraceKeys) -> _Read:
    """Read pressures (n,) over angles (n,), degrees from firing TDC. Raises `InvalidValue`: see `decide`."""
    decision = decide(angles, pressures, known, source)
    absolute = decision.reading.absolute(pressures, known.atmosphere)
    name, remarks, doubts = f"pressure trace {source}", [], [decision.doubt]
    if decision.why_offset:
        doubts.append(
            f"{decision.why_offset}; the pressures are shifted by that (pressure_offset_bar sets it)"
        )
    if decision.fit is not None and is_motored(angles, absolute):
        doubts.append(_motored_phase(angles, absolute, source, keys))
    elif decision.fit is not None and keys.angle_offset_deg is None:
        near = np.abs(angles) <= _FLANKS
        flank = float(np.abs(np.gradient(absolute[near], angles[near])).max())
        remarks.append(
            f"{name}: each degree by which its TDC is off changes the flanks of the peak by up to "
            f"{_PHASE * flank:.2g} bar, and the heat of the flame moves the sensor's exhaust stroke, which "
            f"counts at gas-exchange TDC, by {_SHOCK} bar"
        )
    told = [f"{name}: {doubt}" for doubt in doubts if doubt]
    return _Read(absolute - known.atmosphere, decision, remarks, told)


def _motored_phase(angles: Floats, absolute: Floats, source: str, keys: TraceKeys) -> str:
    """Return a doubt of the angles of a motored trace. Raises `InvalidValue`: it peaks at or after TDC."""
    peak = peak_angle(angles, absolute)
    usual = (keys.angle_offset_deg or 0.0) - peak + _MOTORED_USUAL
    rule = "of a motored engine lies at or after TDC: heat and leaks bring it 0.3 to 1° before it"
    remedy = f"Add {usual - (keys.angle_offset_deg or 0.0):.2g}° to the angles (engine.angle_offset_deg)."
    value = f"{peak:+.2f}° from TDC"
    require(peak < _MOTORED_LATEST, f"{source}: the peak", value, rule, remedy)
    if _MOTORED_UNDOUBTED[0] <= peak <= _MOTORED_UNDOUBTED[1]:
        return ""
    return f"the motored peak is {-peak:.2g}° before TDC, where 0.3 to 1° is usual: check angle_offset_deg"


def _figures(read: _Read) -> TraceReading:
    """Return what `fea loads` states of a trace."""
    reading, fit = read.decision.reading, read.decision.fit
    return TraceReading(
        unit=reading.unit.value,
        reference=reading.reference.value,
        offset_bar=reading.offset,
        offset_error_bar=read.decision.zero_error,
        compression_exponent=None if fit is None else fit.exponent,
        peak_bar=float(read.gauge.max()),
    )


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
    unit, reference = columns.unit(keys, source), columns.reference(keys)
    known = replace(_known(keys, around), unit=unit, reference=reference)
    read = _read(angles, smooth.pressures, known, source, keys)
    reading = read.decision.reading
    chosen = f"of {len(table.names)} columns"
    assumptions = [_Assumption(key, value, chosen) for key, value in columns.chosen.items()]
    if unit is None:
        largest = f"which makes the largest {read.gauge.max() + known.atmosphere:.4g} bar absolute"
        assumptions.append(_Assumption("pressure_unit", reading.unit, largest))
    if reference is None:
        why = f"as {read.decision.why_reference.rstrip(',')} shows"
        assumptions.append(_Assumption("pressure_reference", reading.reference, why))
    assumptions += assumed
    if not np.isnan(held) and keys.strokes is None:
        why = f"the gas exchange is held at {held:.4g} {reading.unit}, where compression begins"
        assumptions.append(_Assumption("strokes", _FOUR_STROKES, f"one revolution is recorded; {why}"))
    if smooth.width and keys.smoothing_deg is None:
        peaks = f"the peak from {pressures.max():.4g} to {smooth.pressures.max():.4g} {reading.unit}"
        why = f"changes no pressure by more than {smooth.change:.2g} {reading.unit}, {peaks}"
        assumptions.append(_Assumption("smoothing_deg", smooth.width, why))
    turned = np.mod(angles + _TURN, _CYCLE)
    order = np.argsort(turned, kind="stable")
    trace = _checked(turned[order], read.gauge[order] * BAR, np.zeros(0), source)
    told = _told(trace, recording, reading, around, assumptions)
    remarks = tuple(filter(None, (told, *read.remarks)))
    decided: dict[str, Any] = {each.key: each.value for each in assumptions}
    trace = replace(trace, remarks=remarks, doubts=tuple(read.doubts), reading=_figures(read))
    return Imported(trace, replace(keys, **decided))


def _offset(recording: Recording, keys: TraceKeys, source: str) -> tuple[float, list[_Assumption]]:
    if keys.angle_offset_deg is not None:
        return keys.angle_offset_deg, []
    offset = firing_offset(recording, source)
    peak = recording.peak
    tdc = _TURN - offset + _CYCLE * round((peak - _TURN + offset) / _CYCLE)
    why = f"firing TDC at {tdc:g}° in the file, where the peak is at {peak:.4g}°"
    return offset, [_Assumption("angle_offset_deg", offset, why)]


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
