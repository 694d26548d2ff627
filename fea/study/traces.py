"""Pressure traces from files: our own format as it stands, any other table by `trace_import`."""

import csv
import math
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import replace
from importlib.resources import files
from io import StringIO
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fea.study.trace_columns import DOCUMENTED, TraceKeys, speed_of
from fea.study.trace_import import REMEDY, Imported, Surroundings, import_trace
from fea.study.trace_table import read_text
from fea.units import BAR, DEG, RPM
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require
from loads.trace import Trace

_HINT = (
    "The columns must be crank_deg and pressure_bar (gauge), or crank_deg and one pressure_bar_<rpm>rpm per "
    "speed."
)
_HEADER = 2**16  # characters in which the header must stand


class Row(NamedTuple):
    """A line of the file that holds something.

    Attributes
    ----------
    line
        Its number.
    cells
        What stands between its commas.
    """

    line: int
    cells: list[str]


class OwnTable(NamedTuple):
    """The samples of a file.

    Attributes
    ----------
    lines
        Line of each sample.
    angles, pressures
        (n,) degrees and (n, k) bar, gauge.
    speeds
        (k,) rpm; none for a trace that holds at any speed.
    """

    lines: Sequence[int]
    angles: Floats
    pressures: Floats
    speeds: list[float]

    @property
    def is_turned(self) -> bool:
        """Whether angles count from elsewhere than the gas-exchange TDC."""
        return bool(self.angles.size and (self.angles.min() < 0 or self.angles.max() > 720))

    def trace(self, source: str) -> Trace:
        """Return the trace; an error names the line of the file.

        Raises
        ------
        InvalidValue
            The samples are not one cycle of an engine.
        """
        try:
            _require_sorted(self.lines, self.angles)
            return Trace(self.angles * DEG, self.pressures.T * BAR, np.array(self.speeds) * RPM)
        except InvalidValue as error:
            raise InvalidValue(f"{source}: {error.name}", error.value, error.rule, error.remedy) from error


def own_header(text: str) -> list[str]:
    """Names of the columns of a file in our own format; none for any other file."""
    header = _header(text)
    first, *pressures = header or [""]
    per_speed = [speed_of(column) is not None for column in pressures]
    is_own = first == DOCUMENTED[0] and (pressures == [DOCUMENTED[1]] or (bool(per_speed) and all(per_speed)))
    return header if is_own else []


def _header(text: str) -> list[str]:
    """First line that holds something; nothing where that is no line of a CSV file."""
    try:
        first = next(_rows(text[:_HEADER]), None)
    except csv.Error:
        return []
    return [] if first is None else [cell.strip() for cell in first.cells]


def own_table(text: str, source: str) -> OwnTable:
    """Read the samples of a file in our own format; `source` is its name in messages.

    Raises
    ------
    InvalidValue
        A line does not have the form of the header; the message names it.
    """
    try:
        return _parsed(_rows(text), source)
    except csv.Error as error:
        raise InvalidValue("engine.gas", source, f"is not a CSV file ({error})", _HINT) from error


def _parsed(rows: Iterator[Row], source: str) -> OwnTable:
    """Read header and rows one by one: a file may have millions of lines."""
    header = next(rows).cells
    speeds = [speed for column in header if (speed := speed_of(column.strip())) is not None]
    lines, values = array("q"), array("d")
    for line, cells in rows:
        lines.append(line)
        values.extend(_numbers(cells, line, header, source))
    table = np.frombuffer(values).reshape(len(lines), len(header))
    return OwnTable(lines, table[:, 0], table[:, 1:], speeds)


def _rows(text: str) -> Iterator[Row]:
    """Lines that are neither blank nor comments."""
    reader = csv.reader(StringIO(text, newline=None))
    for cells in reader:
        if any(cell.strip() for cell in cells) and not cells[0].lstrip().startswith("#"):
            yield Row(reader.line_num, cells)


def _numbers(cells: list[str], line: int, header: list[str], source: str) -> list[float]:
    where = f"{source} line {line}"
    require(len(cells) == len(header), where, ",".join(cells), f"must have {len(header)} columns", _HINT)
    try:
        values = [float(cell) for cell in cells]
    except ValueError:
        values = [math.nan]
    if not all(map(math.isfinite, values)):
        for cell, column in zip(cells, header, strict=True):
            _require_number(cell, f"{where}, {column.strip()}")
    return values


def _require_number(cell: str, name: str) -> None:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    require(math.isfinite(value), name, cell.strip(), "must be a finite number, with a decimal point")


def _require_sorted(lines: Sequence[int], angles: Floats) -> None:
    """Require increasing angles, as `Trace` does; here the message can name the line."""
    back = np.flatnonzero(np.diff(angles) <= 0)
    if back.size:
        i = int(back[0])
        raise InvalidValue(
            f"line {lines[i + 1]}, crank_deg",
            float(angles[i + 1]),
            f"must increase from line to line (it follows {angles[i]:g})",
            "Sort the lines and drop repeated angles.",
        )


SHIPPED = ("leon-2001",)
# What a file of measurements may be called.
SUFFIXES = (".csv", ".txt", ".dat", ".tsv", ".asc", ".prn")
_OF_FILE = TraceKeys()
_NOWHERE = Surroundings()
# A naturally aspirated engine draws in below the atmosphere: gauge pressures that stay above it by this much,
# bar, may be absolute.
_ABOVE = 0.2


def shipped_trace(name: str) -> Trace:
    """Load a trace that comes with the program, by a name of `SHIPPED`.

    Raises
    ------
    InvalidValue
        There is no trace of that name.
    """
    require(name in SHIPPED, "engine.gas", name, f"must be one of {', '.join(SHIPPED)} or a CSV file")
    source = f"{name}-gas.csv"
    text = (files("fea") / "studies" / source).read_text(encoding="utf-8")
    return own_table(text, source).trace(source)


def read_trace(path: Path, keys: TraceKeys = _OF_FILE, around: Surroundings = _NOWHERE) -> Imported:
    """Read a user's trace.

    Parameters
    ----------
    path
        The file.
    keys
        How to read it, as far as the study says.
    around
        What else the study says of the gas.

    Raises
    ------
    InvalidValue
        The file cannot be read or contains no cycle; the message names file, line, value and rule.
    """
    return parse_trace(read_text(path, REMEDY), path.name, keys, around)


def parse_trace(
    text: str, source: str, keys: TraceKeys = _OF_FILE, around: Surroundings = _NOWHERE
) -> Imported:
    """Turn the text of a file into a trace; `source` is its name in messages."""
    header = own_header(text)
    if header and not keys.given:
        table = own_table(text, source)
        if not table.is_turned:
            trace = replace(table.trace(source), source=source)
            return Imported(replace(trace, remarks=_remarks(trace)), keys)
    columns = [column for column in header if speed_of(column) is not None]
    if columns and keys.pressure_column is None:
        return _import_speeds(text, source, columns, keys, around)
    return import_trace(text, source, keys, around)


def _import_speeds(
    text: str, source: str, columns: list[str], keys: TraceKeys, around: Surroundings
) -> Imported:
    """Import a column per speed; what is found out for the first holds for all."""
    first = import_trace(text, source, replace(keys, pressure_column=columns[0]), around)
    rest = [
        import_trace(text, source, replace(first.keys, pressure_column=column), around).trace
        for column in columns[1:]
    ]
    trace = Trace(
        first.trace.crank_angles,
        np.concatenate([first.trace.pressures, *(other.pressures for other in rest)]),
        np.array([speed_of(column) for column in columns], dtype=np.float64) * RPM,
        source,
        first.trace.remarks,
    )
    return Imported(trace, replace(first.keys, pressure_column=None))


def _remarks(trace: Trace) -> tuple[str, ...]:
    """Say so where gauge pressures look like absolute ones."""
    least = float(trace.pressures.min()) / BAR
    if least < _ABOVE:
        return ()
    told = f"the gauge pressure in {trace.source} never falls below the atmosphere (at least {least:.3g} bar)"
    return (f'{told}: if the file holds absolute pressures, set pressure_reference = "absolute"',)
