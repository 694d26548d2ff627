"""The table of bolts for the terminal, and as a file."""

from pathlib import Path

from fea.apps.bolts.run_bolts import BoltRow, BoltTableFigures
from fea.base.units import INCH
from fea.output.folder import csv_text, write_text
from fea.output.json_file import as_dict, json_text
from fea.output.tables import TableColumn
from fea.output.terminal.prose import plain_table, print_lines, terminal, unusual
from fea.output.units import UNKNOWN, factor, number

SUFFIXES = (".csv", ".json")
_TITLE = "bolt"
_THOUSANDTH = INCH / 1000


def _speed(row: BoltRow) -> str:
    if row.opens_at_rpm is None:
        return UNKNOWN if row.yield_factor is None else "never"
    return "any" if row.opens_at_rpm == 0 else number(row.opens_at_rpm, ".0f")


COLUMNS = (
    TableColumn("preload", "kN", "preload_kN", ".1f"),
    TableColumn("torque", "N·m", "torque_Nm", ".0f"),
    TableColumn("stretch", "mm", "stretch_mm", ".3f"),
    TableColumn("stretch", "thou", lambda row: row.stretch_mm / _THOUSANDTH, ".1f"),
    TableColumn("yield", "", "yield_factor", factor),
    TableColumn("fatigue", "", "fatigue_factor", factor),
    TableColumn("opens", "× load", "opening_factor", factor),
    TableColumn("opens", "rpm", _speed),
)


def print_bolts(found: BoltTableFigures) -> None:
    """Print the bolts by their threads, the present one bold and marked, and what is to be known of them."""
    console = terminal()
    print_lines(console, [f"{found.study} at {found.rpm:g} rpm: bolts that fit"], "bold")
    print_lines(console, unusual(found.notes))
    head = [column.heading.replace(", ", "\n") for column in COLUMNS]
    table = plain_table((_TITLE, *head), (), left=(_TITLE,), no_wrap=True, gap=0)
    thread = ""
    for row in found.rows:
        if row.thread != thread:
            thread = row.thread
            table.add_row(thread)
        cells = (column.proper(row) for column in COLUMNS)
        mark = "›" if row.present else " "
        table.add_row(f"{mark}{row.grade}", *cells, style="bold" if row.present else "")
    console.print(table)
    failed = () if found.trusted else ("A check failed: do not trust the result.",)
    print_lines(console, [*failed, *found.statements])


def write_bolts(path: Path, found: BoltTableFigures) -> None:
    """Write the table to a .csv file, or all figures to a .json file; raises `StorageError`."""
    if path.suffix.lower() == ".json":
        write_text(path, json_text(found))
        return
    rows = [as_dict(row) for row in found.rows]
    columns = dict.fromkeys(name for row in rows for name in row if name != "notes")
    write_text(path, csv_text([columns, *([row.get(name) for name in columns] for row in rows)]))
