"""Values of a study with a unit: ``length = "5.7 in"`` in place of ``length_mm = 144.78``."""

from collections.abc import Mapping
from functools import cache
from typing import Any

from fea.base.units import OTHER_UNITS


class Written(float):
    """A number whose unit was written beside it."""


def with_units(value: Any, key: str = "") -> Any:
    """Return a value of a key, or the tables of a study, with the units that were written beside numbers."""
    if isinstance(value, Mapping):
        return {name: with_units(entry, name) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [with_units(entry, key) for entry in value]
    return f"{value!r} {own_unit(key)}" if isinstance(value, Written) else value


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


def quantity(name: str, value: object, unit: str, *, key: str = "", change: bool = False) -> Written:
    """Return the number of a text with a unit, in the unit of a key (of `OTHER_UNITS`).

    `key` says what a pressure refers to. `change`: the value is a difference of two, such as a deviation; of
    temperatures it has no zero. Raises `InvalidValue`: it is no number with a unit, the unit is unknown or of
    another kind, or the pressure is gauge in place of absolute, or the other way round.
    """
    from fea.study.conversion import converted  # noqa: PLC0415 - only such a value needs its library

    return Written(converted(name, value, unit, stem(key.rpartition(".")[2]), change=change))
