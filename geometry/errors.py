"""The error for a value that breaks a rule, and the checks that raise it."""

import math
from enum import Enum
from typing import TypeVar

# Longest value shown in a message: enough to recognise it.
_SHOWN = 160


Kind = TypeVar("Kind", bound=type[Exception])


def public(error: Kind) -> Kind:
    """Give an error its public name, ``fea.InvalidValue``: the same in a checkout and in a wheel."""
    error.__module__ = "fea"
    return error


@public
class InvalidValue(ValueError):  # noqa: N818 - named for what it says
    """A given value breaks a stated rule.

    `name` is the quantity with its unit (``"rod.web_thickness_mm"``), `value` as given, None if it is
    missing, `rule` what must hold (``"must be positive"``), `remedy` what the user can do, `example` lines to
    copy that show how, not a part of the message.
    """

    def __init__(self, name: str, value: object, rule: str, remedy: str = "", example: str = "") -> None:
        self.name, self.value, self.rule, self.remedy, self.example = name, value, rule, remedy, example
        what = f"{name} {rule}" if value is None else f"{name} = {shown(value)}: {rule}"
        super().__init__(f"{what}." + (f" {remedy}" if remedy else ""))

    def __reduce__(self) -> tuple[type["InvalidValue"], tuple[object, ...]]:
        """Pickle the arguments, for errors that come from another process."""
        return type(self), (self.name, self.value, self.rule, self.remedy, self.example)


def shown(value: object) -> str:
    """Return a value as text for a message, however long or unprintable it is."""
    value = value.value if isinstance(value, Enum) else value
    try:
        text = f"{value:g}" if isinstance(value, float) else repr(value)
    except (ValueError, RecursionError):  # Python prints no integer beyond 4300 digits
        return f"<{type(value).__name__}>"
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN // 2]}…{text[-_SHOWN // 2 :]}"


def require(condition: bool, name: str, value: object, rule: str, remedy: str = "") -> None:  # noqa: FBT001
    """Raise `InvalidValue` unless `condition` holds."""
    if not condition:
        raise InvalidValue(name, value, rule, remedy)


def require_number(name: str, value: object) -> float:
    """Return `value` as a finite float, or raise `InvalidValue` (booleans are not numbers)."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not is_finite(value):
        raise InvalidValue(name, value, "must be a finite number")
    return float(value)


def is_finite(value: float) -> bool:
    """Whether a number is finite as a float (an integer may be too large for one)."""
    try:
        return math.isfinite(value)
    except OverflowError:
        return False


def require_positive(name: str, value: object) -> float:
    """Return `value` as a finite float above zero, or raise `InvalidValue`."""
    number = require_number(name, value)
    require(number > 0, name, value, "must be positive")
    return number


@public
class GeometryError(RuntimeError):
    """No usable solid could be made; the message says what failed and what to do."""
