"""Progress messages on a terminal; none elsewhere."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console

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
    console = Console(stderr=True)
    if silent or not console.is_terminal:
        yield None
        return
    with console.status("starting") as status:

        def show(stage: str) -> None:
            if stage.startswith(("pass ", "meshing again")):  # stays on the screen
                console.print(stage, style="dim", highlight=False)
            else:
                status.update(f"{_WORDS.get(stage, stage)}…")

        yield show
