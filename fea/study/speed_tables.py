"""[speed] and [duty] of a study: the engine's speeds, how they are written, and how long it runs at each."""

import math
import re
from dataclasses import dataclass, replace
from pathlib import Path

from fea.study.duty_log import LARGEST_RPM, DutyEntry, DutyLog, read_log
from fea.study.engine_table import located_gas
from fea.study.files import located
from fea.study.tables import Positive, StudyTable, entries_of, key, quantity, within
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
    "Without [speed] these speeds are run, of a log its highest. Needs the S-N line of [material] or of its "
    "preset.",
    optional=True,
):
    """[duty]: speeds with the hours at each, or with their shares of the time; or a log."""

    rpm: tuple[Positive, ...] | None = key("[2000, 4000, 6000]")
    hours: tuple[Positive, ...] | None = key("[600, 350, 50]", "of a stretch of use, a value for each speed")
    share_percent: tuple[Positive, ...] | None = key("[60, 35, 5]", "instead of hours")
    gas: tuple[str, ...] | None = key(
        '["motored", "otto", "otto"]', "a value for each speed, as gas in [engine]; default: that one"
    )
    log: str | None = key(
        '"lap.csv"',
        "instead of all these, a file with columns of time, rpm and, if known, load (percent of full load), "
        "boost (gauge) or throttle (percent); headings name them and their units, such as time [s]",
    )

    def __post_init__(self) -> None:
        if self.log is not None:
            others = [name for name in entries_of(self) if name != "log"]
            rule = "cannot be combined with duty.log, which gives it"
            require(not others, f"duty.{', '.join(others)}", None, rule, "Remove one of them.")
            return
        speeds = self.rpm or ()
        require(len(speeds) > 0, "duty.rpm", [], "must contain at least one speed", "Give speeds, or a log.")
        count, rule = len(speeds), f"must contain at most {MOST_ENTRIES} speeds"
        require(count <= MOST_ENTRIES, "duty.rpm", count, rule, "Join speeds that are close to each other.")
        if (self.hours is None) == (self.share_percent is None):
            rule = "is missing" if self.hours is None else "cannot be combined with share_percent"
            remedy = "Give either hours or share_percent, a value for each speed."
            raise InvalidValue("duty.hours", None if self.hours is None else list(self.hours), rule, remedy)
        super().__post_init__()
        for name in ("hours", "share_percent", "gas"):
            given = getattr(self, name)
            rule = f"must have as many values as duty.rpm ({len(speeds)})"
            require(given is None or len(given) == len(speeds), f"duty.{name}", list(given or ()), rule)
        if self.share_percent is not None:
            total, rule = sum(self.share_percent), "must add up to 100"
            whole = abs(total - 100) <= _ROUNDING_PERCENT
            require(whole, "duty.share_percent", list(self.share_percent), f"{rule}, not to {total:g}")

    @property
    def read(self) -> DutyLog | None:
        """The log, if there is one. Raises `InvalidValue` as `read_log`."""
        return None if self.log is None else read_log(Path(self.log))

    @property
    def entries(self) -> tuple[DutyEntry, ...]:
        """Speeds with their shares of the time, which add up to 1; errors as of `read`."""
        if (log := self.read) is not None:
            return log.bins
        rpm, given = self.rpm or (), self.hours or self.share_percent or ()
        shares = (value / sum(given) for value in given)
        return tuple(map(DutyEntry, rpm, shares, self.gas or (None,) * len(rpm)))

    @property
    def total_hours(self) -> float | None:
        """Hours of the duty, where it has any; errors as of `read`."""
        of_log = None if self.log is None else read_log(Path(self.log)).hours
        return sum(self.hours) if self.hours else of_log

    @property
    def speeds(self) -> tuple[float, ...]:
        """Speeds, rpm, each once."""
        return tuple(dict.fromkeys(entry.rpm for entry in self.entries))

    @property
    def run_speeds(self) -> tuple[float, ...]:
        """Speeds, rpm, that are run where [speed] gives none: of a log, the highest."""
        return self.speeds if self.log is None else (max(self.speeds),)

    def located(self, folder: Path) -> "DutyTable":
        """Return the table with the paths of files made absolute."""
        gas = self.gas and tuple(located_gas("duty.gas", gas, folder) for gas in self.gas)
        log = None if self.log is None else str(located("duty.log", self.log, folder))
        return replace(self, gas=gas, log=log)
