"""Columns of crank angle and cylinder pressure in a table, by keys, by names or by what they contain."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np

from fea.base.choices import PressureReference, PressureUnit
from fea.base.shipped import TomlTable
from fea.study.tables import Positive, StudyTable, key, keys_of, within
from fea.study.trace_table import DOCUMENTED, TraceTable, speed_of
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require
from loads.compression import compression

_CYCLE, _REVOLUTION, _HALF_TURN = 720.0, 360.0, 180.0  # degrees
_WIDEST_SMOOTHING = 10.0  # degrees: more flattens a peak


@dataclass(frozen=True, kw_only=True)
class TraceKeys(StudyTable, table="engine"):
    """How a trace is to be read; what is None is found out from the file."""

    angle_column: str | int | None = key(
        "1",
        "name or number of the column of crank angles in degrees",
        above="For a file: what its headings do not say is deduced, and the run says what it assumed. "
        "These keys decide:",
    )
    time_column: str | int | None = key(
        "1",
        "of a recording over time with a trigger: its times, in any unit; default: equal steps",
        needs="trigger_column: times do not give crank angles",
    )
    trigger_column: str | int | None = key(
        "3", "name or number of the column of a trigger or encoder, whose rises through its middle count"
    )
    trigger_pulses: int | None = key(
        "1", "of it in a revolution of the crank", within(1, 7200), needs="trigger_column"
    )
    angle_offset_deg: float | None = key(
        "360.0",
        "added to the angles of the file, so that firing TDC is at 360",
        within(-_CYCLE, _CYCLE, " degrees"),
    )
    pressure_column: str | int | None = key(
        "2", 'name or number of the column of pressures; or "2-61", cycles to be averaged'
    )
    gain_bar_V: Positive | None = key(
        "20.0", "of the sensor with its amplifier, where the column of pressures holds volts"
    )
    offset_V: float | None = key(
        "0.5",
        "at pressure 0, with gain_bar_V; default: 0",
        needs="gain_bar_V, which turns volts into pressures",
    )
    pressure_unit: PressureUnit | None = key('"bar"', "of the pressures in the file; or kPa, MPa, Pa, psi")
    pressure_reference: PressureReference | None = key(
        '"absolute"', 'of those pressures, less atmosphere_bar; or "gauge"'
    )
    pressure_offset_bar: float | None = key(
        "0.0",
        "added to those pressures: sensors of changes lose their zero. Default: what the compression shows, "
        "or the pressure in the intake, where the zero is off by more than 0.12 bar; 0 leaves it",
    )
    smoothing_deg: float | None = key(
        "1.0", "width of a moving average; 0: none", within(0.0, _WIDEST_SMOOTHING, " degrees")
    )

    @property
    def given(self) -> TomlTable:
        """The keys that say something of how to read a trace."""
        return {name: value for name in keys_of(TraceKeys) if (value := getattr(self, name)) is not None}

    def __post_init__(self) -> None:
        super().__post_init__()
        both = "cannot be combined with trigger_column, which gives the angles"
        alone = self.trigger_column is None or self.angle_column is None
        require(alone, "engine.angle_column", self.angle_column, both, "Remove one of them.")
        rule, unit = "cannot be combined with gain_bar_V, which gives bar", self.pressure_unit
        in_bar = self.gain_bar_V is None or unit in (None, PressureUnit.BAR)
        require(in_bar, "engine.pressure_unit", unit, rule)


# Words of headings. Those of other pressures, and of what is derived from a cylinder's, exclude both.
_ANGLES = {
    *("crank", "crankangle", "crankshaft", "ca", "cad", "deg", "degca", "cadeg", "degree", "degrees"),
    *("theta", "phi", "φ", "θ", "angle", "angolo", "angulo", "vilebrequin", "winkel", "kurbelwinkel", "kw"),
    *("°ca", "°kw", "°", "曲轴转角", "转角"),
}
_PRESSURES = {
    *("p", "press", "pressure", "druck", "zylinderdruck", "pression", "presion", "pressione", "pressao"),
    *("cylp", "pcyl", "pzyl", "pz", "cylpress", "cylpres", "cylinderpressure", "缸压", "压力", "气缸压力"),
}
_OTHERS = {
    *("intake", "inlet", "manifold", "boost", "exhaust", "oil", "fuel", "rail", "injection", "ambient"),
    *("atmosphere", "atmospheric", "rate", "dp", "derivative", "filter", "spark", "ignition", "rod"),
}
_UNITS = {unit.lower(): unit for unit in PressureUnit}
_REFERENCES = "abs|absolute|absolut|absolu|gauge|gage|rel|relative|relativ"
# A unit, and what it refers to: ``bara``, ``[bar abs]``, ``psig``. Single letters count only after a unit.
_UNIT = re.compile(rf"(?<![^\W_])({'|'.join(_UNITS)})(?:[\W_]*(a|g|ga|{_REFERENCES}))?(?![^\W_])")
_REFERENCE = re.compile(rf"(?<![^\W_])({_REFERENCES})(?![^\W_])")
_BRACKETS = re.compile(r"[\[({<]([^\])}>]*)[\])}>]")


def _is_angle(name: str) -> bool:
    words = _words(name)
    return bool(words & _ANGLES) and not words & _OTHERS and not _is_pressure(name)


def _is_pressure(name: str) -> bool:
    words = _words(name)
    named = bool(words & _PRESSURES) or any(re.fullmatch(r"p_?(?:cyl|zyl)\w*", word) for word in words)
    return named and not words & _OTHERS


def _plain(name: str) -> str:
    """Return a name in small letters; a capital after two small letters begins a word."""
    return re.sub(r"(?<=[a-z][a-z])(?=[A-Z])", " ", name).lower()


def _words(name: str) -> set[str]:
    """Words of a name, alone and in pairs; those in brackets count where it has no others: ``[deg]``."""
    for part in (_BRACKETS.sub(" ", name), name):
        if words := re.findall(r"(?:[^\W_]|°)+", _plain(part)):
            return set(words) | {"".join(pair) for pair in pairwise(words)}
    return set()


def _unit_of(name: str, source: str) -> PressureUnit | None:
    """Return the unit of pressure in a column's name. Raises `InvalidValue`: another one, as in [V]."""
    if units := _UNIT.findall(_plain(name)):
        return _UNITS[units[-1][0]]
    inside = [match[1].strip() for match in _BRACKETS.finditer(name)]
    strange = [text for text in inside if text and not _reference_of(f"bar {text}")]
    rule = f"has pressures in an unknown unit, {strange[-1] if strange else ''}"
    remedy = "Convert them, or set engine.pressure_unit to bar, kPa, MPa, Pa or psi."
    require(not strange, f"{source}: column", name, rule, remedy)
    return None


def _reference_of(name: str) -> PressureReference | None:
    """Return what the pressures of a column are measured against by its name."""
    beside = [reference for _, reference in _UNIT.findall(_plain(name)) if reference]
    words = beside or _REFERENCE.findall(_plain(name))
    if not words:
        return None
    return PressureReference.ABSOLUTE if words[0][0] == "a" else PressureReference.GAUGE


# Degrees: columns that span less are no crank angles, those that span more are whole revolutions.
_LEAST_TURN, _WHOLE_TURN = 20.0, 350.0
_AFTER_TDC = 15.0  # degrees behind TDC at which pressures peak, about
_FEWEST_CYCLES = 3  # columns without names that are taken for cycles of one engine, if they are this similar
_SIMILAR = 0.9


class Columns(NamedTuple):
    """Crank angle and pressure as they stand in the file, and what its headings say of them."""

    angles: Floats  #: (n,) in the order of the file
    pressures: Floats  #: (n, m), a column per cycle
    unit: PressureUnit | None
    reference: PressureReference | None
    chosen: dict[str, str | int]  #: the columns that no key gave, as values of their keys


def trace_columns(table: TraceTable, keys: TraceKeys) -> Columns:
    """Choose columns by keys, names or content. Raises `InvalidValue`: a key names none, or several fit."""
    chosen: dict[str, str | int] = {}
    trigger = _given(table, "trigger_column", keys.trigger_column)
    time = _given(table, "time_column", keys.time_column)
    angle = _given(table, "angle_column", keys.angle_column)
    pressure = _given(table, "pressure_column", keys.pressure_column)
    if not angle and not trigger:
        angle = [_angle(table, pressure)]
        if not _is_angle(table.names[angle[0]]) and len(table.numbers) != 2:
            chosen["angle_column"] = angle[0] + 1
    if not pressure:
        pressure = _pressure(table, {*angle, *trigger, *time})
        first, last = pressure[0] + 1, pressure[-1] + 1
        if not _is_pressure(table.names[first - 1]) and (last > first or len(table.numbers) != 2):
            chosen["pressure_column"] = first if first == last else f"{first}-{last}"
    pressures = np.stack([table.column(i) for i in pressure], axis=1)
    name = table.names[pressure[0]]
    if keys.gain_bar_V is not None:
        pressures, name = keys.gain_bar_V * (pressures - (keys.offset_V or 0.0)), "pressure [bar]"
    if trigger:
        times = table.column(time[0]) if time else np.arange(len(pressures), dtype=np.float64)
        turned = _turned(times, table.column(trigger[0]), keys.trigger_pulses or 1, table.source)
        angles, pressures = _at_equal_steps(turned, pressures)
    else:
        angles = table.column(angle[0])
    documented = angle and table.names[angle[0]] == DOCUMENTED[0]
    documented = documented and (name == DOCUMENTED[1] or speed_of(name) is not None)
    unit = keys.pressure_unit or _unit_of(name, table.source)
    by_name = PressureReference.GAUGE if documented else _reference_of(name)
    return Columns(angles, pressures, unit, keys.pressure_reference or by_name, chosen)


def _turned(times: Floats, signal: Floats, pulses: int, source: str) -> Floats:
    """Crank angles (n,) of times by the rises of a trigger, NaN before the first and after the last one."""
    require(bool((np.diff(times) > 0).all()), "engine.time_column", source, "must increase from line to line")
    middle = (signal.min() + signal.max()) / 2
    before = np.flatnonzero((signal[:-1] < middle) & (signal[1:] >= middle))
    rule = f"has {len(before)} pulses in its trigger column: a revolution takes {pulses + 1}"
    remedy = "Choose the column with trigger_column, and the pulses of a revolution with trigger_pulses."
    require(len(before) > pulses, "engine.gas", source, rule, remedy)
    share = (middle - signal[before]) / (signal[before + 1] - signal[before])
    rises = times[before] + share * (times[before + 1] - times[before])
    angles = np.arange(len(rises)) * (_REVOLUTION / pulses)
    return np.asarray(np.interp(times, rises, angles, left=np.nan, right=np.nan), dtype=np.float64)


def _at_equal_steps(angles: Floats, pressures: Floats) -> tuple[Floats, Floats]:
    """Angles from 0 on, in equal steps that divide a revolution, and the pressures (m, k) there."""
    turning = np.isfinite(angles)
    angles, pressures = angles[turning], pressures[turning]
    places = np.ceil(_REVOLUTION / np.median(np.diff(angles)))
    count = round(float(angles[-1]) * places / _REVOLUTION)
    at = np.arange(count) * (_REVOLUTION / places)
    return at, np.stack([np.interp(at, angles, column) for column in pressures.T], axis=1)


def _given(table: TraceTable, key: str, value: str | int | None) -> list[int]:
    """Columns (from 0) that a key names; none without a key."""
    if value is None:
        return []
    columns = [i for i, name in enumerate(table.names) if name and name == value]
    if not columns and (isinstance(value, int) or value.isdecimal()):
        columns = [int(value) - 1]
    elif not columns and key == "pressure_column":
        first, _, last = (part.strip() for part in str(value).partition("-"))
        if first.isdecimal() and last.isdecimal():
            columns = list(range(int(first) - 1, min(int(last), 10_000)))
    remedy = f"{table.source} has these columns of numbers: {_listed(table, table.numbers)}."
    valid, rule = bool(columns) and set(columns) <= set(table.numbers), "does not name a column of numbers"
    require(valid, f"engine.{key}", value, rule, remedy)
    return columns


def _compressing(
    table: TraceTable, angles: Sequence[int], pressures: Sequence[int]
) -> tuple[int, int] | None:
    """Return the first columns, of crank angle and of pressure, that show a compression; None: none do."""
    pairs = ((angle, pressure) for angle, pressure in product(angles, pressures) if angle != pressure)
    return next((pair for pair in pairs if _compresses(*map(table.column, pair))), None)


def _compresses(angles: Floats, pressures: Floats) -> bool:
    whole = angles < angles[0] + _CYCLE
    if np.ptp(angles) < _WHOLE_TURN or (np.diff(angles[whole]) <= 0).any():
        return False
    angles, pressures = angles[whole], pressures[whole]
    tdc = _HALF_TURN * np.round((angles[int(pressures.argmax())] - _AFTER_TDC) / _HALF_TURN)
    from_tdc = np.mod(angles - tdc + _REVOLUTION, _CYCLE) - _REVOLUTION
    order = np.argsort(from_tdc)
    fit = compression(from_tdc[order], pressures[order])
    return fit is not None and fit.is_usual


def _angle(table: TraceTable, pressures: Sequence[int]) -> int:
    turning = [i for i in table.numbers if _turns(table.column(i))]
    named = [i for i in table.numbers if _is_angle(table.names[i])]
    whole = [i for i in turning if np.ptp(table.column(i)) >= _WHOLE_TURN]
    if not named and len(whole) > 1 and (pair := _compressing(table, whole, pressures or table.numbers)):
        return pair[0]
    for i in [*(i for i in named if i in turning), *named, *whole, *turning]:
        return i
    first = table.column(table.numbers[0])
    rule = (
        f"has no column that rises like a crank angle in degrees (column {table.numbers[0] + 1} runs from "
        f"{first.min():g} to {first.max():g})"
    )
    remedy = (
        "Give the pressure over the crank angle (engine.angle_column names the column), or over time with a "
        "trigger (engine.trigger_column)."
    )
    raise InvalidValue("engine.gas", table.source, rule, remedy)


def _turns(values: Floats) -> bool:
    steps = np.diff(values)
    rising = np.count_nonzero(steps >= 0) >= 0.9 * steps.size and np.count_nonzero(steps > 0) >= 3
    return bool(rising and np.ptp(values) >= _LEAST_TURN)


def _pressure(table: TraceTable, others: set[int]) -> list[int]:
    rest = [i for i in table.numbers if i not in others]
    named = [i for i in rest if _is_pressure(table.names[i])]
    candidates = named or rest
    if len(candidates) == 1 or (not named and _are_cycles(table, candidates)):
        return candidates
    rule = f"has several columns that may be the pressure: {_listed(table, candidates)}"
    turning = [i for i in table.numbers if i in others] or list(table.numbers)
    angle, pressure = _compressing(table, turning, candidates) or (None, candidates[0])
    proposed = {"angle_column": angle, "pressure_column": pressure}
    names = {i: f'"{name}"' if name else f"{i + 1}" for i, name in enumerate(table.names)}
    settings = ", ".join(f"{key} = {names[i]}" for key, i in proposed.items() if i is not None)
    likely = "for example" if angle is None else "as compression suggests"
    raise InvalidValue("engine.gas", table.source, rule, f"Choose one, {likely}: {settings}.")


def _are_cycles(table: TraceTable, columns: list[int]) -> bool:
    if len(columns) < _FEWEST_CYCLES:
        return False
    values = np.stack([table.column(i) for i in columns])
    mean = values.mean(axis=0)
    spread = np.ptp(values, axis=1)
    if not (spread > 0).all() or not np.ptp(mean) > 0:
        return False
    alike = [float(np.corrcoef(column, mean)[0, 1]) for column in values]
    return min(alike) >= _SIMILAR and float(spread.min()) >= 0.5 * float(spread.max())


def _listed(table: TraceTable, columns: Sequence[int]) -> str:
    texts = [f"{i + 1} ({table.names[i]})" if table.names[i] else f"{i + 1}" for i in columns[:8]]
    return ", ".join(texts) + (" …" if len(columns) > len(texts) else "")
