"""The extreme cases on the terminal."""

from collections import Counter
from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table

from fea.verify.stability.row import ExtremeRow, Verdict

HEADER = ("case", "value", "backward error", "condition", "energy error", "error %", "verdict")
# Width of 1e-16.
_LEAST_WIDTH = 5
_STYLE = {Verdict.WRONG: "bold red", Verdict.MARKED: "yellow", Verdict.REFUSED: "yellow"}


def print_stability(rows: Sequence[ExtremeRow]) -> None:
    """Print one line per row, and the counts of the outcomes."""
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=0)
    table.add_column(HEADER[0], no_wrap=True)
    for name in HEADER[1:]:
        table.add_column(name, justify="right", min_width=_LEAST_WIDTH, no_wrap=name == HEADER[1])
    for row in rows:
        table.add_row(*cells(row), style=_STYLE.get(row.verdict))
    console = Console(highlight=False)
    console.print(table)
    console.print(counts(rows), style="bold")


def cells(row: ExtremeRow, digits: int = 0) -> tuple[str, ...]:
    """Return the row as text, in the order of `HEADER`, with a number of digits after the point."""
    quality = (row.backward_error, row.condition_estimate, row.energy_error, row.result_error_percent)
    shown = ("–" if value is None else f"{value:.{digits}e}" for value in quality)
    return (row.case, f"{row.parameter} = {row.value:g}", *shown, row.verdict.value)


def counts(rows: Sequence[ExtremeRow]) -> str:
    """Return the counts of the outcomes as a sentence."""
    found = Counter(row.verdict for row in rows)
    each = ", ".join(f"{found[verdict]} {verdict.value}" for verdict in Verdict)
    return f"{len(rows)} extreme cases: {each}."
