"""[speed] and [duty] of a study: the engine's speeds, how they are written, and how long it runs at each."""

import math
import re
from dataclasses import MISSING, dataclass, replace
from pathlib import Path

from fea.study.engine_table import located_gas
from fea.study.tables import Positive, StudyTable, key, quantity, within
from geometry.errors import InvalidValue, require, require_number

_FORMS = 'Write 6000, 800,3000,6000 or 800:9000:200 (both ends included), in rpm or with a unit: "100 Hz".'
_MOST_SPEEDS = 2000
_THOUSANDS = re.compile(r"[12]?\d,\d{3}(?!\d)")  # below 30 rpm, the first is no speed of an engine
_UNIT = re.compile(r"(?<=[\d.])\s*(?:[^\W\d_]|1?\s*/)[^,:]*$")  # after the last number


def parse_speeds(given: object) -> tuple[float, ...]:
    """Read ``6000``, ``800,3000,6000``, ``800:9000:200`` or numbers, as speeds, rpm; else `InvalidValue`.

    A unit at the end, as in ``"80,100 Hz"``, is that of all.
    """
    if not isinstance(given, str):
        entries = given if isinstance(given, list | tuple) else [given]
        return tuple(_number(one) if isinstance(one, str) else require_number("rpm", one) for one in entries)
    rule, remedy = "may be one speed with a comma in its number, or several", "Write 6000 without a comma."
    require(_THOUSANDS.match(given.strip()) is None, "--rpm", given, rule, remedy)
    *others, last = given.split(",")
    unit = _unit(last)
    parts = [part if _unit(part) else f"{part}{unit}" for part in others] + [last]
    speeds = [speed for part in parts for speed in (_range(part) if ":" in part else [_number(part)])]
    return tuple(dict.fromkeys(speeds))


def _unit(text: str) -> str:
    """Return the unit at the end of a speed or a range, "" if it has none."""
    try:
        float(text.rpartition(":")[2])
    except ValueError:
        match = _UNIT.search(text)
        return f" {match[0].strip()}" if match else ""
    return ""


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError as error:
        if _unit(text):
            return quantity("--rpm", text, "rpm")
        raise InvalidValue("--rpm", text, "is not a speed", _FORMS) from error
    if not math.isfinite(value):
        raise InvalidValue("--rpm", text, "must be finite", _FORMS)
    return value


def _range(text: str) -> list[float]:
    parts = text.split(":")
    if len(parts) != 3:
        raise InvalidValue("--rpm", text, "a range must have a start, an end and a step", _FORMS)
    unit = _unit(text)
    start, end, step = (_number(part if _unit(part) else f"{part}{unit}") for part in parts)
    if step <= 0 or end < start:
        rule = "the end of a range must not be below its start, and its step must be positive"
        raise InvalidValue("--rpm", text, rule, _FORMS)
    steps = (end - start) / step * (1 + 1e-12) + 1e-9
    if not steps < _MOST_SPEEDS:
        rule = f"gives {steps + 1:.0f} speeds; at most {_MOST_SPEEDS} are allowed"
        raise InvalidValue("--rpm", text, rule, "Use a larger step.")
    count = math.floor(steps) + 1
    speeds = [type(start)(start + index * step) for index in range(count)]
    if not math.isclose(speeds[-1], end):
        speeds.append(end)
    return speeds


# Faster than any piston engine; model aircraft engines reach about 40 000 rpm.
LARGEST_RPM = 50_000.0
DEFAULT_RPM = 6000.0


@dataclass(frozen=True)
class SpeedTable(StudyTable, table="speed"):
    """[speed]."""

    rpm: float | tuple[float, ...] | None = key(
        "6000",
        "or a list: [800, 3000, 6000]; left out: the redline of an engine of the library",
        stated=True,
        flag="rpm",
        help="Engine speeds, rpm: one (6000), a list (800,3000,6000) or from:to:step (800:9000:200).",
        kind=str,
        parse=parse_speeds,
    )

    def speeds(self, default: float = DEFAULT_RPM) -> tuple[float, ...]:
        """Return the speeds, rpm, in the order given; without any, `default`."""
        given = default if self.rpm is None else self.rpm
        values = given if isinstance(given, tuple) else (given,)
        require(len(values) > 0, "speed.rpm", [], "must contain at least one speed")
        for value in values:
            within(0, LARGEST_RPM)("speed.rpm", value)
        named = {f"{value:g}": value for value in reversed(values)}
        for value in values:
            rule = f"equals {named[f'{value:g}']!r} to six digits, so both would have the same name"
            require(named[f"{value:g}"] == value, "speed.rpm", repr(value), rule, "Leave one of them out.")
        return tuple(dict.fromkeys(values))


# Each entry takes a cycle over all nodes, in about a second.
MOST_ENTRIES = 100
# Shares may be rounded.
_ROUNDING_PERCENT = 0.1


@dataclass(frozen=True)
class DutyTable(
    StudyTable,
    table="duty",
    intro="How long the engine runs at which speeds, for the life of the rod; switches the crank cycle on. "
    "Without [speed] these speeds are run. Needs the S-N line of [material] or of its preset.",
    optional=True,
):
    """[duty]: speeds with the hours at each, or with their shares of the time."""

    rpm: tuple[Positive, ...] = key("[2000, 4000, 6000]", "", default=MISSING)
    hours: tuple[Positive, ...] | None = key("[600, 350, 50]", "of a stretch of use, a value for each speed")
    share_percent: tuple[Positive, ...] | None = key("[60, 35, 5]", "instead of hours")
    gas: tuple[str, ...] | None = key(
        '["motored", "otto", "otto"]', "a value for each speed, as gas in [engine]; default: that one"
    )

    def __post_init__(self) -> None:
        require(len(self.rpm) > 0, "duty.rpm", [], "must contain at least one speed")
        count, rule = len(self.rpm), f"must contain at most {MOST_ENTRIES} speeds"
        require(count <= MOST_ENTRIES, "duty.rpm", count, rule, "Join speeds that are close to each other.")
        if (self.hours is None) == (self.share_percent is None):
            rule = "is missing" if self.hours is None else "cannot be combined with share_percent"
            remedy = "Give either hours or share_percent, a value for each speed."
            raise InvalidValue("duty.hours", None if self.hours is None else list(self.hours), rule, remedy)
        super().__post_init__()
        for name in ("hours", "share_percent", "gas"):
            given = getattr(self, name)
            rule = f"must have as many values as duty.rpm ({len(self.rpm)})"
            require(given is None or len(given) == len(self.rpm), f"duty.{name}", list(given or ()), rule)
        if self.share_percent is not None:
            total, rule = sum(self.share_percent), "must add up to 100"
            whole = abs(total - 100) <= _ROUNDING_PERCENT
            require(whole, "duty.share_percent", list(self.share_percent), f"{rule}, not to {total:g}")

    @property
    def shares(self) -> tuple[float, ...]:
        """Share of the time at each speed; they add up to 1."""
        given = self.hours or self.share_percent or ()
        return tuple(value / sum(given) for value in given)

    @property
    def speeds(self) -> tuple[float, ...]:
        """Speeds, rpm, each once."""
        return tuple(dict.fromkeys(self.rpm))

    def located(self, folder: Path) -> "DutyTable":
        """Return the table with the paths of files made absolute."""
        if self.gas is None:
            return self
        return replace(self, gas=tuple(located_gas("duty.gas", gas, folder) for gas in self.gas))
