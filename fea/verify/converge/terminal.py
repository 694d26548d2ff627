"""The comparison of error and run time on the terminal."""

from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table

from fea.verify.converge.row import Row

_TOOL = 12  # length of the longest word in a tool's name


def print_comparison(rows: Sequence[Row], advice: Sequence[str]) -> None:
    """Print one line per computation, and the advice."""
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=0)
    table.add_column("problem", no_wrap=True)
    table.add_column("tool", min_width=_TOOL)
    for name in ("size\nmm", "dofs", "time\ns", "MiB", "MPa", "error\n%"):
        table.add_column(name, justify="right", no_wrap=True)
    for row in rows:
        found, what = row.measured, row.computation
        table.add_row(
            *(what.problem, f"{what.name}, {what.element}", f"{found.size:.3g}", str(found.dofs)),
            *(f"{found.seconds:.2f}", f"{found.peak_memory:.0f}", f"{found.value:.1f}"),
            f"{row.error_percent:+.2f}",
        )
    console = Console(highlight=False)
    console.print(table)
    for line in advice:
        console.print(line, markup=False)
