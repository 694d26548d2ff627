"""Figures as JSON, and back; the figures of a run on disk, and the file of it that shows what governs."""

import dataclasses
import json
import math
import types
import typing
from collections.abc import Iterator, Mapping
from enum import Enum
from functools import cache
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np

from fea.analysis.figures import ONLY_WHERE_KNOWN, SCHEMA
from fea.analysis.summary_figures import Summary
from fea.base.checks import Check
from fea.base.note import Note, NoteKind, omission, warning
from fea.judge.safety_factor import SafetyFactor
from fea.output.folder import SUMMARY
from geometry.errors import InvalidValue, require

JsonObject = dict[str, Any]
DIGITS = 6  # beyond what any input is known to, and enough to compare two runs
IN_FULL = ("loads",)  # tables from which equilibrium can be checked anew
FULL = 17


def json_text(value: object, digits: int = DIGITS) -> str:
    """Return `value` as indented JSON that any parser reads, the same text for the same figures.

    Dataclasses, mappings, sequences, NumPy arrays and scalars, enums, paths, text, numbers and None are
    allowed; what is not finite is ``null``. Numbers have so many significant digits; the components of a
    vector are rounded alike, to those of the largest, so that a coordinate of 3e-15 mm beside one of 141 mm
    is 0. Raises `TypeError`: a value of another type.
    """
    return _indented(_plain(value, digits), "") + "\n"


def _plain(value: object, digits: int) -> Any:  # noqa: PLR0911 - one line a type
    if dataclasses.is_dataclass(value):
        return _plain(_fields(value), digits)
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist(), digits)
    if isinstance(value, Enum):
        return _plain(value.value, digits)
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return float(f"{value:.{digits}g}") + 0.0 if math.isfinite(value) else None  # + 0.0: no minus zero
    if isinstance(value, Mapping):
        return {
            str(key): _plain(item, FULL if key in IN_FULL and isinstance(item, Mapping) else digits)
            for key, item in value.items()
        }
    if isinstance(value, PathLike):
        return fspath(value)
    if isinstance(value, list | tuple):
        numbers = any(isinstance(item, float | np.floating) for item in value)
        if numbers and len(value) <= 3 and digits < FULL:
            return _vector(value, digits)
        return [_plain(item, digits) for item in value]
    raise TypeError(f"{value!r} has no JSON form: give a mapping, a sequence, a number, text or None.")


def _fields(value: Any) -> JsonObject | str:
    """Return the fields of a dataclass by their names; a check and a note have forms of their own."""
    if isinstance(value, Check):
        return {"value": value.value, "limit": value.limit, "pass": value.passed}
    if isinstance(value, Note):
        omitted = value.kind is NoteKind.OMISSION
        return {"what": value.topic, "why": value.text} if omitted else str(value)
    hints = _hints(typing.cast("type", type(value)))
    values = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
    optional = {name for name in values if ONLY_WHERE_KNOWN in getattr(hints[name], "__metadata__", ())}
    written = {}
    for name, item in values.items():
        if item is not None or name not in optional:
            written[name] = item
        if isinstance(item, SafetyFactor):
            written |= {f"{name}_low": item.low, f"{name}_high": item.high}
    return written


def json_lines(content: bytes) -> Iterator[tuple[JsonObject, int]]:
    """Yield the objects of a journal, one a line, and where each ends; without one that was not completed."""
    end = 0
    for line in content.splitlines(keepends=True):
        end += len(line)
        try:
            yield json.loads(line), end
        except ValueError:  # the program ended while it was written
            return


def as_dict(value: Any) -> Any:
    """Return figures as dictionaries and lists, unrounded: what a program reads of `summary.json`.

    Fields that are None are left out where they are declared as `fea.analysis.figures.WhereKnown`.
    """
    return _plain(value, FULL)


def read_summary(folder: Path) -> Summary:
    """Read a run's figures. Raises `OSError`: no `summary.json`; `ValueError`: not of this version."""
    raw = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    if not isinstance(raw, dict) or raw.get("schema") != SCHEMA:
        raise ValueError("it is not of a run of this version")
    try:
        summary: Summary = _read(Summary, raw)
    except (TypeError, KeyError, AttributeError) as error:
        raise ValueError(f"it is damaged: {error}") from error
    return dataclasses.replace(summary, notes=_notes(summary))


def _notes(summary: Summary) -> tuple[Note, ...]:
    """Return the notes with their kinds and topics, which their texts alone do not say."""
    kinds = summary.note_kinds or ()
    if len(kinds) != len(summary.notes):
        return summary.notes
    each = zip(kinds, summary.notes, strict=True)
    return tuple(
        Note(NoteKind(kind), topic, note.text.removeprefix(f"{topic}: ")) for (kind, topic), note in each
    )


@cache
def _hints(kind: type) -> JsonObject:
    return typing.get_type_hints(kind, include_extras=True)


def _read(hint: Any, raw: Any) -> Any:  # noqa: PLR0911 - one return per kind of type
    if isinstance(hint, types.UnionType) or typing.get_origin(hint) is typing.Union:
        return None if raw is None else _read_either([h for h in hint.__args__ if h is not type(None)], raw)
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Annotated:
        return _read(arguments[0], raw)
    if hint is Check:
        return Check(raw["value"], raw["limit"])
    if hint is Note:
        return omission(raw["what"], raw["why"]) if isinstance(raw, dict) else warning(raw)
    if dataclasses.is_dataclass(hint):
        kind = typing.cast("type", hint)
        return kind(**{key: _read(_hints(kind)[key], item) for key, item in _folded(kind, raw).items()})
    if origin is tuple:
        return tuple(_read(arguments[0], item) for item in raw)
    if origin is not None and issubclass(origin, Mapping):
        return {key: _read(arguments[1], item) for key, item in raw.items()}
    return math.inf if raw is None and hint is float else raw  # JSON has no infinity


def _read_either(hints: list[Any], raw: Any) -> Any:
    for hint in hints:
        fields = {f.name for f in dataclasses.fields(hint)} if dataclasses.is_dataclass(hint) else None
        if fields is None or fields >= _folded(hint, raw).keys():
            return _read(hint, raw)
    raise KeyError(", ".join(raw))


def _folded(kind: type, raw: Mapping[str, Any]) -> JsonObject:
    """Return fields in which each safety factor has its interval, which files name beside it."""
    fields = dict(raw)
    for name in getattr(kind, "factor_names", ()):
        low, high = fields.pop(f"{name}_low", None), fields.pop(f"{name}_high", None)
        if low is not None:  # JSON has no infinity
            fields[name] = SafetyFactor(fields[name], low, math.inf if high is None else high)
    return fields


def _vector(values: list[Any] | tuple[Any, ...], digits: int) -> list[Any]:
    """Return the components of a vector, all rounded to the last digit of the largest."""
    plain = [_plain(item, FULL) for item in values]
    finite = [abs(item) for item in plain if isinstance(item, float | int)]
    largest = max(finite, default=0.0)
    if largest == 0:
        return plain
    decimals = digits - 1 - math.floor(math.log10(largest))
    return [round(item, decimals) + 0.0 if isinstance(item, float) else item for item in plain]


def _indented(value: Any, indent: str) -> str:
    """Return JSON with one key a line, and what holds no mapping on the line of its key."""
    deeper = indent + "  "
    if isinstance(value, dict) and value:
        lines = [f"{deeper}{json.dumps(key)}: {_indented(item, deeper)}" for key, item in value.items()]
        return "{\n" + ",\n".join(lines) + f"\n{indent}}}"
    if isinstance(value, list) and any(isinstance(item, dict) for item in value):
        return "[\n" + ",\n".join(deeper + _indented(item, deeper) for item in value) + f"\n{indent}]"
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


STUDY = "study.toml"
AGAIN = "Repeat the run: fea run study.toml."


def run_summary(folder: Path) -> Summary:
    """Return the figures of a run of one speed. Raises `InvalidValue`: the folder holds none."""
    remedy = "Name the folder that fea run has written, such as results/leon-2001-6000rpm."
    require(folder.is_dir(), "RUN", str(folder), "is not a directory", remedy)
    speeds = sorted(place.parent.name for place in folder.glob(f"*/{SUMMARY}"))
    if speeds and not (folder / SUMMARY).is_file():
        rule = f"holds runs at several speeds: {', '.join(speeds[:8])}"
        raise InvalidValue("RUN", str(folder), rule, f"Name one of them, such as {folder / speeds[0]}.")
    try:
        summary = read_summary(folder)
    except (OSError, ValueError) as error:
        raise InvalidValue("RUN", str(folder), f"has no readable {SUMMARY} ({error})", remedy) from error
    require((folder / STUDY).is_file(), "RUN", str(folder), f"has no {STUDY}", remedy)
    return summary


def governing_run(folder: Path) -> tuple[Path, Summary]:
    """Return the folder of a run, of several speeds the worst, and its summary; raises as `run_summary`."""
    one = (folder / SUMMARY).is_file()
    speeds = [] if one else sorted(place.parent for place in folder.glob(f"*/{SUMMARY}"))
    runs = [(place, run_summary(place)) for place in speeds or [folder]]
    return min(runs, key=lambda run: run[1].survival.assured_safety_factor)


def governing_file(folder: Path) -> tuple[Path, Summary]:
    """Return the result file that shows what governs a run, of several speeds the worst, and its summary.

    Raises `InvalidValue`: see `run_summary`, or its fields were not kept.
    """
    place, summary = governing_run(folder)
    vtu, rule = place / f"{summary.governing_result}.vtu", "is missing, which shows what governs"
    require(vtu.is_file(), "RUN", str(vtu), rule, AGAIN)
    return vtu, summary
