"""The benchmark problems on the terminal."""

from collections.abc import Sequence
from itertools import groupby

from rich import box
from rich.console import Console
from rich.table import Table

from fea.verify.benchmark import Row


def print_verification(rows: Sequence[Row]) -> None:
    """Print one line per quantity under each case, and the number of failures."""
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=0)
    table.add_column("case and quantity")
    for name in ("target", "computed", "error %", "limit %"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("", no_wrap=True)
    for case, own in groupby(rows, key=lambda row: row.case):
        quantities = list(own)
        cost = f"{quantities[0].dofs} dofs, {quantities[0].seconds:.1f} s"
        table.add_row(f"[bold]{case}[/bold] [dim]{cost}[/dim]")
        for row in quantities:
            table.add_row(*_cells(row), style=None if row.passed else "bold red")
    console = Console(highlight=False)
    console.print(table)
    console.print(verdict(rows), style="bold")


def _cells(row: Row) -> tuple[str, ...]:
    unit = f", {row.goal.unit}" if row.goal.unit != "1" else ""
    return (
        f"  {row.goal.quantity}{unit}",
        f"{row.goal.target:.4g}",
        f"{row.computed:.4g}",
        f"{row.error_percent:.2g}",
        f"{row.goal.tolerance_percent:.2g}",
        "pass" if row.passed else "FAIL",
    )


def verdict(rows: Sequence[Row]) -> str:
    """Return the number of failures as a sentence."""
    failed = [row for row in rows if not row.passed]
    cases = len({row.case for row in rows})
    if not failed:
        return f"All {len(rows)} quantities of {cases} benchmark problems are within their tolerances."
    names = ", ".join(dict.fromkeys(row.case for row in failed))
    return f"{len(failed)} of {len(rows)} quantities of {cases} benchmark problems FAILED: {names}."
