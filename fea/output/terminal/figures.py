"""Figures as words: what is not known, how many digits."""

from collections.abc import Iterable

from fea.output.notes import error_bar

UNKNOWN = "–"
# Wider or narrower than their columns.
_MANY_NEWTONS, _FAR_TOO_MANY, _SMALL_FACTOR = 999e3, 99_999e3, 0.095


def number(value: float | None, form: str) -> str:
    """Return a number in a format, without a negative zero."""
    return UNKNOWN if value is None else format(value + 0.0, form)


def bar(percent: float | None) -> str:
    """Return an error bar."""
    return UNKNOWN if percent is None else error_bar(percent)


def place(coordinates: Iterable[float]) -> str:
    """Return coordinates in mm, to a tenth."""
    return ", ".join(number(coordinate, ".1f") for coordinate in coordinates)


def kilo(newtons: float | None) -> str:
    """Return a force in kN with its sign: a tenth, whole ones where it is large, short where it is huge."""
    if newtons is None:
        return UNKNOWN
    form = "+z.1f" if abs(newtons) < _MANY_NEWTONS else "+.0f" if abs(newtons) < _FAR_TOO_MANY else "+.1e"
    return format(newtons / 1000, form)


def factor(value: float | None) -> str:
    """Return a safety factor: two places, or two digits where it is so small that those would be zeros."""
    return number(value, ".2f" if value is None or value >= _SMALL_FACTOR else ".2g")
