"""The table of a sweep, as CSV and Parquet: a row for each design and speed, in the order of the designs."""

import csv
import io
import re
import time
from collections import deque
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from fea.apps.sweep.journal import Entry, State
from fea.machine.clock import duration
from fea.output.text import stored, write_text

CSV, PARQUET = "sweep.csv", "sweep.parquet"
FIRST = ("row", "sample", "rpm", "state")


def table(entries: Iterable[Entry]) -> tuple[list[str], list[dict[str, Any]]]:
    """Return the names of the columns, and the rows by them; the varied keys keep their names."""
    rows, designs, figures = [], dict[str, None](), dict[str, None]()
    for entry in entries:
        design = {key: value for key, value in entry.design.items() if key != "speed.rpm"}
        head = dict(zip(FIRST, (entry.number, entry.sample, entry.rpm, entry.state.value), strict=True))
        rows.append({**head, **design, **entry.figures, "reason": entry.reason})
        designs |= dict.fromkeys(design)
        figures |= dict.fromkeys(entry.figures)
    return [*dict.fromkeys((*FIRST, *designs, *figures)), "reason"], rows


def write_tables(folder: Path, entries: Iterable[Entry]) -> None:
    """Write the table into a folder, each file completely or not at all.

    Raises `StorageError`: the disk, a permission or the file system refuses.
    """
    names, rows = table(entries)
    text = io.StringIO()
    writer = csv.DictWriter(text, names, restval="", lineterminator="\n")
    writer.writeheader()
    for row in rows:
        words = {name: str(value).lower() for name, value in row.items() if isinstance(value, bool)}
        writer.writerow(row | words)
    write_text(folder / CSV, text.getvalue())
    import pyarrow as pa  # noqa: PLC0415 - comes with the extra
    from pyarrow import parquet  # noqa: PLC0415 - comes with the extra

    columns = {name: _column([row.get(name) for row in rows]) for name in names}
    with stored(folder / PARQUET) as place:
        parquet.write_table(pa.table(columns), place)


def _column(values: list[Any]) -> list[Any]:
    """Return values of one type: numbers that are whole in some rows only are floats, mixtures are text."""
    kinds = {type(value) for value in values if value is not None}
    if kinds == {int, float}:
        return [None if value is None else float(value) for value in values]
    if len(kinds) > 1 or kinds & {list, dict}:
        return [None if value is None else str(value) for value in values]
    return values


_MINUTE = 60.0
# The rate is that of the last so many results: the first ones wait for libraries to load.
_RECENT = 50


class Progress:
    """Counts the rods that came back, of a total to compute now."""

    def __init__(self, total: int, clock: Callable[[], float] = time.monotonic) -> None:
        self.total, self.done = total, 0
        self._clock = clock
        self._times: deque[tuple[float, int]] = deque([(clock(), 0)], maxlen=_RECENT)

    def add(self, count: int) -> None:
        """Count rods that came back."""
        if count:
            self.done += count
            self._times.append((self._clock(), self.done))

    @property
    def rate(self) -> float | None:
        """Rods a second of late; None before any came back."""
        (start, before), now = self._times[0], self._clock()
        return (self.done - before) / (now - start) if self.done > before and now > start else None

    def text(self, threads: int) -> str:
        """Say how far it is, in a line."""
        share = f"{self.done} of {self.total} rods"
        if threads == 0:
            return f"{share}; no worker is there: waiting for one"
        rate = self.rate
        if rate is None:
            return f"{share}, {threads} at a time"
        pace = f"{rate:.2g} a second" if rate >= 1 else f"{_MINUTE * rate:.2g} a minute"
        return f"{share}, {pace}, {duration((self.total - self.done) / rate)} left"

    def shown_by(self, show: Callable[..., None]) -> Callable[[int, int, float], None]:
        """Return a listener that counts rods that came back and shows a line; arguments as of `Engine.run`.

        After the first ones it says what the sweep will cost.
        """

        def listener(count: int, threads: int, seconds: float) -> None:
            first = count > 0 and self.done == 0
            self.add(count)
            if first and threads and self.done < self.total:
                about = duration(seconds * (self.total - self.done) / min(threads, self.total))
                said = f"about {about} for {self.total} rods of {seconds:.2g} s, {threads} at a time"
                show(said, lasting=True)
            show(self.text(threads))

        return listener


_NUMBER = re.compile(r"\d[\d.e+-]*")


def failures(entries: Iterable[Entry]) -> list[tuple[int, str, int]]:
    """Return the first row and the reason of each kind of failure, and how many rows it has."""
    by_kind: dict[str, list[Entry]] = {}
    for entry in entries:
        if entry.state is State.FAILED:
            by_kind.setdefault(_NUMBER.sub("#", entry.reason), []).append(entry)
    return [(alike[0].number, alike[0].reason, len(alike)) for alike in by_kind.values()]
