"""Parse speeds: single values, lists and ranges."""

import math

from geometry.invalid import InvalidValue

_FORMS = "Write 6000, 800,3000,6000 or 800:9000:200 (both ends included)."
_MOST = 2000


def parse_speeds(text: str) -> tuple[float, ...]:
    """Read ``6000``, ``800,3000,6000`` or ``800:9000:200`` as speeds, rpm.

    Raises
    ------
    InvalidValue
        Anything else.
    """
    speeds: list[float] = []
    for part in text.split(","):
        speeds += _range(part) if ":" in part else [_number(part)]
    return tuple(dict.fromkeys(speeds))


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError as error:
        raise InvalidValue("--rpm", text, "is not a speed", _FORMS) from error
    if not math.isfinite(value):
        raise InvalidValue("--rpm", text, "must be finite", _FORMS)
    return value


def _range(text: str) -> list[float]:
    parts = text.split(":")
    if len(parts) != 3:
        raise InvalidValue("--rpm", text, "a range must have a start, an end and a step", _FORMS)
    start, end, step = (_number(part) for part in parts)
    if step <= 0 or end < start:
        rule = "the end of a range must not be below its start, and its step must be positive"
        raise InvalidValue("--rpm", text, rule, _FORMS)
    steps = (end - start) / step * (1 + 1e-12) + 1e-9
    if not steps < _MOST:
        rule = f"gives {steps + 1:.0f} speeds; at most {_MOST} are allowed"
        raise InvalidValue("--rpm", text, rule, "Use a larger step.")
    count = math.floor(steps) + 1
    speeds = [start + index * step for index in range(count)]
    if not math.isclose(speeds[-1], end):
        speeds.append(end)
    return speeds
