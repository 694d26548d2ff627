"""Figures of a summary as words: what is not known, how many digits."""

from collections.abc import Mapping
from typing import Any

from fea.output.notes import error_bar

Summary = Mapping[str, Any]
UNKNOWN = "–"
# Wider or narrower than their columns.
_MANY_NEWTONS, _FAR_TOO_MANY, _SMALL_FACTOR = 999e3, 99_999e3, 0.095


def worst_case(summary: Summary) -> str:
    """Return the case with the smallest safety factor."""
    results: Mapping[str, Summary] = summary["results"]
    return min(results, key=lambda case: _or_infinity(results[case].get("min_safety_factor")))


def least_factor(summary: Summary) -> float:
    """Return the smallest safety factor of all cases, infinite where none has one."""
    return _or_infinity(summary["results"][worst_case(summary)].get("min_safety_factor"))


def number(value: float | None, form: str) -> str:
    """Return a number in a format, without a negative zero."""
    return UNKNOWN if value is None else format(value + 0.0, form)


def bar(percent: float | None) -> str:
    """Return an error bar."""
    return UNKNOWN if percent is None else error_bar(percent)


def kilo(newtons: float | None) -> str:
    """Return a force in kN with its sign: a tenth, whole ones where it is large, short where it is huge."""
    if newtons is None:
        return UNKNOWN
    form = "+z.1f" if abs(newtons) < _MANY_NEWTONS else "+.0f" if abs(newtons) < _FAR_TOO_MANY else "+.1e"
    return format(newtons / 1000, form)


def factor(value: float | None) -> str:
    """Return a safety factor: two places, two digits where it is so small that they would be none."""
    return number(value, ".2f" if value is None or value >= _SMALL_FACTOR else ".2g")


def _or_infinity(value: float | None) -> float:
    return float("inf") if value is None else value
