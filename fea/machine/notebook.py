"""Progress of what Python calls: shown in notebooks, and elsewhere where it is asked for."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from fea.machine.clock import progress_line


def in_notebook() -> bool:
    """Whether this is the kernel of a notebook."""
    if "IPython" not in sys.modules:
        return False
    from IPython import get_ipython  # noqa: PLC0415 - is loaded already

    return hasattr(get_ipython(), "kernel")


@contextmanager
def progress_shown(progress: bool | None, first: str) -> Iterator[Callable[[str], None]]:  # noqa: FBT001
    """Yield a function that shows a text in place of the last one: in a notebook, or where it is asked for.

    `progress`: True and False decide; None leaves it to where this runs.
    """
    notebook = in_notebook()
    if progress is False or (progress is None and not notebook):
        yield lambda _text: None
    elif notebook:
        from IPython.display import display  # noqa: PLC0415 - is loaded already

        shown = display({"text/plain": first}, raw=True, display_id=True)
        yield lambda text: shown.update({"text/plain": text}, raw=True)
    else:
        with progress_line(first, silent=False) as show:
            yield show
