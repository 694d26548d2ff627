"""Numbers and units as data sheets write them, converted by `pint` to the unit of a key."""

import difflib
import re
import unicodedata
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib.resources import files
from itertools import product
from typing import Any

import pint

from fea.base.shipped import shipped_toml
from fea.base.units import OTHER_UNITS, WRITTEN
from geometry.errors import InvalidValue

_DATA = shipped_toml("study/notations.toml")
_CHARACTERS = str.maketrans({one: meant for meant, several in _DATA["characters"].items() for one in several})
_POWER = re.compile("[⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+")
_FRACTION = re.compile("[¼-¾⅐-⅞]")
_DIGITS = r"\d{1,3}(?:'\d{3})+|\d{1,3}(?:[ ]\d{3})+|\d{1,3}(?:_\d{3})+|\d+"
_NUMBER = re.compile(
    rf"""(?P<sign>[+-]?)(?:
      (?:(?P<whole>\d+)[ -])?(?P<above>\d+)/(?P<below>\d+)(?=[\sa-z"']|-[a-z])
    | 10\^\(?(?P<alone>[+-]?\d{{1,3}})\)?
    | (?P<digits>(?:{_DIGITS})(?:\.\d*)?|\.\d+)
      (?: e(?P<power>[+-]?\d{{1,3}})
        | (?:\s*[·x]\s*|\s+)10\^\(?(?P<ten>[+-]?\d{{1,3}})\)?
        | \s*[·x]\s*10(?P<lost>[+-]\d{{1,2}})
        | (?:\s*[·x]\s*|\s+)1e(?P<factor>[+-]?\d{{1,3}}) )?
    )(?![\d.,^])\s*[·*]?\s*(?P<unit>.*)""",
    re.IGNORECASE | re.VERBOSE | re.ASCII | re.DOTALL,
)
_GROUPING = dict.fromkeys(map(ord, "' _"))
_COMMA = re.compile(r"[+-]?(\d[\d' .]*|),\d[\d,.' ]*")
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(,\d{3})+(\.\d+)?")
_REWRITTEN = [(re.compile(pattern, re.IGNORECASE), new) for pattern, new in _DATA["rewritten"]]
_GROUP = re.compile(r"/\s*\(([^()/]*)\)")
_FACTOR = re.compile(
    r"""([a-z_°%‰"'#äöü]+?)(?:\^\(?([+-]?\d)\)?(?!\d)|(-?\d)(?!\d))?(?=[^a-z_°%‰"'#äöü\d]|$)|([·/]|[. -]+)""",
    re.IGNORECASE,
)
# Two units written as one word: Nm, mkp, mPas, gcm². "mN" is always a millinewton.
_WEIGHT = r"kgf|kg|kp|ozf|oz|lbf|lbs|lb"
_JOINED = re.compile(
    rf"(daN|dN|kN|N|{_WEIGHT}|gf|g|p|t|mPa|dPa|Pa)(mm|cm|m|ft|in|s)|(mm|cm|m|ft|in)({_WEIGHT})", re.IGNORECASE
)
_FORCES = {
    name: f"force_{name}" for name in ("pound", "kilogram", "gram", "ounce", "metric_ton")
}  # of these masses
_REFERENCE = re.compile(
    r"(.*?[^\s(\[_])[\s_]*[(\[]?\s*(abs(?:ol\w*)?\.?|a|g|ga|gauge|gage|rel\w*\.?|ü(?:berdruck)?)\.?\s*[)\]]?",
    re.IGNORECASE,
)
_SHORT = 2  # letters
# What signs of temperatures mean, alone and in a product.
_TEMPERATURES = {word: (at, by) for at, by, words in _DATA["temperatures"] for word in words.split()}


def normal(text: str) -> str:
    """Return a text with one character for each of its meanings, and powers as ``^2``."""
    plain = _POWER.sub(lambda raised: f"^{unicodedata.normalize('NFKC', raised[0])}", text)
    plain = _FRACTION.sub(r" \g<0>", plain.translate(_CHARACTERS))
    plain = unicodedata.normalize("NFKC", plain).translate(_CHARACTERS)
    return re.sub(r"\s+", " ", plain).strip()


def number(text: str) -> tuple[float, str] | None:
    """Return the number at the start of a normal text, and the unit after it; None where there is none."""
    found = _NUMBER.fullmatch(text)
    if found is None:
        return None
    if found["above"]:
        size = int(found["whole"] or 0) + int(found["above"]) / (int(found["below"]) or float("nan"))
    elif found["alone"]:
        size = float(f"1e{found['alone']}")
    else:
        power = found["power"] or found["ten"] or found["lost"] or found["factor"] or "0"
        digits = found["digits"].translate(_GROUPING)
        size = float(f"{digits}e{power}")
    return (-size if found["sign"] == "-" else size), found["unit"]


def comma(text: str) -> str:
    """Return the remedy for a number with a comma; "" where it has none."""
    found = _COMMA.match(text)
    if found is None:
        return ""
    given = found[0].strip()
    if _THOUSANDS.fullmatch(given):
        whole = given.replace(",", "")
        return f"Write {whole}, or with a decimal point: the comma may mean either."
    pointed = f": {given.replace(',', '.')}" if given.count(",") == 1 and "." not in given else ""
    return f"Write a decimal point, not a comma{pointed}."


def reference(unit: str) -> tuple[str, str]:
    """Split "absolute" or "gauge" from a unit of pressure, as in ``bar(g)`` or ``psia``; "" if neither."""
    found = _REFERENCE.fullmatch(unit)
    if found is None:
        return unit, ""
    return found[1], "absolute" if found[2][0] in "aA" else "gauge"


def readings(unit: str) -> Iterator[str]:
    """Return what a unit may mean, as expressions for `pint`, the likeliest first.

    Raises `ValueError`: it has not the form of a unit, or a word with more meanings than one.
    """
    for pattern, new in _REWRITTEN:
        unit = pattern.sub(new, unit)
    unit = _GROUP.sub(lambda found: "/" + re.sub(r"[· ]+", "/", found[1].strip()), unit)
    parts = _parts(re.sub(r"^\((.*)\)$", r"\1", unit))
    for sticky, joined, any_case in product((False, True), repeat=3):
        words = _factors(parts, sticky=sticky, joined=joined, any_case=any_case)
        for forces in ({}, _FORCES) if len(words) > 1 else ({},):
            yield "*".join(f"({forces.get(name, name)})**{power}" for name, power in words)


Factors = list[tuple[str, int]]


def _parts(unit: str) -> list[tuple[str, int, bool]]:
    """Split a unit into its words, their powers, and whether a slash is before them."""
    rest = re.sub(r"^1\s*(?=/)", "", unit.strip())
    parts: list[tuple[str, int, bool]] = []
    slash, end = False, 0
    for found in _FACTOR.finditer(rest):
        if found.start() != end:
            break
        end = found.end()
        word, power, short, operator = found.groups()
        if word:
            _require_clear(word, alone=word == rest)
            parts.append((word, int(power or short or 1), slash))
            slash = False
        elif operator == "/":
            if slash:
                break
            slash = True
    if end != len(rest) or slash or not parts:
        raise ValueError(unit)
    return parts


def _require_clear(word: str, *, alone: bool) -> None:
    for kind in ("ambiguous", "doubtful_alone") if alone else ("ambiguous",):
        known = word if word in _NAMES or kind != "ambiguous" else word.lower()
        if why := _DATA[kind].get(word, _DATA[kind].get(known)):
            raise _AmbiguousUnitError(f"{word} {why}")


def _factors(parts: list[tuple[str, int, bool]], *, sticky: bool, joined: bool, any_case: bool) -> Factors:
    """Return pint's names and powers; `sticky`: all that follows a slash is below it."""
    factors: Factors = []
    below = False
    for word, power, slash in parts:
        below = slash or (sticky and below)
        sign = -1 if below else 1
        pair = _JOINED.fullmatch(word) if joined else None
        pieces = [piece for piece in pair.groups() if piece] if pair else [word]
        names = [_name(piece, any_case=any_case, alone=len(parts) == 1) for piece in pieces]
        factors += [(name, sign) for name in names[:-1]]
        factors.append((names[-1], sign * power))
    return factors


def _name(word: str, *, any_case: bool, alone: bool) -> str:
    if found := _TEMPERATURES.get(word.upper() if any_case else word):
        return str(found[0 if alone else 1])
    known = _NAMES.get(word)
    if known or not any_case:
        return known or word
    # Short words in another case are other units: NM is no nanometre.
    return _ANY_CASE.get(word.lower(), word.lower() if len(word) > _SHORT else word)


_NAMES: dict[str, str] = {word: name for name, words in _DATA["names"].items() for word in words.split()}
_ANY_CASE = {word.lower(): name for word, name in reversed(_NAMES.items())}


class _AmbiguousUnitError(ValueError):
    """A word of a unit has more meanings than one; its text says which."""


# The units at the ends of keys as `pint` reads them, where it does not read what is written.
_OWN = {"C": "degC", "deg": "deg", "hours": "hour"}
_LONGEST = 40  # letters of a unit
# What pressures of gases and oil refer to, by the keys without their units; no other key has a reference.
REFERENCES = {
    **dict.fromkeys(("peak_pressure", "intake_pressure", "atmosphere", "knock"), "absolute"),
    **dict.fromkeys(("boost", "inlet", "small_end_inlet"), "gauge"),
}
_PRESSURES = ("bar", "MPa", "GPa")
_ATMOSPHERE = 1.01325  # bar


class _WrongKindError(ValueError):
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
    try:
        return _read(written, unit), ""
    except _AmbiguousUnitError as error:
        rule = f"has a unit with more meanings than one: {written}"
        raise InvalidValue(name, value, rule, f"{error}.") from error
    except Exception as error:
        base, refers_to = reference(written) if unit in _PRESSURES else ("", "")
        if refers_to:
            with suppress(Exception):
                return _read(base, unit), refers_to
        raise _refusal(name, value, written, unit, error) from error


def _read(written: str, unit: str) -> Any:
    """Return the first reading of the wanted dimension; without one, raise the error of the likeliest."""
    registry, errors = _registry(), list[Exception]()
    for expression in readings(written):
        try:
            given = registry.parse_units(expression)
        except Exception as unknown:  # noqa: BLE001 - what a text that is no unit may raise is not documented
            errors.append(unknown)
            continue
        if given.dimensionality == _own(unit).dimensionality:
            return given
        if unit == "rpm" and given == registry.parse_units("1/minute"):
            return registry.parse_units("turn/minute")
        errors.append(_WrongKindError(given))
    raise next((error for error in errors if isinstance(error, _WrongKindError)), errors[0])


def _refusal(name: str, value: str, written: str, unit: str, error: Exception) -> InvalidValue:
    listed = f"Give it in {_listed(unit)}."
    if isinstance(error, pint.UndefinedUnitError):
        unknown = ", ".join(error.unit_names)
        near = difflib.get_close_matches(unknown.lower(), _others(unit), n=1, cutoff=0.4)
        remedy = f"Did you mean {near[0]}? {listed}" if near else listed
        return InvalidValue(name, value, f"has an unknown unit: {unknown}", remedy)
    if not isinstance(error, _WrongKindError):
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
