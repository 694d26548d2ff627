"""Values with units in the unit of a key, converted by `pint`."""

import difflib
from functools import cache
from importlib.resources import files
from typing import Any

import pint

from fea.base.units import OTHER_UNITS, WRITTEN
from fea.study.notations import AmbiguousUnitError, comma, normal, number, readings, reference
from geometry.errors import InvalidValue

# The units at the ends of keys as `pint` reads them, where it does not read what is written.
_OWN = {"C": "degC", "deg": "deg", "hours": "hour"}
_LONGEST = 40  # letters of a unit
# What pressures of gases and oil refer to, by the keys without their units; no other key has a reference.
REFERENCES = {
    **dict.fromkeys(("peak_pressure", "intake_pressure", "atmosphere"), "absolute"),
    **dict.fromkeys(("boost", "inlet", "small_end_inlet"), "gauge"),
}
_PRESSURES = ("bar", "MPa", "GPa")
_ATMOSPHERE = 1.01325  # bar


class WrongKindError(ValueError):
    """A unit of another dimension than that of a key, which it holds."""


def converted(name: str, value: object, unit: str, stem: str, *, change: bool = False) -> float:
    """Return the number of a text with a unit; `stem` is the key without its unit. See `quantity`."""
    example = f'Write number and unit, as in "70 {_others(unit)[-1]}".'
    if not isinstance(value, str):
        raise InvalidValue(name, value, "has no unit", example)
    text = normal(value)
    if remedy := comma(text):
        raise InvalidValue(name, value, "has a comma in its number", remedy)
    size, written = number(text) or (0.0, "")
    if not 0 < len(written) <= _LONGEST:
        raise InvalidValue(name, value, "must be a number, or a text of a number and its unit", example)
    given, refers_to = _unit(name, value, written, unit)
    result = _in_own(size, given, unit) - (_in_own(0.0, given, unit) if change else 0.0)
    wanted = REFERENCES.get(stem)
    if refers_to not in ("", wanted):
        raise InvalidValue(name, value, *_other_reference(refers_to, wanted, result, unit))
    return result


def _in_own(size: float, given: Any, unit: str) -> float:
    return float(_registry().Quantity(size, given).to(_own(unit)).magnitude)


def _unit(name: str, value: str, written: str, unit: str) -> tuple[Any, str]:
    """Return what is written as a unit of `pint`, and what a pressure refers to; "" if it says nothing."""
    if written.replace("^", "") == unit:
        return _own(unit), ""
    base, refers_to = reference(written) if unit in _PRESSURES else (written, "")
    try:
        found = _read(written, unit)
        if isinstance(found, Exception) and refers_to:
            without = _read(base, unit)
            if not isinstance(without, Exception):
                return without, refers_to
    except AmbiguousUnitError as error:
        rule = f"has a unit with more meanings than one: {written}"
        raise InvalidValue(name, value, rule, f"{error}.") from error
    if isinstance(found, Exception):
        raise _refusal(name, value, written, unit, found) from found
    return found, ""


def _read(written: str, unit: str) -> Any:
    """Return the first reading of the wanted dimension, or the error of the likeliest that is none."""
    registry, error = _registry(), None
    wanted = _own(unit).dimensionality
    try:
        for expression in readings(written):
            try:
                found = registry.parse_units(expression)
            except Exception as unknown:  # noqa: BLE001 - what a text that is no unit may raise is not documented
                error = error or unknown
                continue
            if found.dimensionality == wanted:
                return found
            if unit == "rpm" and found == registry.parse_units("1/minute"):
                return registry.parse_units("turn/minute")
            if not isinstance(error, WrongKindError):
                error = WrongKindError(found)
    except AmbiguousUnitError:
        raise
    except ValueError as formless:
        return formless
    return error


def _refusal(name: str, value: str, written: str, unit: str, error: Exception) -> InvalidValue:
    listed = f"Give it in {_listed(unit)}."
    if isinstance(error, pint.UndefinedUnitError):
        unknown = ", ".join(error.unit_names)
        near = difflib.get_close_matches(unknown.lower(), _others(unit), n=1, cutoff=0.4)
        remedy = f"Did you mean {near[0]}? {listed}" if near else listed
        return InvalidValue(name, value, f"has an unknown unit: {unknown}", remedy)
    if not isinstance(error, WrongKindError):
        return InvalidValue(name, value, f"has a unit that cannot be read: {written}", listed)
    dimension = error.args[0].dimensionality
    kinds = {kind: _registry().parse_units(kind).dimensionality for kind in ("stokes", "1/second")}
    if unit == "mPas" and dimension == kinds["stokes"]:
        rule = f"is a kinematic viscosity, and the dynamic viscosity is needed: {written}"
        return InvalidValue(name, value, rule, f"Multiply cSt by the density in g/cm³. {listed}")
    if unit == "rpm" and dimension == kinds["1/second"]:
        rule = f"may be revolutions or radians: {written}"
        return InvalidValue(name, value, rule, "Write rev/s or rad/s.")
    return InvalidValue(name, value, f"is not in a unit of the right kind: {written}", listed)


def _other_reference(refers_to: str, wanted: str | None, size: float, unit: str) -> tuple[str, str]:
    """Return the rule and the remedy where a pressure is written as gauge or absolute, and is not."""
    if wanted is None:
        rule = f"is written as {refers_to} pressure, but this value is not the pressure of a gas or of oil"
        return rule, f"Give it in {_listed(unit)}, without {refers_to}."
    other = size + (_ATMOSPHERE if wanted == "absolute" else -_ATMOSPHERE)
    remedy = f"Write {other:.8g} bar, if the atmosphere has {_ATMOSPHERE} bar."
    return f"is {refers_to} pressure, but this key takes {wanted} pressure", remedy


def _own(unit: str) -> Any:
    """Return the unit at the end of a key as `pint` reads it."""
    return _registry().parse_units(_OWN.get(unit) or WRITTEN.get(unit, unit).replace("·", "*"))


def _others(unit: str) -> list[str]:
    own = _OWN.get(unit) or WRITTEN.get(unit, unit)
    return ["°F", "K", "°C"] if unit == "C" else [*OTHER_UNITS[unit], own]


def _listed(unit: str) -> str:
    *rest, last = _others(unit)
    return f"{', '.join(rest)} or {last}" if rest else last


@cache
def _registry() -> Any:
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
