"""Which columns of a table are crank angle and cylinder pressure."""

from typing import NamedTuple

import numpy as np

from fea.study.trace_keys import TraceKeys
from fea.study.trace_names import is_angle, is_pressure
from fea.study.trace_table import Table
from geometry.arrays import Floats
from geometry.invalid import InvalidValue, require

# Degrees: columns that span less are no crank angles, those that span more are whole revolutions.
_LEAST_TURN, _REVOLUTION = 20.0, 350.0
_FEWEST_CYCLES = 3  # columns without names that are taken for cycles of one engine, if they are this similar
_SIMILAR = 0.9


class Columns(NamedTuple):
    """Crank angle and pressure as they stand in the file.

    Attributes
    ----------
    angles
        (n,) as in the file, in its order.
    pressures
        (n, m): one column, or one per cycle.
    angle_name, pressure_name
        Headings, "" where the file has none.
    found
        The columns that were found out, as values of their keys.
    """

    angles: Floats
    pressures: Floats
    angle_name: str
    pressure_name: str
    found: dict[str, str | int]


def trace_columns(table: Table, keys: TraceKeys) -> Columns:
    """Choose the columns by the keys, by their names, or by what they contain.

    Raises
    ------
    InvalidValue
        A key names no column, or several columns may be meant.
    """
    found: dict[str, str | int] = {}
    angle = _given(table, "angle_column", keys.angle_column)
    if not angle:
        angle = [_angle(table)]
        found |= _note("angle_column", table, angle)
    pressure = _given(table, "pressure_column", keys.pressure_column)
    if not pressure:
        pressure = _pressure(table, angle[0])
        found |= _note("pressure_column", table, pressure)
    return Columns(
        angles=table.column(angle[0]),
        pressures=np.stack([table.column(i) for i in pressure], axis=1),
        angle_name=table.names[angle[0]],
        pressure_name=table.names[pressure[0]],
        found=found,
    )


def _note(key: str, table: Table, columns: list[int]) -> dict[str, str | int]:
    """The value of a key for columns that no key gave; nothing where their name tells it."""
    name = table.names[columns[0]]
    known = is_angle(name) if key == "angle_column" else is_pressure(name)
    if known or (len(columns) == 1 and len(table.numbers) == 2):
        return {}
    return {key: columns[0] + 1 if len(columns) == 1 else f"{columns[0] + 1}-{columns[-1] + 1}"}


def _given(table: Table, key: str, value: str | int | None) -> list[int]:
    """Return the columns (from 0) that a key names; none without a key."""
    if value is None:
        return []
    columns = [i for i, name in enumerate(table.names) if name and name == value]
    if not columns and (isinstance(value, int) or value.isdecimal()):
        columns = [int(value) - 1]
    elif not columns and key == "pressure_column":
        columns = _range(str(value))
    remedy = f"{table.source} has these columns of numbers: {_listed(table, table.numbers)}."
    require(
        bool(columns) and set(columns) <= set(table.numbers),
        f"engine.{key}",
        value,
        "does not name a column of numbers",
        remedy,
    )
    return columns


def _range(value: str) -> list[int]:
    """Columns of a range: ``"2-61"``."""
    first, dash, last = value.partition("-")
    if not dash or not (first.strip().isdecimal() and last.strip().isdecimal()):
        return []
    return list(range(int(first) - 1, min(int(last), 10_000)))


def _angle(table: Table) -> int:
    """The column that is named as a crank angle, or the first one that turns like one."""
    turning = [i for i in table.numbers if _turns(table.column(i))]
    named = [i for i in table.numbers if is_angle(table.names[i])]
    whole = [i for i in turning if np.ptp(table.column(i)) >= _REVOLUTION]
    for i in [*(i for i in named if i in turning), *named, *whole, *turning]:
        return i
    first = table.column(table.numbers[0])
    rule = (
        f"has no column that rises like a crank angle in degrees (column {table.numbers[0] + 1} runs from "
        f"{first.min():g} to {first.max():g})"
    )
    remedy = "Give the pressure over the crank angle, not over time; engine.angle_column names the column."
    raise InvalidValue("engine.gas", table.source, rule, remedy)


def _turns(values: Floats) -> bool:
    """Whether a column rises over most of its lines and spans a good part of a turn."""
    steps = np.diff(values)
    rising = np.count_nonzero(steps >= 0) >= 0.9 * steps.size and np.count_nonzero(steps > 0) >= 3
    return bool(rising and np.ptp(values) >= _LEAST_TURN)


def _pressure(table: Table, angle: int) -> list[int]:
    """The column named as a pressure, the only one left, or all where they are cycles of one engine."""
    rest = [i for i in table.numbers if i != angle]
    named = [i for i in rest if is_pressure(table.names[i])]
    if len(named) == 1:
        return named
    candidates = named or rest
    if len(candidates) == 1:
        return candidates
    if not named and _are_cycles(table, candidates):
        return candidates
    rule = f"has several columns that may be the pressure: {_listed(table, candidates)}"
    remedy = f"Choose one, for example: pressure_column = {_key(table, candidates[0])}."
    raise InvalidValue("engine.gas", table.source, rule, remedy)


def _are_cycles(table: Table, columns: list[int]) -> bool:
    """Whether columns repeat each other as the cycles of one engine do."""
    if len(columns) < _FEWEST_CYCLES:
        return False
    values = np.stack([table.column(i) for i in columns])
    mean = values.mean(axis=0)
    spread = np.ptp(values, axis=1)
    if not (spread > 0).all() or not np.ptp(mean) > 0:
        return False
    alike = [float(np.corrcoef(column, mean)[0, 1]) for column in values]
    return min(alike) >= _SIMILAR and float(spread.min()) >= 0.5 * float(spread.max())


def _key(table: Table, column: int) -> str:
    return f'"{table.names[column]}"' if table.names[column] else f"{column + 1}"


def _listed(table: Table, columns: "tuple[int, ...] | list[int]") -> str:
    """Name some columns."""
    texts = [f"{i + 1} ({table.names[i]})" if table.names[i] else f"{i + 1}" for i in columns[:8]]
    return ", ".join(texts) + (" …" if len(columns) > len(texts) else "")
