"""The error for a value that breaks a rule, and the checks that raise it."""

import math


class InvalidValue(ValueError):  # noqa: N818 - named for what it says
    """A given value breaks a stated rule.

    Parameters
    ----------
    name
        The quantity, with its unit where it has one (``"rod.web_thickness_mm"``).
    value
        The offending value as it was given.
    rule
        What must hold, in words (``"must be positive"``).
    remedy
        What the user can do, in words; may be empty.
    """

    def __init__(self, name: str, value: object, rule: str, remedy: str = "") -> None:
        self.name, self.value, self.rule, self.remedy = name, value, rule, remedy
        shown = f"{value:g}" if isinstance(value, float) else repr(value)
        super().__init__(f"{name} = {shown}: {rule}." + (f" {remedy}" if remedy else ""))


def require(condition: bool, name: str, value: object, rule: str, remedy: str = "") -> None:  # noqa: FBT001
    """Raise `InvalidValue` unless `condition` holds."""
    if not condition:
        raise InvalidValue(name, value, rule, remedy)


def require_number(name: str, value: object) -> float:
    """Return `value` as a finite float, or raise `InvalidValue` (booleans are not numbers)."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InvalidValue(name, value, "must be a finite number")
    return float(value)


def require_positive(name: str, value: object) -> float:
    """Return `value` as a finite float above zero, or raise `InvalidValue`."""
    number = require_number(name, value)
    require(number > 0, name, value, "must be positive")
    return number
