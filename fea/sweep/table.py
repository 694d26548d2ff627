"""The table of a sweep, as CSV and Parquet: a row for each design and speed, in the order of the designs."""

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from fea.output.errors import StorageError
from fea.output.text import write_text
from fea.sweep.journal import Entry
from geometry.system.files import replaced

CSV, PARQUET = "sweep.csv", "sweep.parquet"
FIRST = ("row", "sample", "rpm", "state")


def table(entries: Iterable[Entry]) -> tuple[list[str], list[dict[str, Any]]]:
    """Return the names of the columns, and the rows by them; the varied keys keep their names."""
    rows = [_row(entry) for entry in entries]
    names = dict.fromkeys(FIRST)
    for part in ("design", "figures"):
        for row in rows:
            names |= dict.fromkeys(row[part])
    flat = [{**row["head"], **row["design"], **row["figures"], "reason": row["reason"]} for row in rows]
    return [*names, "reason"], flat


def write_tables(folder: Path, entries: Iterable[Entry]) -> None:
    """Write the table into a folder, each file completely or not at all.

    Raises
    ------
    StorageError
        The disk, a permission or the file system refuses.
    """
    names, rows = table(entries)
    text = io.StringIO()
    writer = csv.DictWriter(text, names, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows([{name: _plain(value) for name, value in row.items()} for row in rows])
    write_text(folder / CSV, text.getvalue())
    _write_parquet(folder / PARQUET, names, rows)


def _row(entry: Entry) -> dict[str, Any]:
    design = {key: value for key, value in entry.design.items() if key != "speed.rpm"}
    head = {"row": entry.number, "sample": entry.sample, "rpm": entry.rpm, "state": entry.state.value}
    return {"head": head, "design": design, "figures": entry.figures, "reason": entry.reason}


def _plain(value: Any) -> Any:
    return {True: "true", False: "false"}[value] if isinstance(value, bool) else value


def _write_parquet(path: Path, names: Sequence[str], rows: Sequence[dict[str, Any]]) -> None:
    import pyarrow as pa  # noqa: PLC0415 - comes with the extra
    from pyarrow import parquet  # noqa: PLC0415 - comes with the extra

    columns = {name: _column([row.get(name) for row in rows]) for name in names}
    try:
        with replaced(path) as place:
            parquet.write_table(pa.table(columns), place)
    except OSError as error:
        message = f"{path} could not be written: {error}. Choose another --out, or free disk space."
        raise StorageError(message) from error


def _column(values: list[Any]) -> list[Any]:
    """Return values of one type: numbers that are whole in some rows only are floats, mixtures are text."""
    kinds = {type(value) for value in values if value is not None}
    if kinds == {int, float}:
        return [None if value is None else float(value) for value in values]
    if len(kinds) > 1 or kinds & {list, dict}:
        return [None if value is None else str(value) for value in values]
    return values
