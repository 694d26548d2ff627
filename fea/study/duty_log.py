"""A log of an engine in use: how long it turns at which speed and load, and in which order.

Its columns are found by their headings: time, engine speed, and load, boost or throttle where there is one.
Speed and load are counted in bins, each of which stands for its samples by the mean of a high power, as
damage goes with a power of the stress, and stress nearly with the square of the speed.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fea.base.note import Note, assumption, remark, warning
from fea.study.files import is_file
from fea.study.tables import quantity
from fea.study.trace_table import TraceTable, find_long_table, read_text
from geometry.arrays import Floats, Ints
from geometry.errors import InvalidValue, require

LARGEST_LOG = 2**27  # bytes: some millions of lines
LARGEST_RPM = 50_000.0  # faster than any piston engine; model aircraft engines reach about 40 000 rpm
_REMEDY = "A log needs columns of time and of engine speed with headings, such as time [s] and rpm."


class LogColumn(StrEnum):
    """What a column of a log holds."""

    TIME = "time"
    SPEED = "rpm"
    LOAD = "load"
    BOOST = "boost"
    THROTTLE = "throttle"


# Headings without their units, in small letters; the unit of the values, and that of a heading without one.
_COLUMNS = {
    LogColumn.TIME: ({"time", "t", "elapsed time", "zeit", "temps", "tiempo"}, "hours", "s"),
    LogColumn.SPEED: ({"rpm", "n", "engine speed", "engine rpm", "drehzahl", "regime"}, "rpm", "rpm"),
    LogColumn.LOAD: ({"load", "engine load", "calculated load", "last"}, "percent", "%"),
    LogColumn.BOOST: ({"boost", "boost pressure", "ladedruck"}, "bar", "bar"),
    LogColumn.THROTTLE: ({"throttle", "throttle position", "tps", "drosselklappe"}, "percent", "%"),
}
# In brackets, or behind a blank or an underscore.
_UNIT = re.compile(
    r"(?i)[\s_]*(?:[\[({]\s*([^\])}]+?)\s*[\])}]|[_ ](s|ms|min|h|rpm|hz|percent|%|bar|kpa|psi))\s*$"
)
_MOST_PERCENT, _FRACTION = 300.0, 1.5
# Where bins of speed end, as parts of the highest: the contact over the cycle of each takes seconds. Number
# of those of load; powers by which the samples of a bin are averaged; vacuum, bar gauge.
_SPEEDS, _LOADS = np.array([0.25, 0.5, *np.arange(7, 12) / 12]), 3
_POWERS, _VACUUM = (16.0, 8.0), -1.01325
# A step of time so many times the usual one, and of so many seconds, is a pause of the log.
_PAUSE, _LEAST_PAUSE = 20.0, 2.0
_STANDS, _COARSE = 50.0, 0.1  # rpm, below which the engine does not turn; s, that may hide a missed shift


class DutyEntry(NamedTuple):
    """A speed of a duty."""

    rpm: float
    share: float  #: of the time
    gas: str | None = None  #: in place of that of [engine]
    load: float | None = None  #: of a log, in percent or bar gauge


@dataclass(frozen=True, eq=False)
class DutyLog:
    """A log, sample by sample and in bins of speed and load."""

    source: str  #: name of the file
    kind: LogColumn | None  #: what its load is, None where it has none
    bins: tuple[DutyEntry, ...]
    hours: float  #: in which the engine turns
    visited: Ints  #: (n_stays,) bins in the order in which the engine came to them
    #: time, rpm, step: (n,) s, speed, s that the sample stands for
    time: Floats
    rpm: Floats
    step: Floats
    bin_of: Ints  #: (n,) bin of each sample, −1 where the engine stands
    pauses: int  #: of the log, which count no time

    def along(self, damage: Floats, count: int = 240) -> dict[str, Floats]:
        """Return the highest speed and the share of `damage` (n_cells,), percent, over intervals of time."""
        ends = np.linspace(self.time[0], self.time[-1] + self.step[-1], count + 1)
        first = np.searchsorted(self.time, ends)
        rate = damage / [each.share for each in self.bins]
        done = np.append(0.0, np.cumsum(np.append(rate, 0.0)[self.bin_of] * self.step))
        highest = np.array([self.rpm[a:b].max(initial=0.0) for a, b in pairwise(first)])
        shares = 100 * np.diff(done[first]) / (done[-1] or 1.0)
        return {"time_s": ends[:-1], "rpm": highest, "damage_percent": shares}

    def notes(self) -> Iterator[Note]:
        """Yield what a reader must know of the log."""
        if (interval := float(np.median(self.step))) >= _COARSE:
            change = float(np.abs(np.diff(self.rpm)).max())
            text = (
                f"{self.source} has a sample every {interval:.2g} s, in which the speed changes by up to "
                f"{change:.0f} rpm. Damage goes as the speed to the power 2k, k about 8: where a log misses "
                "4 % of its highest speed, half of the damage is missing; smoothed logs are too favourable"
            )
            yield warning(text, "life")
        if self.pauses:
            yield remark(f"{self.source} pauses {self.pauses} times: no time counts for that", "life")
        if self.kind is None:
            yield assumption(f"the gas of [engine] at every speed, as {self.source} has no load", "life")
        if self.kind is LogColumn.THROTTLE:
            yield assumption("a charge in proportion to the throttle, from 0.3 bar where it is shut", "life")


def read_log(path: Path) -> DutyLog:
    """Read a log. Raises `InvalidValue`: unreadable, a column is missing or of an unknown unit, and so on."""
    return _read(path, path.stat().st_mtime_ns if is_file(path) else 0)


@lru_cache(maxsize=2)
def _read(path: Path, _changed: int) -> DutyLog:
    return parse_log(read_text(path, "duty.log", LARGEST_LOG), path.name)


def parse_log(text: str, source: str) -> DutyLog:
    """Turn the text of a log into bins; `source` is its name in messages. Errors as of `read_log`."""
    try:
        table = find_long_table(text, source)
    except InvalidValue as error:
        if error.name != "engine.gas":  # a line of the table
            raise
        raise InvalidValue("duty.log", error.value, error.rule, _REMEDY) from error
    names = {i: _UNIT.sub("", table.names[i]).replace("_", " ").strip().lower() for i in table.numbers}
    found = {kind: [i for i, name in names.items() if name in of[0]] for kind, of in _COLUMNS.items()}
    columns = {kind: _values(table, own[0], kind) for kind, own in found.items() if own}
    listed = ", ".join(table.names[i] or f"column {i + 1}" for i in table.numbers)
    for kind, wanted in ((LogColumn.TIME, "time"), (LogColumn.SPEED, "engine speed")):
        rule = f"has no column of {wanted}; its columns of numbers are {listed}"
        require(kind in columns, "duty.log", source, rule, _REMEDY)
    time, rpm = 3600 * columns[LogColumn.TIME], columns[LogColumn.SPEED]
    require(len(time) > 1, "duty.log", source, "has only one sample", _REMEDY)
    back = np.flatnonzero(np.diff(time) <= 0)
    if back.size:
        line, later = table.lines[back[0] + 1], f"{time[back[0] + 1]:g} s after {time[back[0]]:g} s"
        raise InvalidValue(f"{source} line {line}", later, "time must increase from line to line")
    load = next((each for each in list(LogColumn)[2:] if each in columns), None)
    return _counted(source, load, time, rpm, np.zeros_like(rpm) if load is None else columns[load])


def _values(table: TraceTable, index: int, kind: LogColumn) -> Floats:
    """Values of a column in the unit of its kind; `InvalidValue`: in an unknown one, or not of an engine."""
    _, own, usual = _COLUMNS[kind]
    name, values = f"{table.source}: column {table.names[index]}", table.column(index)
    match = _UNIT.search(table.names[index])
    unit = next(filter(None, match.groups())) if match else ""
    values = values * quantity(name, f"1 {unit or usual}", own, change=True)
    if own == "percent" and not unit and values.max() <= _FRACTION:
        values *= 100
    most = {"percent": _MOST_PERCENT, "rpm": LARGEST_RPM}.get(own)
    shown = f"{values.min():g} to {values.max():g}"
    valid = most is None or (values.min() >= 0 and values.max() <= most)
    require(valid, name, shown, f"must lie between 0 and {most or 0:g} {own}")
    return values


def _counted(source: str, kind: LogColumn | None, time: Floats, rpm: Floats, load: Floats) -> DutyLog:
    """Count samples in bins of speed and load."""
    usual, turns = float(np.median(np.diff(time))), rpm >= _STANDS
    require(bool(turns.any()), "duty.log", source, f"has no speed above {_STANDS:g} rpm", _REMEDY)
    step = np.append(np.diff(time), usual)
    paused = step > max(_PAUSE * usual, _LEAST_PAUSE)
    step[paused] = usual
    low = float(load[turns].min())
    width = (float(load[turns].max()) - low) / _LOADS or 1.0
    number = np.clip((load - low) / width, 0, _LOADS - 1).astype(np.int64)
    number += _LOADS * np.searchsorted(_SPEEDS * rpm.max(), rpm)
    _, of_turning = np.unique(number[turns], return_inverse=True)
    bin_of = np.full(len(rpm), -1)
    bin_of[turns] = of_turning
    seconds = np.bincount(of_turning, step[turns])

    def mean(values: Floats, power: float) -> list[float]:
        scale = float(values.max()) or 1.0
        sums = np.bincount(of_turning, step[turns] * (values[turns] / scale) ** power)
        return list(scale * (sums / seconds) ** (1 / power))

    base = _VACUUM if kind is LogColumn.BOOST else 0.0
    of_loads = mean(np.maximum(load - base, 0), _POWERS[1])
    loads = [None if kind is None else float(f"{own + base:.3g}") for own in of_loads]
    speeds, total = [float(round(speed)) for speed in mean(rpm, _POWERS[0])], float(seconds.sum())
    bins = tuple(map(DutyEntry, speeds, seconds / total, [None] * len(loads), loads))
    visited = of_turning[np.append(True, np.diff(of_turning) != 0)]
    return DutyLog(source, kind, bins, total / 3600, visited, time, rpm, step, bin_of, int(paused.sum()))
