"""Pressure traces from CSV files.

A header names the columns: ``crank_deg, pressure_bar`` for a trace that holds at any speed, or
``crank_deg, pressure_bar_800rpm, pressure_bar_3000rpm…`` for one per speed. Pressures are gauge.
Blank lines and lines that start with # are skipped.
"""

import csv
import math
import re
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fea.study.paths import require_size
from fea.units import BAR, DEG, RPM
from geometry.invalid import InvalidValue, require
from loads.trace import Trace

SHIPPED = ("leon-2001",)
_HINT = (
    "The columns must be crank_deg and pressure_bar (gauge), or crank_deg and one pressure_bar_<rpm>rpm per "
    "speed."
)
LARGEST_TRACE = 2**24  # bytes: enough for a hundred samples per degree at fifty speeds
_PER_SPEED = re.compile(r"pressure_bar_(\d+(?:\.\d+)?)rpm")


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
    text = (files("fea") / "studies" / f"{name}-gas.csv").read_text(encoding="utf-8")
    return parse_trace(text, f"{name}-gas.csv")


def read_trace(path: Path) -> Trace:
    """Read a user's trace.

    Raises
    ------
    InvalidValue
        The file cannot be read or does not contain a cycle; the message names file, line, value and rule.
    """
    try:
        require_size("engine.gas", path, LARGEST_TRACE)
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not a text file in UTF-8"
        raise InvalidValue("engine.gas", str(path), f"cannot be read ({reason})", _HINT) from error
    return parse_trace(text, path.name)


def parse_trace(text: str, source: str) -> Trace:
    """Turn the text of a CSV file into a trace; `source` is its name in messages."""
    try:
        rows = list(_rows(text))
    except csv.Error as error:
        raise InvalidValue("engine.gas", source, f"is not a CSV file ({error})", _HINT) from error
    require(bool(rows), "engine.gas", source, "contains no data", _HINT)
    header, samples = rows[0].cells, rows[1:]
    speeds = _speeds([column.strip() for column in header], source)
    values = [_numbers(cells, line, header, source) for line, cells in samples]
    table = np.array(values, dtype=np.float64).reshape(len(values), len(header))
    try:
        _require_sorted(samples, values)
        return Trace(table[:, 0] * DEG, table[:, 1:].T * BAR, np.array(speeds) * RPM)
    except InvalidValue as error:
        raise InvalidValue(f"{source}: {error.name}", error.value, error.rule, error.remedy) from error


def _rows(text: str) -> Iterator[Row]:
    """Lines that are neither blank nor comments."""
    reader = csv.reader(text.splitlines())
    for cells in reader:
        if any(cell.strip() for cell in cells) and not cells[0].lstrip().startswith("#"):
            yield Row(reader.line_num, cells)


def _speeds(header: list[str], source: str) -> list[float]:
    """Speeds in rpm named by the header; none for a trace that holds at any speed."""
    first, *pressures = header
    name = f"{source}: header"
    rule = "is not the header of a pressure trace"
    require(first == "crank_deg" and bool(pressures), name, ",".join(header), rule, _HINT)
    if pressures == ["pressure_bar"]:
        return []
    rule = "must have no other column with pressure_bar"
    require("pressure_bar" not in pressures, name, ",".join(header), rule, _HINT)
    matches = [_PER_SPEED.fullmatch(column) for column in pressures]
    for column, match in zip(pressures, matches, strict=True):
        require(match is not None, name, column, "is not a known column", _HINT)
    return [float(match[1]) for match in matches if match]


def _numbers(cells: list[str], line: int, header: list[str], source: str) -> list[float]:
    where = f"{source} line {line}"
    require(len(cells) == len(header), where, ",".join(cells), f"must have {len(header)} columns", _HINT)
    return [_number(cell, f"{where}, {column.strip()}") for cell, column in zip(cells, header, strict=True)]


def _number(cell: str, name: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    require(math.isfinite(value), name, cell.strip(), "must be a finite number, with a decimal point")
    return value


def _require_sorted(samples: list[Row], values: list[list[float]]) -> None:
    """Require increasing angles, as `Trace` does; here the message can name the line."""
    for row, previous, current in zip(samples[1:], values, values[1:], strict=False):
        require(
            current[0] > previous[0],
            f"line {row.line}, crank_deg",
            current[0],
            f"must increase from line to line (it follows {previous[0]:g})",
            "Sort the lines and drop repeated angles.",
        )
