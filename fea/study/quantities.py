"""Values of a study with a unit: ``length = "5.7 in"`` in place of ``length_mm = 144.78``."""

import difflib
import re
from functools import cache
from importlib.resources import files
from typing import Any

from fea.base.units import OTHER_UNITS, WRITTEN
from geometry.errors import InvalidValue

_QUANTITY = re.compile(
    r"\s*([+-]?)(?:(?:(\d+)[ -])?(\d+)/(\d+)(?=[\sa-z\"″])|(\d+\.?\d*|\.\d+)(?:e([+-]?\d{1,3}))?)\s*(.*?)\s*",
    re.IGNORECASE,
)
# How units are written that `pint` would read otherwise, or not at all.
_TORQUE = re.compile(r"\b(?:lbf?s?[-·*. ]?(ft|in)|(ft|in)[-·*. ]?lbf?s?)\b(?![\^²³*/])")
_INCHES = {'"': "in", "″": "in", "''": "in", "'": "ft", "′": "ft"}
_TEMPERATURES = {"F": "degF", "C": "degC", "° F": "degF", "° C": "degC"}
# The units at the ends of keys as `pint` reads them, where it does not read what is written.
_OWN = {"C": "degC", "deg": "deg", "hours": "hour"}
_LONGEST = 40  # letters of a unit


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


def quantity(name: str, value: object, unit: str, *, change: bool = False) -> float:
    """Return the number of a text with a unit, in the unit of a key (of `OTHER_UNITS`).

    `change`: the value is a difference of two, such as a deviation; of temperatures it has no zero. Raises
    `InvalidValue`: it is no number with a unit, the unit is unknown, or of another kind.
    """
    example = f'Write number and unit, as in "70 {_others(unit)[-1]}".'
    if not isinstance(value, str):
        raise InvalidValue(name, value, "has no unit", example)
    parts = _QUANTITY.fullmatch(value)
    if parts is None or not 0 < len(parts[7]) <= _LONGEST:
        raise InvalidValue(name, value, "must be a number, or a text of a number and its unit", example)
    sign, whole, above, below, decimal, power, written = parts.groups()
    if decimal is None:
        number = int(whole or 0) + int(above) / (int(below) or float("nan"))
    else:
        number = float(f"{decimal}e{power or 0}")
    number = -number if sign == "-" else number
    return _converted(name, value, number, written, unit) - (
        _converted(name, value, 0.0, written, unit) if change else 0.0
    )


def _converted(name: str, value: str, number: float, written: str, unit: str) -> float:
    import pint  # noqa: PLC0415 - only such a value needs it

    registry = _registry()
    try:
        given = registry.parse_units(_plain(written, unit))
        ours = _OWN.get(unit) or WRITTEN.get(unit, unit).replace("·", "*")
        return float(registry.Quantity(number, given).to(ours).magnitude)
    except pint.DimensionalityError as error:
        rule = f"is not in a unit of the right kind: {written}"
        raise InvalidValue(name, value, rule, f"Give it in {_listed(unit)}.") from error
    except pint.UndefinedUnitError as error:
        unknown = ", ".join(error.unit_names)
        near = difflib.get_close_matches(unknown.lower(), _others(unit), n=1, cutoff=0.4)
        remedy = f"Did you mean {near[0]}? " if near else ""
        rule = f"has an unknown unit: {unknown}"
        raise InvalidValue(name, value, rule, f"{remedy}Give it in {_listed(unit)}.") from error
    except Exception as error:  # what a text that is no unit may raise is not documented
        rule, remedy = f"has a unit that cannot be read: {written}", f"Give it in {_listed(unit)}."
        raise InvalidValue(name, value, rule, remedy) from error


def _plain(written: str, unit: str) -> str:
    written = _INCHES.get(written, written)
    if unit == "C":
        written = _TEMPERATURES.get(written, written)
    if unit == "Nm":  # a pound is a force in a torque
        written = _TORQUE.sub(lambda found: f"lbf*{found[1] or found[2]}", written)
    return f"1{written}" if written.startswith("/") else written


def _others(unit: str) -> list[str]:
    own = _OWN.get(unit) or WRITTEN.get(unit, unit)
    return ["°F", "K", "°C"] if unit == "C" else [*OTHER_UNITS[unit], own]


def _listed(unit: str) -> str:
    *rest, last = _others(unit)
    return f"{', '.join(rest)} or {last}" if rest else last


@cache
def _registry() -> Any:
    import pint  # noqa: PLC0415 - only such a value needs it

    registry: Any = pint.UnitRegistry(None, on_redefinition="ignore")
    registry.load_definitions(str(files("pint") / "default_en.txt"))
    # An angle is no plain number here, so that neither "5 %" nor "5" is one; revolutions count, not radians.
    registry.load_definitions(
        [
            "radian = [angle] = rad",
            "turn = 2 * pi * radian = _ = revolution = cycle = circle",
            "hertz = turn / second = Hz",
            "percent = [share] = %",
            "million_psi = 1e6 * psi = Msi = Mpsi",
        ]
    )
    return registry
