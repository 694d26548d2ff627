"""Pressure traces from files.

The format of our own is a CSV file whose header is ``crank_deg, pressure_bar`` for a trace that holds at any
speed, or ``crank_deg, pressure_bar_800rpm, pressure_bar_3000rpm…`` for one per speed: gauge pressures, firing
TDC at 360°, lines that start with # skipped. It is read as it stands. Any other table goes to `trace_import`,
which finds out what the file does not say.
"""

import csv
import math
import re
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import replace
from importlib.resources import files
from io import StringIO
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fea.study.trace_import import REMEDY, Imported, Surroundings, import_trace
from fea.study.trace_keys import TraceKeys
from fea.study.trace_names import DOCUMENTED
from fea.study.trace_text import read_text
from fea.units import BAR, DEG, RPM
from geometry.arrays import Floats
from geometry.invalid import InvalidValue, require
from loads.trace import Trace

SHIPPED = ("leon-2001",)
# What a file of measurements may be called.
SUFFIXES = (".csv", ".txt", ".dat", ".tsv", ".asc", ".prn")
_HINT = (
    "The columns must be crank_deg and pressure_bar (gauge), or crank_deg and one pressure_bar_<rpm>rpm per "
    "speed."
)
_PER_SPEED = re.compile(r"pressure_bar_(\d+(?:\.\d+)?)rpm")
_OF_FILE = TraceKeys()
_NOWHERE = Surroundings()
# A naturally aspirated engine draws in below the atmosphere: gauge pressures that stay above it by this much,
# bar, may be absolute.
_ABOVE = 0.2
_HEADER = 2**16  # characters in which the header of our own format must stand


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
    return _own_table(text, source).trace(source)


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
    if not keys.given and _is_own(_header(text)):
        table = _own_table(text, source)
        if table.speeds or not _is_turned(table.angles):
            trace = replace(table.trace(source), source=source)
            return Imported(replace(trace, remarks=_remarks(trace)), keys)
    return import_trace(text, source, keys, around)


class _OwnTable(NamedTuple):
    """A file of our own format: lines, angles in degrees, gauge pressures in bar, speeds in rpm."""

    lines: Sequence[int]
    angles: Floats
    pressures: Floats
    speeds: list[float]

    def trace(self, source: str) -> Trace:
        """Check the samples, with their lines in the messages."""
        try:
            _require_sorted(self.lines, self.angles)
            return Trace(self.angles * DEG, self.pressures.T * BAR, np.array(self.speeds) * RPM)
        except InvalidValue as error:
            raise InvalidValue(f"{source}: {error.name}", error.value, error.rule, error.remedy) from error


def _header(text: str) -> list[str]:
    """First line that holds something; nothing where that is no line of a CSV file."""
    try:
        first = next(_rows(text[:_HEADER]), None)
    except csv.Error:
        return []
    return [] if first is None else [cell.strip() for cell in first.cells]


def _is_own(header: list[str]) -> bool:
    """Whether a header is that of our own format."""
    first, *pressures = header or [""]
    per_speed = [_PER_SPEED.fullmatch(column) is not None for column in pressures]
    return first == DOCUMENTED[0] and (pressures == [DOCUMENTED[1]] or (bool(per_speed) and all(per_speed)))


def _is_turned(angles: Floats) -> bool:
    """Whether angles count from elsewhere than the gas-exchange TDC."""
    return bool(angles.size and (angles.min() < 0 or angles.max() > 720))


def _own_table(text: str, source: str) -> _OwnTable:
    try:
        return _parsed(_rows(text), source)
    except csv.Error as error:
        raise InvalidValue("engine.gas", source, f"is not a CSV file ({error})", _HINT) from error


def _parsed(rows: Iterator[Row], source: str) -> _OwnTable:
    """Read header and rows one by one: a file may have millions of lines."""
    header = next(rows).cells
    matches = [_PER_SPEED.fullmatch(column.strip()) for column in header[1:]]
    lines, values = array("q"), array("d")
    for line, cells in rows:
        lines.append(line)
        values.extend(_numbers(cells, line, header, source))
    table = np.frombuffer(values).reshape(len(lines), len(header))
    return _OwnTable(lines, table[:, 0], table[:, 1:], [float(match[1]) for match in matches if match])


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


def _remarks(trace: Trace) -> tuple[str, ...]:
    """Say so where gauge pressures look like absolute ones."""
    least = float(trace.pressures.min()) / BAR
    if least < _ABOVE:
        return ()
    told = f"the gauge pressure in {trace.source} never falls below the atmosphere (at least {least:.3g} bar)"
    return (f'{told}: if the file holds absolute pressures, set pressure_reference = "absolute"',)
