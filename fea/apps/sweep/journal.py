"""The journal of a sweep, one SQLite file, which any end of the program leaves whole, and its table.

Each change is one transaction in a write-ahead log. A process that dies, at whatever statement, loses what
was not committed and nothing else.
"""

import json
import re
import sqlite3
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from fea.apps.sweep.sweep_file import PlannedRow
from fea.machine.clock import duration
from fea.output.json_file import JsonObject
from fea.output.target import StorageError
from fea.output.text import csv_text, stored, write_text
from geometry.errors import InvalidValue

SCHEMA = "fea/sweep/1"
_TABLES = """
CREATE TABLE IF NOT EXISTS meta (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS rods (
    number INTEGER PRIMARY KEY, sample INTEGER NOT NULL, design TEXT NOT NULL, rpm REAL,
    job TEXT NOT NULL, key TEXT NOT NULL, state TEXT NOT NULL, reason TEXT NOT NULL DEFAULT '',
    figures TEXT NOT NULL DEFAULT '{}', seconds REAL
);
CREATE INDEX IF NOT EXISTS rods_of_job ON rods (job);
CREATE INDEX IF NOT EXISTS rods_by_state ON rods (state, number);
"""


class State(StrEnum):
    """What has become of a row."""

    PENDING = "pending"
    DONE = "done"
    FAILED = "failed"


@dataclass(frozen=True)
class Done:
    """The result of a rod: figures by speed, rpm (None for given forces), or why there are none."""

    job: str
    figures: Mapping[float | None, Mapping[str, Any]]
    seconds: float
    reason: str = ""


@dataclass(frozen=True)
class Entry:
    """A row of the journal."""

    number: int
    sample: int
    design: JsonObject
    rpm: float | None
    state: State
    reason: str
    figures: JsonObject


class Journal:
    """The journal in a file, with one writer. Raises `InvalidValue`: it is no journal; `StorageError`."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with self._reported():
            self._base = sqlite3.connect(path, isolation_level=None)
            query = "SELECT name FROM sqlite_master WHERE type = 'table'"
            tables = {name for (name,) in self._base.execute(query)}
            if tables and tables != {"meta", "rods"}:
                raise sqlite3.DatabaseError(f"it has the tables {', '.join(sorted(tables))}")
            self._base.execute("PRAGMA journal_mode = WAL")
            self._base.execute("PRAGMA synchronous = NORMAL")

    def close(self) -> None:
        """Close the file."""
        self._base.close()

    @property
    def meta(self) -> dict[str, str]:
        """What the journal is of; empty for a new one."""
        with self._reported():
            known = self._base.execute("SELECT count(*) FROM sqlite_master WHERE name = 'meta'").fetchone()[0]
            return dict(self._base.execute("SELECT name, value FROM meta")) if known else {}

    def enter(self, meta: Mapping[str, str], rows: Sequence[PlannedRow]) -> None:
        """Enter all rows of a new sweep, or further ones, in one transaction."""
        with self._transaction():
            for statement in _TABLES.split(";"):
                self._base.execute(statement)
            self._base.executemany("INSERT OR REPLACE INTO meta VALUES (?, ?)", list(meta.items()))
            self._base.executemany(
                "INSERT INTO rods (number, sample, design, rpm, job, key, state, reason) VALUES (:number, "
                ":sample, :design, :rpm, :job, :key, iif(:refused = '', 'pending', 'failed'), :refused)",
                (vars(row) | {"design": json.dumps(row.design)} for row in rows),
            )

    def keys(self) -> list[str]:
        """Return the key of each row, in order."""
        return [key for (key,) in self._all("SELECT key FROM rods ORDER BY number")]

    def pending(self) -> list[str]:
        """Return the rods that must be computed, in order."""
        query = "SELECT job FROM rods WHERE state = 'pending' GROUP BY job ORDER BY min(number)"
        return [job for (job,) in self._all(query)]

    def counts(self) -> dict[State, int]:
        """Return how many rows are in each state."""
        by_state = dict(self._all("SELECT state, count(*) FROM rods GROUP BY state"))
        return {state: by_state.get(state.value, 0) for state in State}

    def asked(self, job: str) -> tuple[JsonObject, list[float | None]]:
        """Return the design of a rod, and all its speeds."""
        rows = self._all("SELECT design, rpm FROM rods WHERE job = ? ORDER BY number", job)
        speeds = sorted({rpm for _, rpm in rows if rpm is not None})
        return json.loads(rows[0][0]), [*speeds] or [None]

    def finish(self, rods: Sequence[Done]) -> None:
        """Enter what computed rods gave, in one transaction; a row that is done stays as it is."""
        update = (
            "UPDATE rods SET state = ?, reason = ?, figures = ?, seconds = ? "
            "WHERE job = ? AND rpm IS ? AND state != 'done'"
        )
        with self._transaction():
            for rod in rods:
                if rod.reason:
                    self._base.execute(
                        "UPDATE rods SET state = 'failed', reason = ?, seconds = ? "
                        "WHERE job = ? AND state != 'done'",
                        (rod.reason, rod.seconds, rod.job),
                    )
                for rpm, figures in rod.figures.items():
                    text = json.dumps(figures)
                    self._base.execute(update, ("done", "", text, rod.seconds, rod.job, rpm))

    def retry(self) -> int:
        """Let failed rods be computed again; return how many rows they are."""
        with self._transaction():
            query = "UPDATE rods SET state = 'pending', reason = '', seconds = NULL WHERE state = 'failed'"
            return self._base.execute(query).rowcount

    def entries(self, *numbers: int) -> Iterator[Entry]:
        """Return the rows of some numbers, or all, in order."""
        query = "SELECT number, sample, design, rpm, state, reason, figures FROM rods"
        if numbers:
            query += f" WHERE number IN ({', '.join('?' * len(numbers))})"
        with self._reported():
            for number, sample, design, rpm, state, reason, figures in self._base.execute(
                f"{query} ORDER BY number", numbers
            ):
                values, results = json.loads(design), json.loads(figures)
                yield Entry(number, sample, values, rpm, State(state), reason, results)

    def _all(self, query: str, *values: Any) -> list[Any]:
        with self._reported():
            return self._base.execute(query, values).fetchall()

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        with self._reported():
            self._base.execute("BEGIN IMMEDIATE")
            try:
                yield
                self._base.execute("COMMIT")
            except BaseException:
                if self._base.in_transaction:  # a full disk has rolled it back already
                    self._base.execute("ROLLBACK")
                raise

    @contextmanager
    def _reported(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.OperationalError as error:
            raise StorageError(
                f"{self.path} could not be written: {error}. Earlier entries are safe: free disk "
                "space or the lock, and run the same command again."
            ) from error
        except sqlite3.DatabaseError as error:
            rule = f"is not the journal of a sweep ({error})"
            raise InvalidValue("--out", str(self.path), rule, "Choose another directory.") from error


CSV, PARQUET = "sweep.csv", "sweep.parquet"
FIRST = ("row", "sample", "rpm", "state")


def table(entries: Iterable[Entry]) -> tuple[list[str], list[JsonObject]]:
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
    """Write the table into a folder, each file completely or not at all. Raises `StorageError`."""
    names, rows = table(entries)
    cells = ([row.get(name) for name in names] for row in rows)
    words = ([str(cell).lower() if isinstance(cell, bool) else cell for cell in row] for row in cells)
    write_text(folder / CSV, csv_text([names, *words]))
    import pyarrow as pa  # noqa: PLC0415 - comes with the extra
    from pyarrow import parquet  # noqa: PLC0415 - comes with the extra

    columns = {name: _column([row.get(name) for row in rows]) for name in names}
    with stored(folder / PARQUET) as place:
        parquet.write_table(pa.table(columns), place)


def _column(values: list[Any]) -> list[Any]:
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
            return f"{share}; waiting for a worker"
        rate = self.rate
        if rate is None:
            return f"{share}, {threads} at a time"
        pace = f"{rate:.2g} a second" if rate >= 1 else f"{_MINUTE * rate:.2g} a minute"
        return f"{share}, {pace}, {duration((self.total - self.done) / rate)} left"

    def shown_by(self, show: Callable[..., None]) -> Callable[[int, int, float], None]:
        """Return a listener of `Engine.run` that shows a progress line, and the cost after the first rods."""

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
