"""The keys of a study, each declared once: a field of a frozen dataclass, with `key` as its default.

From the declaration follow how it is read and checked, the flag that overrides it (`fea.study.flags`), the
commented study of `fea init` and the JSON Schema (`fea.study.documents`). A key that names its unit also
takes a text with another one, by the key without its unit: ``length = "5.7 in"`` for ``length_mm = 144.78``.
"""

import dataclasses
import difflib
import types
import typing
from collections.abc import Callable, Collection, Iterable, Mapping
from enum import StrEnum
from functools import cache
from typing import Annotated, Any, ClassVar, TypeVar

from fea.base.shipped import TomlTable
from fea.base.units import OTHER_UNITS, WRITTEN
from geometry.errors import InvalidValue, is_finite, require, require_number, require_positive, shown

AnyTable = TypeVar("AnyTable")
# Refuses a value, given the name of its key; called for each entry of a list.
Check = Callable[[str, Any], object]

_LARGEST = 1e12
_WORDS = {float: "a number", int: "a whole number", str: "text", bool: "true or false"}
# How units are written in keys.
_PLAIN = str.maketrans({"³": "3", "²": "2", "µ": "u", "/": "_", "·": "_", "°": None})
_SPELT = {"inches": ("in", "inch"), "lb": ("lbs",), "Mpsi": ("Msi",)}


def not_negative(name: str, value: object) -> None:
    """Refuse a number below zero."""
    require(require_number(name, value) >= 0, name, value, "must not be negative")


def within(least: float, most: float, unit: str = "") -> Check:
    """Return the check that refuses numbers outside of bounds."""

    def check(name: str, value: object) -> None:
        rule = f"must lie between {least:g} and {most:g}{unit}"
        require(least <= require_number(name, value) <= most, name, value, rule)

    return check


# Types of keys whose values are checked.
Positive = Annotated[float, require_positive]
NotNegative = Annotated[float, not_negative]


@dataclasses.dataclass(frozen=True)
class Key:
    """Declaration of a key, beside its name, type and default."""

    example: str = ""  #: a value in TOML, for the commented study
    #: describes it there, in the schema and in the help of its flag; the unit follows from the name
    comment: str = ""
    check: Check | None = None  #: refuses values, beside what their type says
    needs: str = ""  #: another key without which this one has no effect, and why: ``"bore_mm, which …"``
    stated: bool = False  #: whether the commented study states the example, and not as a comment
    above: str = ""  #: a comment there on this key and those that follow it
    alias: str = ""  #: an earlier name of key and flag that is still read
    #: The flag that overrides it, by its name in Python: ``pvd_step`` is ``--pvd-step`` in the shell
    flag: str = ""
    help: str = ""  #: of the flag, where the comment is not
    kind: Any = None  #: type of the flag's value, where it is not that of the key
    parse: Callable[[Any], Any] | None = None  #: turns the flag's value into that of the key
    #: Names of the keys of a table whose entries are quantities, too
    entries: Callable[[], Collection[str]] = tuple
    writes: bool = False  #: whether the flag asks for a file, which an analysis in memory does not write


def key(
    example: str = "", comment: str = "", check: Check | None = None, *, default: Any = None, **more: Any
) -> Any:
    """Declare a key: the default of its field, and the attributes of `Key`."""
    metadata = {"key": Key(example, comment, check, **more)}
    if default is dict:
        return dataclasses.field(default_factory=dict, metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


def switch(comment: str, flag: str) -> Any:
    """Declare a key that switches something on, and its flag."""
    return key("true", comment, default=False, flag=flag)


def choice(default: StrEnum, comment: str, flag: str = "", *, stated: bool = True, **more: Any) -> Any:
    """Declare a key with a closed set of values, of which the default is the example, and its flag."""
    return key(f'"{default}"', comment, default=default, flag=flag, stated=stated, **more)


class StudyTable:
    """A table of a study: a frozen dataclass whose fields are its keys."""

    TABLE: ClassVar[str]  #: its name in a study
    INTRO: ClassVar[str] = ""  #: what the commented study says above it
    OPTIONAL: ClassVar[bool] = False  #: whether its heading is a comment there

    def __init_subclass__(cls, table: str = "", intro: str = "", *, optional: bool = False) -> None:
        """Give the table its name; a table that only holds keys for another has none."""
        if table:
            cls.TABLE, cls.INTRO, cls.OPTIONAL = table, intro, optional

    def __post_init__(self) -> None:
        cls: Any = type(self)
        for name, declared in keys_of(cls).items():
            value, where = getattr(self, name), f"{self.TABLE}.{name}"
            if value is None:
                continue
            for check in checks_of(cls)[name]:
                for entry in value if isinstance(value, tuple) else (value,):
                    check(where, entry)
            other = declared.needs.replace(":", ",").partition(",")[0]
            complete, remedy = not other or getattr(self, other) is not None, f"Give {other}, too."
            if not complete:
                raise InvalidValue(where, value, f"needs {declared.needs}", remedy)

    def needed(self, name: str, rule: str = "is missing", remedy: str = "Give it.") -> float:
        """Return the number of a key. Raises `InvalidValue`: it is not given."""
        value = getattr(self, name)
        require(value is not None, f"{self.TABLE}.{name}", None, rule, remedy)
        return float(value)


@cache
def keys_of(cls: Any) -> dict[str, Key]:
    """Return the keys of a table, its own before those that it inherits."""
    declared = {field.name: field.metadata.get("key", Key()) for field in dataclasses.fields(cls)}
    above = [base for base in cls.__bases__ if dataclasses.is_dataclass(base)]
    inherited = [field.name for base in above for field in dataclasses.fields(base)]
    return {name: declared[name] for name in (*(n for n in declared if n not in inherited), *inherited)}


@cache
def hints_of(cls: Any) -> dict[str, Any]:
    """Return the annotated types of the keys of a table, in the same order."""
    hints = typing.get_type_hints(cls)
    return {name: hints[name] for name in keys_of(cls)}


@cache
def checks_of(cls: Any) -> dict[str, list[Check]]:
    """Return what checks the values of each key: by its type, and by its declaration."""
    hints = typing.get_type_hints(cls, include_extras=True)
    declared = {name: key.check for name, key in keys_of(cls).items()}
    return {name: [*_annotated(hints[name]), *([check] if check else [])] for name, check in declared.items()}


def _annotated(hint: Any) -> list[Check]:
    if typing.get_origin(hint) is Annotated:
        return list(hint.__metadata__)
    return [check for part in typing.get_args(hint) for check in _annotated(part)]


class Written(float):
    """A number whose unit was written beside it."""


@cache
def own_unit(key: str) -> str:
    """Return the unit at the end of a key, of `OTHER_UNITS`; "" where it has none."""
    name = key.rpartition(".")[2]
    ends = (unit for unit in OTHER_UNITS if name == unit or name.endswith(f"_{unit}"))
    return max(ends, key=len, default="")


@cache
def stem(key: str) -> str:
    """Return a key without its unit, by which a value with a unit may be given."""
    return key.removesuffix(f"_{own_unit(key)}")


def unit_of(name: str) -> tuple[str, str]:
    """Split the name of a key into its words and its unit, "" where it has none."""
    unit = own_unit(name)
    if unit in (name, "hours", "rpm"):
        return name.replace("_", " "), ""
    return stem(name).replace("_", " "), WRITTEN.get(unit, unit)


def one_of(valid: Iterable[str]) -> Check:
    """Return the check that refuses all but some words."""
    names = [str(name) for name in valid]
    return lambda name, value: require(value in names, name, value, f"must be one of {', '.join(names)}")


# Other words for keys, which no similar spelling leads to.
_MEANT = dict.fromkeys(("turbo", "turbocharger", "supercharger", "manifold_pressure", "map_bar"), "boost_bar")


def unknown_key(where: str, key: str, valid: Iterable[str]) -> InvalidValue:
    """Return the error for a key that does not exist, which suggests the nearest one and lists all."""
    names = list(valid)
    meant = _MEANT.get(key.casefold())
    remedy = f"Did you mean {meant}?" if meant in names else _converted(key, names) or nearest(key, names)
    return InvalidValue(f"{where} {shown(key)}", None, "is an unknown key", remedy)


def _converted(key: str, valid: Iterable[str]) -> str:
    for name in valid:
        own = own_unit(name)
        for unit, factor in OTHER_UNITS.get(own, {}).items():
            words = {unit.translate(_PLAIN), *_SPELT.get(unit, ())}
            if key in {f"{name.removesuffix(own)}{word}" for word in words}:
                with_unit = f'or {stem(name)} = "5.7 {unit}"'
                return f"Give {name}, which is {factor:.6g} times the value in {unit}, {with_unit}."
    return ""


def nearest(word: str, valid: Iterable[str]) -> str:
    """Return the remedy for a word that is not in `valid`: the nearest one, then all of them."""
    names = sorted(valid)
    near = difflib.get_close_matches(word, names, n=1)
    return (f"Did you mean {near[0]}? " if near else "") + "Valid names: " + ", ".join(names) + "."


def read_table(cls: type[AnyTable], where: str, raw: object) -> AnyTable:
    """Make `cls` from a TOML table called `where`. Raises `InvalidValue`: no table, a wrong key or type."""
    values = read_keys(cls, where, raw)
    for name in required(cls):
        if name not in values:
            raise InvalidValue(f"{where}.{name}", None, "is missing", f"Give it in [{where}].")
    return cls(**values)


def read_keys(cls: Any, where: str, raw: object) -> TomlTable:
    """Return the values of a TOML table as the types of the keys of `cls`; see `read_table`."""
    if not isinstance(raw, Mapping):
        raise InvalidValue(where, raw, f"must be a table, [{where}]")
    hints = hints_of(cls)
    aliases = {declared.alias: name for name, declared in keys_of(cls).items() if declared.alias}
    values: TomlTable = {}
    for given, value in in_own_units(cls, where, raw).items():
        name = aliases.get(given, given)
        if name not in hints:
            raise unknown_key(f"[{where}]", given, hints)
        if name in values:
            raise InvalidValue(f"{where}.{given}", value, "is given twice, by two names", "Remove one.")
        values[name] = checked(f"{where}.{given}", value, hints[name])
    return values


def with_changes(cls: Any, where: str, kept: TomlTable, changes: Mapping[str, Any]) -> TomlTable:
    """Return values of keys with changes, of which None takes a key away. Errors as of `read_keys`."""
    given = read_keys(cls, where, {key: value for key, value in changes.items() if value is not None})
    away = {full_key(key, keys_of(cls)) for key, value in changes.items() if value is None}
    for key in away - keys_of(cls).keys():
        raise unknown_key(f"[{where}]", key, keys_of(cls))
    return {key: value for key, value in {**kept, **given}.items() if key not in away}


def in_own_units(cls: Any, where: str, raw: Mapping[str, Any]) -> TomlTable:
    """Return a TOML table whose values with units stand as numbers, by the keys that name their units.

    So do those of the tables in it. Errors as of `quantity`, and for a value that is given by both keys.
    """
    values: TomlTable = {}
    for given, value in raw.items():
        name, place = full_key(given, keys_of(cls)), f"{where}.{given}"
        if name in values:
            raise InvalidValue(place, value, "is given twice, with its unit and without", "Remove one.")
        if isinstance(value, Mapping):
            entries = keys_of(cls)[given].entries() if given in keys_of(cls) else keys_of(cls)
            values[name] = {
                (own := full_key(key, entries)): number_of(f"{place}.{key}", entry, own, bare=own != key)
                for key, entry in value.items()
            }
        else:
            values[name] = number_of(place, value, name, bare=name != given)
    return values


def full_key(given: str, names: Collection[str]) -> str:
    """Return the key with its unit that a key without one stands for, or the key itself."""
    return given if given in names else next((name for name in names if stem(name) == given), given)


def number_of(where: str, value: Any, name: str, *, bare: bool = False, change: bool = False) -> Any:
    """Return a value of key `name`, or each of a list, as `quantity` does where it is a text with a unit.

    `bare`: its key is given without the unit, so that the value must have one. `where` is for messages.
    """
    unit = own_unit(name)
    if not unit or isinstance(value, bool | Mapping):
        return value
    if isinstance(value, list | tuple):
        return [number_of(where, entry, name, bare=bare, change=change) for entry in value]
    return quantity(where, value, unit, key=name, change=change) if bare or isinstance(value, str) else value


def quantity(where: str, value: object, unit: str, *, key: str = "", change: bool = False) -> Written:
    """Return the number of a text with a unit, in the unit of a key (of `OTHER_UNITS`).

    `key` says what a pressure refers to. `change`: the value is a difference of two, such as a deviation; of
    temperatures it has no zero. Raises `InvalidValue`: it is no number with a unit, the unit is unknown or of
    another kind, or the pressure is gauge in place of absolute, or the other way round.
    """
    from fea.study.notations import converted  # noqa: PLC0415 - only such a value needs its library

    return Written(converted(where, value, unit, stem(key.rpartition(".")[2]), change=change))


def with_units(value: Any, key: str = "") -> Any:
    """Return a value of a key, or the tables of a study, with the units that were written beside numbers."""
    if isinstance(value, Mapping):
        return {name: with_units(entry, name) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [with_units(entry, key) for entry in value]
    return f"{value!r} {own_unit(key)}" if isinstance(value, Written) else value


def required(cls: Any) -> list[str]:
    """Return the names of the fields without a default."""
    absent = dataclasses.MISSING
    fields = dataclasses.fields(cls)
    return [each.name for each in fields if each.default is absent and each.default_factory is absent]


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
            if not is_finite(number):
                raise InvalidValue(name, number, "must be a finite number")
            if number and not 1 / _LARGEST <= abs(number) <= _LARGEST:
                rule = f"its magnitude must be 0 or between {1 / _LARGEST:g} and {_LARGEST:g}"
                raise InvalidValue(name, number, rule, "Give it in the unit that the key names.")
    options = options_of(hint)
    for option in options:
        converted = _convert(value, option)
        if converted is not None:
            return converted
    choices = [choice for option in options if _is_enum(option) for choice in option]
    if choices:
        remedy = f"Choose from {', '.join(choices)}{' or give a number' if float in options else ''}."
        raise InvalidValue(name, value, "is not a valid choice", remedy)
    raise InvalidValue(name, value, f"must be {' or '.join(_word(option) for option in options)}")


def options_of(hint: Any) -> list[Any]:
    """Return the types that a hint allows beside None."""
    several = typing.get_origin(hint) in (typing.Union, types.UnionType)
    options = typing.get_args(hint) if several else (hint,)
    return [option for option in options if option is not types.NoneType]


def _is_enum(option: Any) -> bool:
    return isinstance(option, type) and issubclass(option, StrEnum)


def _word(option: Any) -> str:
    if typing.get_origin(option) is tuple:
        entry = _word(typing.get_args(option)[0]).removeprefix("a ")
        return f"a list of {'tables of number' if entry == 'table' else entry}s"
    return "a table" if typing.get_origin(option) is dict else _WORDS[option]


def _convert(value: object, option: Any) -> Any:  # noqa: PLR0911 - one return a type
    """Return `value` as `option`, or None if it is of another type."""
    if inner := typing.get_args(option):
        if typing.get_origin(option) is tuple and isinstance(value, list | tuple):
            listed = tuple(_convert(entry, inner[0]) for entry in value)
            return None if None in listed else listed
        if typing.get_origin(option) is dict and isinstance(value, Mapping):
            entries = {key: _convert(entry, inner[1]) for key, entry in value.items()}
            return None if None in entries.values() else entries
        return None
    if _is_enum(option):
        return option(value) if value in list(option) else None
    if isinstance(value, bool) and option is not bool:
        return None
    if option is float and isinstance(value, int | float):
        return value if isinstance(value, Written) else float(value)
    return value if isinstance(value, option) else None


def entries_of(table: Any) -> TomlTable:
    """Return the keys of a table that say something, by name; those that are None or empty are left out."""
    cls: Any = type(table)
    values = {name: getattr(table, name) for name in keys_of(cls)}
    return {name: value for name, value in values.items() if value not in (None, (), {})}
