"""TOML tables as frozen dataclasses; errors name unknown keys and values of the wrong type."""

import dataclasses
import difflib
import types
import typing
from collections.abc import Iterable, Mapping
from enum import StrEnum
from typing import Any, TypeVar

from geometry.errors import InvalidValue, is_finite, shown

Table = TypeVar("Table")

_LARGEST = 1e12
_WORDS = {float: "a number", int: "a whole number", str: "text", bool: "true or false"}


def unknown_key(where: str, key: str, valid: Iterable[str]) -> InvalidValue:
    """Return the error for a key that does not exist, which suggests the nearest one and lists all."""
    return InvalidValue(f"{where} {shown(key)}", None, "is an unknown key", nearest(key, valid))


def nearest(word: str, valid: Iterable[str]) -> str:
    """Return the remedy for a word that is not in `valid`: the nearest one, then all of them."""
    names = sorted(valid)
    near = difflib.get_close_matches(word, names, n=1)
    return (f"Did you mean {near[0]}? " if near else "") + "Valid names: " + ", ".join(names) + "."


def read_table(cls: type[Table], where: str, raw: object) -> Table:
    """Make the dataclass `cls` from a TOML table.

    Parameters
    ----------
    cls
        Its fields are the valid keys, with the types of their annotations.
    where
        The table's name, for messages.
    raw
        The value from the TOML parser.

    Raises
    ------
    InvalidValue
        Not a table, an unknown or a missing key, or a value of the wrong type.
    """
    if not isinstance(raw, Mapping):
        raise InvalidValue(where, raw, f"must be a table, [{where}]")
    hints = typing.get_type_hints(cls)
    values = {}
    for key, value in raw.items():
        if key not in hints:
            raise unknown_key(f"[{where}]", key, hints)
        values[key] = checked(f"{where}.{key}", value, hints[key])
    for name in required(cls):
        if name not in values:
            raise InvalidValue(f"{where}.{name}", None, "is missing", f"Give it in [{where}].")
    return cls(**values)


def required(cls: Any) -> list[str]:
    """Return the names of the fields without a default."""
    absent = dataclasses.MISSING
    return [
        field.name
        for field in dataclasses.fields(cls)
        if field.default is absent and field.default_factory is absent
    ]


def checked(name: str, value: object, hint: Any) -> Any:
    """Return `value` as the annotated type `hint`, or raise `InvalidValue`.

    Numbers that are not finite are refused, and so are numbers beyond the size of any quantity of an engine
    in any unit: their squares or quotients might overflow.
    """
    if isinstance(value, Mapping) and typing.get_origin(hint) is dict:
        _, inner = typing.get_args(hint)
        return {key: checked(f"{name}.{key}", entry, inner) for key, entry in value.items()}
    for number in value if isinstance(value, list | tuple) else [value]:
        if isinstance(number, int | float):
            _require_size(name, number)
    options = [option for option in _options(hint) if option is not types.NoneType]
    for option in options:
        converted = _convert(value, option)
        if converted is not None:
            return converted
    choices = [choice for option in options if _is_enum(option) for choice in option]
    if choices:
        beside = " or give a number" if float in options else ""
        remedy = f"Choose from {', '.join(choices)}{beside}."
        raise InvalidValue(name, value, "is not a valid choice", remedy)
    raise InvalidValue(name, value, f"must be {' or '.join(_word(option) for option in options)}")


def number(name: str, value: float | None) -> float | None:
    """Return the number of a flag, or None if it is not given; checked like a number in a table."""
    return None if value is None else float(checked(name, value, float))


def _require_size(name: str, number: float) -> None:
    if not is_finite(number):
        raise InvalidValue(name, number, "must be a finite number")
    if number and not 1 / _LARGEST <= abs(number) <= _LARGEST:
        rule = f"its magnitude must be 0 or between {1 / _LARGEST:g} and {_LARGEST:g}"
        raise InvalidValue(name, number, rule, "Give it in the unit that the key names.")


def _options(hint: Any) -> tuple[Any, ...]:
    return typing.get_args(hint) if isinstance(hint, types.UnionType) else (hint,)


def _is_enum(option: Any) -> bool:
    return isinstance(option, type) and issubclass(option, StrEnum)


def _word(option: Any) -> str:
    if typing.get_origin(option) is dict:
        return "a table"
    if typing.get_origin(option) is tuple:
        return f"a list of {_WORDS[typing.get_args(option)[0]].removeprefix('a ')}s"
    return _WORDS[option]


def _convert(value: object, option: Any) -> Any:
    """Return `value` as `option`, or None if it is of another type."""
    if typing.get_origin(option) is tuple:
        item = typing.get_args(option)[0]
        if not isinstance(value, list | tuple):
            return None
        converted = tuple(_convert(entry, item) for entry in value)
        return None if None in converted else converted
    if _is_enum(option):
        return option(value) if value in list(option) else None
    if option is float:
        return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
    if option is int and isinstance(value, bool):
        return None
    return value if isinstance(option, type) and isinstance(value, option) else None


def entries_of(table: Any) -> dict[str, Any]:
    """Return the fields of a table that say something, by name; those that are None or empty are left out."""
    values = {field.name: getattr(table, field.name) for field in dataclasses.fields(table)}
    return {name: value for name, value in values.items() if value not in (None, (), {})}


def toml_text(tables: Mapping[str, Any]) -> str:
    """Return tables of plain values as TOML text."""
    import tomli_w  # noqa: PLC0415 - only a study that is written needs it

    return tomli_w.dumps(tables)
