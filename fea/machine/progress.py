"""Progress messages on a terminal; none elsewhere."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_WORDS = {
    "geometry": "drawing the rod",
    "mesh": "meshing",
    "loads": "computing crank cycle and loads",
    "assembly": "assembling the stiffness",
    "factor": "factorising",
    "solve": "solving",
    "stress": "recovering the stress",
    "write": "writing the results",
    "picture": "drawing pictures",
}


@contextmanager
def stages(*, silent: bool) -> Iterator[Callable[[str], None] | None]:
    """Show the current stage on stderr if it is a terminal; yields the listener for a `Clock`."""
    if silent or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console  # noqa: PLC0415 - only a terminal shows progress

    console = Console(stderr=True)
    with console.status("starting") as status:

        def show(stage: str) -> None:
            if stage.startswith(("pass ", "meshing again")):  # stays on the screen
                console.print(stage, style="dim", highlight=False)
            else:
                status.update(f"{_WORDS.get(stage, stage)}…")

        yield show
