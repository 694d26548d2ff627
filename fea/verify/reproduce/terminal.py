"""The reproduction on the terminal: one line per printed table, the misprints, the counts."""

from collections.abc import Iterator, Sequence
from itertools import groupby

from rich import box
from rich.console import Console
from rich.table import Table as RichTable

from fea.verify.reproduce.row import Row, Status
from fea.verify.reproduce.summary import misprinted, summarise, verdict, worst
from fea.verify.reproduce.table import Table

_WORD = 13  # length of the longest word in a table's name


def print_reproduction(tables: Sequence[Table]) -> None:
    """Print the tables, the misprints and the counts."""
    console = Console(highlight=False)
    for source, own in groupby(tables, key=lambda table: table.source):
        study = list(own)
        console.print(_overview(source, study))
        lines = list(_misprints(study))
        if lines:
            console.print(
                "Errors in single cells (rounded intermediate figures are not listed):", style="italic"
            )
            for line in lines:
                console.print(f"  {line}", markup=False)
        console.print()
    console.print(verdict(tables), style="bold")
    console.print("All rows: use --json. Report with plots: use --report FILE.md", style="dim")


def _overview(source: str, tables: Sequence[Table]) -> RichTable:
    overview = RichTable(
        title=source, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0)
    )
    overview.add_column("table", min_width=_WORD)
    for name in ("cells", "agree", "expl.", "wrong"):
        overview.add_column(name, justify="right", no_wrap=True)
    overview.add_column("largest error (published → corrected)")
    for table in tables:
        counts = summarise([table])
        explained = counts.explained + counts.named
        numbers = (counts.compared, counts.agrees, explained, counts.wrong)
        overview.add_row(
            f"{table.name}  {table.title}", *(str(number) for number in numbers), _furthest(table)
        )
    return overview


def _furthest(table: Table) -> str:
    row = worst(table)
    if row is None or row.published is None:
        return "–"
    unit = "" if row.unit == "1" else f" {row.unit}"
    return f"{row.published:.4g} → {row.corrected:.4g}{unit}" + (f" at {row.at}" if row.at else "")


def _misprints(tables: Sequence[Table]) -> Iterator[str]:
    """One line per error, with the places where it occurs."""
    rows = [row for row in misprinted(tables) if not _is_rounding(row)]
    for (name, quantity, what), same in groupby(rows, key=lambda row: (row.table, row.quantity, _what(row))):
        places = " and ".join(row.at for row in same)
        yield ", ".join(filter(None, [name, quantity, places])) + f": {what}"


def _is_rounding(row: Row) -> bool:
    return row.slip is not None and row.slip.is_rounding and row.status is Status.EXPLAINED


def _what(row: Row) -> str:
    if row.slip is None or row.status is Status.UNEXPLAINED:
        return f"UNEXPLAINED: {row.published:.10g}, but the formula gives {row.as_published:.10g}"
    return row.slip.text
