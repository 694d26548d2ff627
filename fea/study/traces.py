"""Pressure traces from files: our own format as it stands, any other table by `trace_import`."""

from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import numpy as np

from fea.study.own_trace import own_header, own_table
from fea.study.trace_import import REMEDY, Imported, Surroundings, import_trace
from fea.study.trace_keys import TraceKeys
from fea.study.trace_names import speed_of
from fea.study.trace_text import read_text
from fea.units import BAR, RPM
from geometry.invalid import require
from loads.trace import Trace

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
