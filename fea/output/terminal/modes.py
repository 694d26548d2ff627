"""Free vibration on the terminal."""

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from fea.analysis.modes import ModesFigures

_MOST_SPEEDS = 4


def print_modes(figures: ModesFigures, console: Console | None = None) -> None:
    """Print the modes, a row each.

    Parameters
    ----------
    figures
        What was found.
    console
        Where to; standard output by default.
    """
    console = console or Console(highlight=False)
    modes = figures.modes
    speeds = list(modes[0].orders)[:_MOST_SPEEDS]
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for title in ("mode", "Hz", *(f"order at\n{speed.removesuffix('rpm')} rpm" for speed in speeds)):
        table.add_column(title, justify="right")
    table.add_column("moves mostly")
    for number, mode in enumerate(modes, start=1):
        orders = (f"{mode.orders[speed]:.1f}" for speed in speeds)
        table.add_row(f"{number}", f"{mode.frequency_Hz:.0f}", *orders, mode.moves)
    console.print(f"{figures.study}: free–free vibration", markup=False, style="bold")
    console.print(table)
    if not figures.trusted:
        why = "there are not six rigid-body motions, or the modes do not satisfy their equation"
        console.print(f"NOT TO BE TRUSTED: {why}.")
    console.print(
        "An order is the number of periods per crank revolution; four-stroke engines excite half orders, too."
    )
