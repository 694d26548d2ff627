"""Which columns of a table are crank angle and cylinder pressure."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np

from fea.base.choices import PressureReference, PressureUnit
from fea.study.tables import Table, key, keys_of, within
from fea.study.toml_files import TomlTable
from fea.study.trace_table import TraceTable
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require, require_positive
from loads.compression import compression

_ANGLES = {
    *("crank", "crankangle", "crankshaft", "ca", "cad", "deg", "degca", "cadeg", "degree", "degrees"),
    *("theta", "phi", "φ", "θ", "angle", "angolo", "angulo", "vilebrequin", "winkel", "kurbelwinkel", "kw"),
    *("°ca", "°kw", "°", "曲轴转角", "转角"),
}
_PRESSURES = {
    *("p", "press", "pressure", "druck", "zylinderdruck", "pression", "presion", "pressione", "pressao"),
    *("cylp", "pcyl", "pzyl", "pz", "cylpress", "cylpres", "cylinderpressure", "缸压", "压力", "气缸压力"),
}
# Pressures elsewhere than in the cylinder, and quantities derived from its pressure.
_OTHERS = {
    *("intake", "inlet", "manifold", "boost", "exhaust", "oil", "fuel", "rail", "injection", "ambient"),
    *("atmosphere", "atmospheric", "rate", "dp", "derivative", "filter", "spark", "ignition", "rod"),
}
# Headings of our own format: gauge pressures.
DOCUMENTED = ("crank_deg", "pressure_bar")
_PER_SPEED = re.compile(r"pressure_bar_(\d+(?:\.\d+)?)rpm")
_UNITS = {unit.lower(): unit for unit in PressureUnit}
_REFERENCES = {
    **dict.fromkeys(("a", "abs", "absolute", "absolut", "absolu"), PressureReference.ABSOLUTE),
    **dict.fromkeys(("g", "ga", "gauge", "gage", "rel", "relative", "relativ"), PressureReference.GAUGE),
}
_BRACKETS = re.compile(r"[\[({<]([^\])}>]*)[\])}>]")


def speed_of(name: str) -> float | None:
    """Speed, rpm, of a column in our own format with one per speed."""
    match = _PER_SPEED.fullmatch(name)
    return None if match is None else float(match[1])


def is_angle(name: str) -> bool:
    """Whether a column's name is one of those that crank angles have."""
    words = _words(name)
    return bool(words & _ANGLES) and not words & _OTHERS and not is_pressure(name)


def is_pressure(name: str) -> bool:
    """Whether a column's name is one of those that cylinder pressures have."""
    words = _words(name)
    known = bool(words & _PRESSURES) or any(re.fullmatch(r"p_?(?:cyl|zyl)\w*", word) for word in words)
    return known and not words & _OTHERS


def unit_of(name: str) -> PressureUnit | None:
    """Return the unit of pressure in a column's name: in brackets, or a word or suffix of its own."""
    units = [unit for word in _ordered_words(name) if (unit := _split_unit(word)[0]) is not None]
    return units[-1] if units else None


def reference_of(name: str) -> PressureReference | None:
    """Return what a column's name says of the reference: ``bara``, ``[bar abs]``, ``psig`` or ``gauge``."""
    words = _ordered_words(name)
    units = [i for i, word in enumerate(words) if _split_unit(word)[0] is not None]
    for i in units:
        suffix = _split_unit(words[i])[1]
        if suffix in _REFERENCES:
            return _REFERENCES[suffix]
    # A single letter says something only after a unit: "bar (a)".
    for i, word in enumerate(words):
        if word in _REFERENCES and (len(word) > 2 or i - 1 in units):
            return _REFERENCES[word]
    return None


def unknown_unit(name: str) -> str:
    """Return what stands in brackets where that is not a unit of pressure, as in ``[V]``; else nothing."""
    inside = [match[1].strip() for match in _BRACKETS.finditer(name)]
    strange = [each for each in inside if each and not (unit_of(each) or reference_of(f"bar {each}"))]
    return strange[-1] if strange and unit_of(name) is None else ""


def _ordered_words(name: str) -> list[str]:
    """Words of a name in small letters; a capital after two small letters begins a word."""
    apart = re.sub(r"(?<=[a-z][a-z])(?=[A-Z])", " ", name)
    return [word for word in re.split(r"[^\w°]+|_", apart.lower()) if word]


def _words(name: str) -> set[str]:
    words = _ordered_words(_BRACKETS.sub(" ", name))
    if not words:  # those in brackets are all that the name has: ``[deg]``
        return set(_ordered_words(name))
    return set(words) | {"".join(pair) for pair in pairwise(words)}


def _split_unit(word: str) -> tuple[PressureUnit | None, str]:
    """Split a word into a unit and the letters after it: ``bara``, ``psig``."""
    for unit, value in _UNITS.items():
        if word == unit or (word.startswith(unit) and word[len(unit) :] in _REFERENCES):
            return value, word[len(unit) :]
    return None, ""


# A crank turns by this in a whole four-stroke cycle; smoothing over more than a few degrees flattens a peak.
_CYCLE_DEG = 720.0
_WIDEST_SMOOTHING = 10.0
_REVOLUTION_DEG, _HALF_TURN = 360.0, 180.0
_AFTER_TDC = 15.0  # degrees behind TDC at which pressures peak, about


@dataclass(frozen=True, kw_only=True)
class TraceKeys(Table, table="engine"):
    """How a trace is to be read; what is None is found out from the file."""

    angle_column: str | int | None = key(
        "1",
        "name or number of the column of crank angles in degrees",
        above="For a file: what its headings do not say is deduced, and the run says what it assumed. "
        "These keys decide:",
    )
    time_column: str | int | None = key(
        "1", "of a recording over time with a trigger: its times, in any unit; default: equal steps"
    )
    trigger_column: str | int | None = key(
        "3", "name or number of the column of a trigger or encoder, whose rises through its middle count"
    )
    trigger_pulses: int | None = key("1", "of it in a revolution of the crank", within(1, 7200))
    angle_offset_deg: float | None = key(
        "360.0",
        "added to the angles of the file, so that firing TDC is at 360",
        within(-_CYCLE_DEG, _CYCLE_DEG, " degrees"),
    )
    pressure_column: str | int | None = key(
        "2", 'name or number of the column of pressures; or "2-61", cycles to be averaged'
    )
    gain_bar_V: float | None = key(
        "20.0",
        "of the sensor with its amplifier, where the column of pressures holds volts",
        require_positive,
    )
    offset_V: float | None = key("0.5", "at pressure 0, with gain_bar_V; default: 0")
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
    strokes: int | None = key(
        "4",
        "of the engine, to complete a trace of a single revolution: 2 repeats it",
        lambda name, value: require(value in (2, 4), name, value, "must be 2 or 4"),
    )

    @property
    def given(self) -> TomlTable:
        """The keys that say something of how to read a trace."""
        return {name: value for name in keys_of(TraceKeys) if (value := getattr(self, name)) is not None}


# Degrees: columns that span less are no crank angles, those that span more are whole revolutions.
_LEAST_TURN, _REVOLUTION = 20.0, 350.0
_FEWEST_CYCLES = 3  # columns without names that are taken for cycles of one engine, if they are this similar
_SIMILAR = 0.9


class Columns(NamedTuple):
    """Crank angle and pressure as they stand in the file.

    Angles (n,) are in the order of the file, pressures (n, m) have a column per cycle; names are "" where the
    file has no headings. `chosen` holds the columns that no key gave, as values of their keys.
    """

    angles: Floats
    pressures: Floats
    angle_name: str
    pressure_name: str
    chosen: dict[str, str | int]

    def unit(self, keys: TraceKeys, source: str) -> PressureUnit | None:
        """Return the unit of the pressures by key or heading. Raises `InvalidValue`: that of none of ours."""
        if keys.pressure_unit is not None:
            return keys.pressure_unit
        strange = unknown_unit(self.pressure_name)
        rule = f"has pressures in an unknown unit, {strange}"
        remedy = "Convert them, or set engine.pressure_unit to bar, kPa, MPa, Pa or psi."
        require(not strange, f"{source}: column", self.pressure_name, rule, remedy)
        return unit_of(self.pressure_name)

    def reference(self, keys: TraceKeys) -> PressureReference | None:
        """Return what the pressures refer to by key or heading; our own format has gauge pressures."""
        if keys.pressure_reference is not None:
            return keys.pressure_reference
        own_format = self.pressure_name == DOCUMENTED[1] or speed_of(self.pressure_name) is not None
        if own_format and self.angle_name == DOCUMENTED[0]:
            return PressureReference.GAUGE
        return reference_of(self.pressure_name)


def trace_columns(table: TraceTable, keys: TraceKeys) -> Columns:
    """Choose columns by keys, names or content. Raises `InvalidValue`: a key names none, or several fit."""
    _require_consistent(keys)
    chosen: dict[str, str | int] = {}
    trigger = _given(table, "trigger_column", keys.trigger_column)
    time = _given(table, "time_column", keys.time_column)
    angle = _given(table, "angle_column", keys.angle_column)
    given_pressure = _given(table, "pressure_column", keys.pressure_column)
    if not angle and not trigger:
        angle = [_angle(table, given_pressure)]
        chosen |= _choice("angle_column", table, angle)
    pressure = given_pressure
    if not pressure:
        pressure = _pressure(table, {*angle, *trigger, *time})
        chosen |= _choice("pressure_column", table, pressure)
    pressures = np.stack([table.column(i) for i in pressure], axis=1)
    name = table.names[pressure[0]]
    if keys.gain_bar_V is not None:
        pressures, name = keys.gain_bar_V * (pressures - (keys.offset_V or 0.0)), "pressure [bar]"
    if not trigger:
        return Columns(table.column(angle[0]), pressures, table.names[angle[0]], name, chosen)
    times = table.column(time[0]) if time else np.arange(len(pressures), dtype=np.float64)
    turned = _turned(times, table.column(trigger[0]), keys.trigger_pulses or 1, table.source)
    return Columns(*_at_equal_steps(turned, pressures), "", name, chosen)


def _require_consistent(keys: TraceKeys) -> None:
    triggered = keys.trigger_column is not None
    rule, angle = "cannot be combined with trigger_column, which gives the angles", keys.angle_column
    require(not triggered or angle is None, "engine.angle_column", angle, rule, "Remove one of them.")
    rule, remedy = "needs trigger_column: times do not give crank angles", "Name the column of the trigger."
    for name in ("time_column", "trigger_pulses"):
        value = getattr(keys, name)
        require(triggered or value is None, f"engine.{name}", value, rule, remedy)
    rule = "needs gain_bar_V, which turns volts into pressures"
    require(keys.gain_bar_V is not None or keys.offset_V is None, "engine.offset_V", keys.offset_V, rule)
    rule, unit = "cannot be combined with gain_bar_V, which gives bar", keys.pressure_unit
    require(keys.gain_bar_V is None or unit in (None, PressureUnit.BAR), "engine.pressure_unit", unit, rule)


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
    angles = np.arange(len(rises)) * (_REVOLUTION_DEG / pulses)
    return np.asarray(np.interp(times, rises, angles, left=np.nan, right=np.nan), dtype=np.float64)


def _at_equal_steps(angles: Floats, pressures: Floats) -> tuple[Floats, Floats]:
    """Angles from 0 on, in equal steps that divide a revolution, and the pressures (m, k) there."""
    known = np.isfinite(angles)
    angles, pressures = angles[known], pressures[known]
    places = np.ceil(_REVOLUTION_DEG / np.median(np.diff(angles)))
    count = round(float(angles[-1]) * places / _REVOLUTION_DEG)
    at = np.arange(count) * (_REVOLUTION_DEG / places)
    return at, np.stack([np.interp(at, angles, column) for column in pressures.T], axis=1)


def _choice(key: str, table: TraceTable, columns: list[int]) -> dict[str, str | int]:
    name = table.names[columns[0]]
    known = is_angle(name) if key == "angle_column" else is_pressure(name)
    if known or (len(columns) == 1 and len(table.numbers) == 2):
        return {}
    return {key: columns[0] + 1 if len(columns) == 1 else f"{columns[0] + 1}-{columns[-1] + 1}"}


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
    for angle, pressure in product(angles, pressures):
        if angle != pressure and _compresses(table.column(angle), table.column(pressure)):
            return angle, pressure
    return None


def _compresses(angles: Floats, pressures: Floats) -> bool:
    whole = angles < angles[0] + _CYCLE_DEG
    if np.ptp(angles) < _REVOLUTION or (np.diff(angles[whole]) <= 0).any():
        return False
    angles, pressures = angles[whole], pressures[whole]
    tdc = _HALF_TURN * np.round((angles[int(pressures.argmax())] - _AFTER_TDC) / _HALF_TURN)
    from_tdc = np.mod(angles - tdc + _REVOLUTION_DEG, _CYCLE_DEG) - _REVOLUTION_DEG
    order = np.argsort(from_tdc)
    fit = compression(from_tdc[order], pressures[order])
    return fit is not None and fit.is_usual


def _angle(table: TraceTable, pressures: Sequence[int]) -> int:
    turning = [i for i in table.numbers if _turns(table.column(i))]
    named = [i for i in table.numbers if is_angle(table.names[i])]
    whole = [i for i in turning if np.ptp(table.column(i)) >= _REVOLUTION]
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
    named = [i for i in rest if is_pressure(table.names[i])]
    candidates = named or rest
    if len(candidates) == 1 or (not named and _are_cycles(table, candidates)):
        return candidates
    rule = f"has several columns that may be the pressure: {_listed(table, candidates)}"
    turning = [i for i in table.numbers if i in others] or list(table.numbers)
    angle, pressure = _compressing(table, turning, candidates) or (None, candidates[0])
    proposed = {"angle_column": angle, "pressure_column": pressure}
    said = ", ".join(f"{key} = {_named(table, i)}" for key, i in proposed.items() if i is not None)
    likely = "for example" if angle is None else "as compression suggests"
    remedy = f"Choose one, {likely}: {said}."
    raise InvalidValue("engine.gas", table.source, rule, remedy)


def _named(table: TraceTable, column: int) -> str:
    return f'"{table.names[column]}"' if table.names[column] else f"{column + 1}"


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
