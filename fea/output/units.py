"""The units that a reader is shown: elsewhere, and in data files, figures are in SI units and mm.

What is said is converted where it leaves the program: sentences, cells of tables and values of curves.
"""

import math
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import NamedTuple, TypeVar

from fea.base.choices import UnitSystem
from fea.base.units import US_CUSTOMARY
from geometry.arrays import Floats

AnyNumber = TypeVar("AnyNumber", float, Floats)


class _Shown(NamedTuple):
    """A unit in place of another: its name, how much of it the other is, and where the other is 0."""

    name: str
    factor: float
    zero: float = 0.0


_US = {name: _Shown(other, 1 / part, *zero) for name, (other, part, *zero) in US_CUSTOMARY.items()}
_system: ContextVar[UnitSystem] = ContextVar("_system", default=UnitSystem.SI)

_NUMBER = r"[+\-−]?\d+(?:,\d{3})*(?:\.\d+)?(?:e[+-]?\d+|·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?"
_NUMBERS = re.compile(rf"(?<![\w.]){_NUMBER}(?![\w])")
_UNIT = "|".join(sorted(map(re.escape, _US), key=len, reverse=True))
# Numbers with one unit: a range, a place "(x, y, z) mm" or "x, y, z = 1, 2, 3 mm", or a single one.
_QUANTITY = re.compile(
    rf"(?<![\w.,_])((?:(?<=[(\[])|(?<== )){_NUMBER}(?:, {_NUMBER})+|"
    rf"{_NUMBER}(?:(?: (?:to|and|or|x|×|±) |–|…){_NUMBER})*)([)\]]?)"
    rf"( ?)({_UNIT})(?![\w/·²³⁴]| a | times)"
)
_SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")
# A converted figure keeps its resolution, and at least these digits where it had them.
_DIGITS = 3


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


def unit(name: str) -> str:
    """Return the unit that is shown in place of one, such as ``MPa``; itself if there is no other."""
    return _shown(name).name


def scale(name: str) -> float:
    """Return the factor from a unit to that which is shown in its place; of temperatures, of a difference."""
    return _shown(name).factor


def _shown(name: str) -> _Shown:
    return _US.get(name, _Shown(name, 1.0)) if system() is UnitSystem.US else _Shown(name, 1.0)


def scale_of(heading: str) -> float:
    """Return the factor of the unit at the end of a heading."""
    return scale(_split(heading)[2])


def in_unit(value: AnyNumber, name: str) -> AnyNumber:
    """Return a value of a unit, or an array of them, in the unit that is shown in its place."""
    to = _shown(name)
    return value * to.factor + to.zero


class Verbatim(str):
    """A text that is shown as it is, such as one about the units of keys."""

    __slots__ = ()


def in_text(text: str) -> str:
    """Return a text whose numbers with units are in the units that are shown."""
    if system() is UnitSystem.SI or isinstance(text, Verbatim):
        return text

    def converted(found: re.Match[str]) -> str:
        numbers, closed, blank, name = found.groups()
        to = _US[name]
        return f"{_converted(numbers, to, _DIGITS)}{closed}{blank}{to.name}"

    return _QUANTITY.sub(converted, text)


def in_heading(heading: str) -> str:
    """Return the heading of a column or label of an axis, at whose end its unit stands, as it is shown."""
    words, between, name = _split(heading)
    return f"{words}{between}{unit(name)}" if name else heading


def in_cells(heading: str, cells: Iterable[str]) -> list[str]:
    """Return the cells of a column, whose unit its heading names, as they are shown."""
    name = _split(heading)[2]
    if not name or unit(name) == name:
        return list(cells)
    to = _shown(name)
    return [_converted(cell, to, 0) for cell in cells]


def in_rows(head: Iterable[str], rows: Iterable[Iterable[str]]) -> Iterator[list[str]]:
    """Yield the rows of a table as they are shown; the headings of its columns name their units."""
    titles = list(head)
    for row in rows:
        yield [in_cells(title, [cell])[0] for title, cell in zip(titles, row, strict=True)]


def _split(heading: str) -> tuple[str, str, str]:
    parts = re.fullmatch(rf"(.*?)(, |\n| |)({_UNIT})", heading, re.DOTALL)
    return (parts[1], parts[2], parts[3]) if parts and (parts[2] or not parts[1]) else (heading, "", "")


def _converted(numbers: str, to: _Shown, least: int) -> str:
    """Return numbers in another unit; of the coordinates of a place a digit fewer is enough."""
    if numbers.count(", ") == 2:
        return _NUMBERS.sub(lambda one: _number(one[0], to, 0, coarser=1), numbers)
    return _NUMBERS.sub(lambda one: _number(one[0], to, least), numbers)


def _number(text: str, to: _Shown, least: int, coarser: int = 0) -> str:
    mantissa, power, exponent = text.partition("e") if "e" in text else text.partition("·10")
    digits = sum(letter.isdigit() for letter in mantissa.lstrip("+-−0.,").replace("−", ""))
    value = float(mantissa.replace(",", "").replace("−", "-"))
    if power:
        value *= 10.0 ** int(exponent.translate(_SUPERSCRIPTS))
        return f"{value * to.factor + to.zero:.{max(digits, 1)}g}".replace("-", "−" if "·" in power else "-")
    decimals = len(mantissa.partition(".")[2]) - math.floor(math.log10(to.factor)) - coarser
    converted = value * to.factor + to.zero
    if converted and digits >= least > 0:
        decimals = max(decimals, least - 1 - math.floor(math.log10(abs(converted))))
    sign = "+" if text.startswith("+") else ""
    said = f"{round(converted, decimals) + 0.0:{sign}{',' if ',' in mantissa else ''}.{max(decimals, 0)}f}"
    return said.replace("-", "−") if "−" in mantissa else said
