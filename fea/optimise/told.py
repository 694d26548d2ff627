"""What a search says while it is under way."""

import sys
import time
from collections.abc import Callable

from fea.optimise.designs import Design
from fea.optimise.search import USUAL
from fea.study.optimise_table import OptimiseTable

_MINUTE = 60.0


def told(
    show: Callable[[str], None] | None, table: OptimiseTable, clock: Callable[[], float] = time.monotonic
) -> Callable[[Design, int], None]:
    """Return what is to be told each design: it shows a line that changes, or writes one a minute.

    Parameters
    ----------
    show
        Shows a line on a terminal; None where there is none.
    table
        For the number of evaluations.
    clock
        Seconds.
    """
    most, last, lightest = table.evaluations or USUAL, clock(), float("inf")

    def tell(design: Design, count: int) -> None:
        nonlocal last, lightest
        if design.margin >= 0:
            lightest = min(lightest, design.mass_kg)
        found = (
            f"lightest that holds: {1000 * lightest:.4g} g" if lightest < float("inf") else "none holds yet"
        )
        text = f"{count} of at most {most} meshes solved, {found}"
        if show is not None:
            show(text)
        elif clock() - last >= _MINUTE:
            last = clock()
            sys.stderr.write(f"fea: {text}\n")
            sys.stderr.flush()

    return tell
