"""A run's figures as JSON."""

import json
import math
from collections.abc import Mapping
from enum import Enum
from os import PathLike, fspath
from typing import Any

import numpy as np

SCHEMA = "fea/summary/1"
DIGITS = 6  # beyond what any input is known to, and enough to compare two runs
IN_FULL = ("loads",)  # tables from which equilibrium can be checked anew
FULL = 17


def json_text(value: object, digits: int = DIGITS) -> str:
    """Return `value` as JSON that any parser reads, the same text for the same figures.

    Parameters
    ----------
    value
        Mappings, sequences, NumPy arrays and scalars, enums, paths, text, numbers, booleans, None.
    digits
        Significant digits of a number; the components of a vector are rounded alike, to those of the
        largest, so that a coordinate of 3e-15 mm beside one of 141 mm is 0.

    Returns
    -------
    str
        Indented JSON with a newline at the end. What is not finite is ``null``.

    Raises
    ------
    TypeError
        A value of another type.
    """
    return _indented(_plain(value, digits), "") + "\n"


def _plain(value: object, digits: int) -> Any:  # noqa: PLR0911 - one line a type
    """Return `value` in JSON's own types, rounded."""
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist(), digits)
    if isinstance(value, Enum):
        return _plain(value.value, digits)
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return _rounded(value, digits)
    if isinstance(value, Mapping):
        return {str(key): _plain(item, _digits(key, item, digits)) for key, item in value.items()}
    if isinstance(value, PathLike):
        return fspath(value)
    if isinstance(value, list | tuple):
        if any(isinstance(item, float | np.floating) for item in value) and len(value) <= 3:
            return _vector(value, digits)
        return [_plain(item, digits) for item in value]
    raise TypeError(f"{value!r} has no JSON form: give a mapping, a sequence, a number, text or None.")


def _digits(key: object, item: object, digits: int) -> int:
    return FULL if key in IN_FULL and isinstance(item, Mapping) else digits


def _rounded(value: float, digits: int) -> float | None:
    """Return `value` with so many significant digits; None if it is not finite."""
    return float(f"{value:.{digits}g}") + 0.0 if math.isfinite(value) else None  # + 0.0: no minus zero


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
