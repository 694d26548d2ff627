"""The journal of a sweep, one SQLite file, which any end of the program leaves whole, and its table.

Each change is one transaction in a write-ahead log. A process that dies, at whatever statement, loses what
was not committed and nothing else.
"""

import json
import re
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fea.apps.sweep.sweep_file import RowState, SweepRow
from fea.output.folder import StorageError, csv_text, stored, write_text
from fea.output.json_file import JsonObject
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


@dataclass(frozen=True)
class RodResult:
    """The result of a rod: figures by speed, rpm (None for given forces), or why there are none."""

    job: str
    figures: Mapping[float | None, Mapping[str, Any]]
    seconds: float
    reason: str = ""


class Journal:
    """The journal in a file, with one writer.

    Raises `InvalidValue`: it is not a journal; `StorageError`: the system refuses, of all methods, too.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with self._reported():
            self._base = sqlite3.connect(path, isolation_level="IMMEDIATE")
            query = "SELECT name FROM sqlite_master WHERE type = 'table'"
            tables = {name for (name,) in self._base.execute(query)}
            if tables and tables != {"meta", "rods"}:
                raise sqlite3.DatabaseError(f"it has the tables {', '.join(sorted(tables))}")
            self._base.execute("PRAGMA journal_mode = WAL")
            self._base.execute("PRAGMA synchronous = NORMAL")
            self._base.executescript(_TABLES)

    def close(self) -> None:
        """Close the file."""
        self._base.close()

    @property
    def meta(self) -> dict[str, str]:
        """Schema, version and identity of the sweep; empty for a new journal."""
        return dict(self._all("SELECT name, value FROM meta"))

    def enter(self, meta: Mapping[str, str], rows: Sequence[SweepRow]) -> None:
        """Enter all rows of a new sweep, or further ones, in one transaction."""
        with self._reported(), self._base:  # one transaction
            self._base.executemany("INSERT OR REPLACE INTO meta VALUES (?, ?)", list(meta.items()))
            self._base.executemany(
                "INSERT INTO rods (number, sample, design, rpm, job, key, state, reason) "
                "VALUES (:number, :sample, :design, :rpm, :job, :key, :state, :reason)",
                (vars(row) | {"design": json.dumps(row.design)} for row in rows),
            )

    def keys(self) -> list[str]:
        """Return the key of each row, in order."""
        return [key for (key,) in self._all("SELECT key FROM rods ORDER BY number")]

    def pending(self) -> list[str]:
        """Return the rods that must be computed, in order."""
        query = "SELECT job FROM rods WHERE state = 'pending' GROUP BY job ORDER BY min(number)"
        return [job for (job,) in self._all(query)]

    def counts(self) -> dict[RowState, int]:
        """Return how many rows are in each state."""
        by_state = dict(self._all("SELECT state, count(*) FROM rods GROUP BY state"))
        return {state: by_state.get(state.value, 0) for state in RowState}

    def design(self, job: str) -> tuple[JsonObject, list[float | None]]:
        """Return the design of a rod, and all its speeds."""
        rows = self._all("SELECT design, rpm FROM rods WHERE job = ? ORDER BY number", job)
        speeds = sorted({rpm for _, rpm in rows if rpm is not None})
        return json.loads(rows[0][0]), [*speeds] or [None]

    def finish(self, rods: Sequence[RodResult]) -> None:
        """Enter the results of rods, in one transaction; a row that is done stays as it is."""
        update = "UPDATE rods SET state = ?, reason = ?, figures = ?, seconds = ? "
        update += "WHERE job = ? AND state != 'done'"
        with self._reported(), self._base:  # one transaction
            for rod in rods:
                if rod.reason:
                    self._base.execute(update, ("failed", rod.reason, "{}", rod.seconds, rod.job))
                for rpm, figures in rod.figures.items():
                    values = ("done", "", json.dumps(figures), rod.seconds, rod.job, rpm)
                    self._base.execute(f"{update} AND rpm IS ?", values)

    def retry(self) -> None:
        """Let failed rods be computed again."""
        with self._reported(), self._base:  # one transaction
            query = "UPDATE rods SET state = 'pending', reason = '', seconds = NULL WHERE state = 'failed'"
            self._base.execute(query)

    def rows(self, number: int | None = None) -> Iterator[SweepRow]:
        """Yield all rows in order, or the one of a number."""
        query = "SELECT number, sample, design, rpm, state, reason, figures, job, key FROM rods"
        query += " ORDER BY number" if number is None else " WHERE number = ?"
        with self._reported():
            for n, sample, design, rpm, state, reason, figures, *digests in self._base.execute(
                query, () if number is None else (number,)
            ):
                values, results = json.loads(design), json.loads(figures)
                yield SweepRow(n, sample, values, rpm, RowState(state), reason, results, *digests)

    def _all(self, query: str, *values: Any) -> list[Any]:
        with self._reported():
            return self._base.execute(query, values).fetchall()

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


def write_tables(folder: Path, rows: Iterable[SweepRow]) -> None:
    """Write the table into a folder, each file completely or not at all. Raises `StorageError`.

    The varied keys keep their names.
    """
    lines, designs, figures = [], dict[str, None](), dict[str, None]()
    for row in rows:
        design = {key: value for key, value in row.design.items() if key != "speed.rpm"}
        head = {"row": row.number, "sample": row.sample, "rpm": row.rpm, "state": row.state.value}
        lines.append({**head, **design, **row.figures, "reason": row.reason})
        designs |= dict.fromkeys(design)
        figures |= dict.fromkeys(row.figures)
    names = [*dict.fromkeys(("row", "sample", "rpm", "state", *designs, *figures)), "reason"]
    cells = ([line.get(name) for name in names] for line in lines)
    words = ([str(cell).lower() if isinstance(cell, bool) else cell for cell in line] for line in cells)
    write_text(folder / CSV, csv_text([names, *words]))
    import pyarrow as pa  # noqa: PLC0415 - comes with the extra
    from pyarrow import parquet  # noqa: PLC0415 - comes with the extra

    columns = {name: _column([line.get(name) for line in lines]) for name in names}
    with stored(folder / PARQUET) as place:
        parquet.write_table(pa.table(columns), place)


def _column(values: list[Any]) -> list[Any]:
    """Cells of one type: numbers beside whole numbers, else text."""
    kinds = {type(value) for value in values if value is not None}
    if kinds == {int, float}:
        return [None if value is None else float(value) for value in values]
    if len(kinds) > 1 or kinds & {list, dict}:
        return [None if value is None else str(value) for value in values]
    return values


_NUMBER = re.compile(r"\d[\d.e+-]*")


def failures(rows: Iterable[SweepRow]) -> list[tuple[int, str, int]]:
    """Return the first row and the reason of each kind of failure, and how many rows it has."""
    by_kind: dict[str, list[SweepRow]] = {}
    for row in rows:
        if row.state is RowState.FAILED:
            by_kind.setdefault(_NUMBER.sub("#", row.reason), []).append(row)
    return [(alike[0].number, alike[0].reason, len(alike)) for alike in by_kind.values()]
