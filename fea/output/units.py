"""The formatting of figures: in the units that a reader has chosen, with the digits that they are worth.

Elsewhere, and in data files, figures are in SI units and mm. `number`, and what is built on it, converts a
figure by its unit. Text that was written elsewhere, such as the notes of a run, is converted by `in_text`.
"""

import math
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import NamedTuple, TypeVar

from fea.base.choices import UnitSystem
from fea.base.units import KN, SUPERSCRIPTS, US_CUSTOMARY, with_power
from fea.judge.safety_factor import printed
from fea.study.tables import unit_of
from geometry.arrays import Floats

AnyNumber = TypeVar("AnyNumber", float, Floats)


class _OtherUnit(NamedTuple):
    """A unit in place of another: its name, how much of it the other is, and where the other is 0."""

    name: str
    factor: float
    zero: float = 0.0


_US = {name: _OtherUnit(other, 1 / part, *zero) for name, (other, part, *zero) in US_CUSTOMARY.items()}
_system: ContextVar[UnitSystem] = ContextVar("_system", default=UnitSystem.SI)


@contextmanager
def shown_in(system: UnitSystem) -> Iterator[None]:
    """Show figures in the units of a system while the block runs."""
    token = _system.set(system)
    try:
        yield
    finally:
        _system.reset(token)


def system() -> UnitSystem:
    """Return the system of units in which figures are shown."""
    return _system.get()


def _other(name: str) -> _OtherUnit | None:
    """Return what is shown in place of a unit; None where that is the unit itself."""
    return _US.get(name) if system() is UnitSystem.US else None


def unit(name: str) -> str:
    """Return the unit that is shown in place of one, such as ``MPa``; itself if there is no other."""
    other = _other(name)
    return name if other is None else other.name


def scale(name: str) -> float:
    """Return the factor from a unit to that which is shown in its place; of temperatures, of a difference."""
    other = _other(name)
    return 1.0 if other is None else other.factor


def in_unit(value: AnyNumber, name: str) -> AnyNumber:
    """Return a value of a unit, or an array of them, in the unit that is shown in its place."""
    other = _other(name)
    return value if other is None else value * other.factor + other.zero


UNKNOWN = "–"
# Figures in sentences have at least these digits after a conversion where they had them before.
_DIGITS = 3
_DIGITS_OF = {superscript: digit for digit, superscript in SUPERSCRIPTS.items()} | {ord("−"): "-"}


def number(value: float | None, form: str, name: str = "", *, digits: int = 0, coarser: int = 0) -> str:
    """Return a number without a negative zero, in a format that holds for its own unit, `name`.

    In another unit it has the same resolution, or one that is a few decimals `coarser`, and at least some
    `digits` if it has as many in its own unit. None is a dash.
    """
    if value is None:
        return UNKNOWN
    text, other = format(value + 0.0, form), _other(name)
    return text if other is None else _converted(value, text, other, digits, coarser)


def quantity(value: float | None, form: str, name: str) -> str:
    """Return a number with its unit for a sentence, in a format that holds for that unit."""
    return f"{number(value, form, name, digits=_DIGITS)} {unit(name)}"


def figure(value: float | None, digits: int = 4, name: str = "") -> str:
    """Return a number with so many significant digits in its own unit, and a proper minus."""
    return with_power(number(value, f".{digits}g", name)).replace("-", "−")


def study_value(value: object, name: str) -> str:
    """Return a value of a study as text, in the unit that is shown in place of its own."""
    if value is None:
        return UNKNOWN
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return figure(value if unit(name) == name else float(f"{in_unit(value, name):.6g}"), 10)
    if isinstance(value, list | tuple):
        return ", ".join(study_value(item, name) for item in value)
    return str(value)


def coordinates(at: Iterable[float]) -> str:
    """Return coordinates, mm, without their unit: a digit less than of other lengths is enough."""
    return ", ".join(number(coordinate, ".1f", "mm", coarser=1) for coordinate in at)


def place(at: Iterable[float]) -> str:
    """Return a place, mm, in brackets with its unit."""
    return f"({coordinates(at)}) {unit('mm')}"


# Forces that are wider, or far wider, than their columns.
_MANY_NEWTONS, _FAR_TOO_MANY = 999e3, 99_999e3


def kilo(newtons: float | None, largest: float = _MANY_NEWTONS) -> str:
    """Return a force in kN with its sign: to three digits of the `largest` beside it, N, and a tenth at most.

    Large ones are whole, huge ones short.
    """
    if newtons is None:
        return UNKNOWN
    decimals = max(1, 5 - math.floor(math.log10(largest))) if largest > 1 else 5
    form = f"+z.{decimals}f" if abs(newtons) < _MANY_NEWTONS else "+.0f"
    return number(newtons / KN, form if abs(newtons) < _FAR_TOO_MANY else "+.1e", "kN")


_WHOLE = 9.95  # percent: error bars from here on have no decimals


def bar(percent: float | None) -> str:
    """Return an error bar with two digits."""
    return number(percent, ".0f" if percent is not None and percent >= _WHOLE else ".1f")


def factor(value: float | None) -> str:
    """Return a safety factor: two places, or two digits where it is so small that those would be zeros."""
    return printed(value)


def hours_text(hours: float | None) -> str:
    """Return hours with three digits, or that they are unlimited."""
    return "unlimited" if hours is None else f"{number(hours, '.3g')} h"


_SIGNS = {"degrees": "°", "percent": "%"}
_KEYS = {"E": "Young's modulus E", "nu": "Poisson's ratio ν", "rpm": "speed", "pin": "force of the pin"}


def named(key: str) -> tuple[str, str]:
    """Return the name of a key in words, and its unit (empty where it has none)."""
    words, own = unit_of(key)
    return _KEYS.get(words, words), "rpm" if key == "rpm" else _SIGNS.get(own, own)


def heading(words: str, name: str) -> str:
    """Return words with the unit that is shown in place of `name`, for a column or an axis."""
    return f"{words}, {unit(name)}" if name else words


def in_heading(label: str) -> str:
    """Return the label of a column or an axis, at whose end its unit stands, in the unit that is shown."""
    name = _unit_at_the_end(label)
    return f"{label.removesuffix(name)}{unit(name)}"


def scale_of(label: str) -> float:
    """Return the factor of the unit at the end of a label."""
    return scale(_unit_at_the_end(label))


def _unit_at_the_end(label: str) -> str:
    found = None if system() is UnitSystem.SI else _LAST.search(label)
    return "" if found is None else found[1]


_NUMBER = r"[+\-−]?\d+(?:,\d{3})*(?:\.\d+)?(?:e[+-]?\d+|·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?"
_NUMBERS = re.compile(rf"(?<![\w.]){_NUMBER}(?![\w])")
_UNIT = "|".join(sorted(map(re.escape, _US), key=len, reverse=True))
_LAST = re.compile(rf"(?:^|[ \n])({_UNIT})$")
# Numbers with one unit: a range, a place "(x, y, z) mm" or "x, y, z = 1, 2, 3 mm", or a single one.
_QUANTITY = re.compile(
    rf"(?<![\w.,_])((?:(?<=[(\[])|(?<== )){_NUMBER}(?:, {_NUMBER})+|"
    rf"{_NUMBER}(?:(?: (?:to|and|or|x|×|±) |–|…){_NUMBER})*)([)\]]?)"
    rf"( ?)({_UNIT})(?![\w/·²³⁴]| a | times)"
)


class Verbatim(str):
    """A text that is shown as it is, such as one about the units of keys."""

    __slots__ = ()


def in_text(text: str) -> str:
    """Return a text that was written elsewhere, its numbers with units in the units that are shown."""
    if system() is UnitSystem.SI or isinstance(text, Verbatim):
        return text

    def converted(found: re.Match[str]) -> str:
        numbers, closed, blank, name = found.groups()
        return f"{_numbers(numbers, _US[name], _DIGITS)}{closed}{blank}{_US[name].name}"

    return _QUANTITY.sub(converted, text)


def in_rows(head: Iterable[str], rows: Iterable[Iterable[str]]) -> Iterator[list[str]]:
    """Yield rows of text that was written elsewhere; the headings of its columns name their units."""
    others = [_other(_unit_at_the_end(label)) for label in head]
    for row in rows:
        pairs = zip(row, others, strict=True)
        yield [cell if other is None else _numbers(cell, other, 0) for cell, other in pairs]


def _numbers(text: str, other: _OtherUnit, digits: int) -> str:
    """Return numbers in another unit; of the coordinates of a place a digit less is enough."""
    coarser, digits = (1, 0) if text.count(", ") == 2 else (0, digits)

    def converted(found: re.Match[str]) -> str:
        plain = found[0].replace(",", "").replace("·10", "e").translate(_DIGITS_OF)
        return _converted(float(plain), found[0], other, digits, coarser)

    return _NUMBERS.sub(converted, text)


def _converted(value: float, text: str, other: _OtherUnit, digits: int, coarser: int) -> str:
    """Return a value in another unit, with the resolution that its `text` has in its own unit."""
    mantissa, power, _ = text.partition("e") if "e" in text else text.partition("·10")
    given = sum(letter.isdigit() for letter in mantissa.lstrip("+-−0.,"))
    converted = value * other.factor + other.zero
    if power:
        return f"{converted:.{max(given, 1)}g}".replace("-", "−" if "·" in power else "-")
    decimals = len(mantissa.partition(".")[2]) - math.floor(math.log10(other.factor)) - coarser
    if converted and given >= digits > 0:
        decimals = max(decimals, digits - 1 - math.floor(math.log10(abs(converted))))
    sign, thousands = "+" if text.startswith("+") else "", "," if "," in mantissa else ""
    rounded = f"{round(converted, decimals) + 0.0:{sign}{thousands}.{max(decimals, 0)}f}"
    return rounded.replace("-", "−") if "−" in mantissa else rounded
