"""Free vibration on the terminal."""

from collections.abc import Mapping
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

_MOST_SPEEDS = 4


def print_modes(figures: Mapping[str, Any], console: Console | None = None) -> None:
    """Print the modes, a row each.

    Parameters
    ----------
    figures
        Of `fea.analysis.modes.ModesReport`.
    console
        Where to; standard output by default.
    """
    console = console or Console(highlight=False)
    modes = figures["modes"]
    speeds = list(modes[0]["orders"])[:_MOST_SPEEDS]
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for title in ("mode", "Hz", *(f"order at\n{speed.removesuffix('rpm')} rpm" for speed in speeds)):
        table.add_column(title, justify="right")
    table.add_column("moves mostly")
    for number, mode in enumerate(modes, start=1):
        orders = (f"{mode['orders'][speed]:.1f}" for speed in speeds)
        table.add_row(f"{number}", f"{mode['frequency_Hz']:.0f}", *orders, mode["moves"])
    console.print(f"{figures['study']}: free vibration of the free rod", markup=False, style="bold")
    console.print(table)
    if not figures["trusted"]:
        console.print("NOT TO BE TRUSTED: the rigid motions are not six, or the modes are not solved.")
    console.print(
        "An order counts periods a turn of the crank; a four-stroke engine excites half orders too."
    )
