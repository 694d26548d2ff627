"""Wall time per stage, and progress: on stderr, or in a notebook."""

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Listener = Callable[[str], None]  #: called with the name of each stage as it begins


class Clock:
    """Adds up wall seconds per stage, and calls a listener with the name of each stage as it begins."""

    def __init__(self, listener: Listener | None = None) -> None:
        self.seconds: dict[str, float] = {}
        self._listener = listener
        self._start = time.perf_counter()

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Time a stage; entering the same name again adds to it."""
        self.tell(stage)
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - start

    def tell(self, event: str) -> None:
        """Notify the listener of an event within a stage."""
        if self._listener:
            self._listener(event)

    @property
    def total(self) -> float:
        """Seconds since the clock was made."""
        return time.perf_counter() - self._start


_MINUTE = 60.0
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


def in_words(stage: str) -> str:
    """Return what is done in a stage."""
    return _WORDS.get(stage, stage)


# Beginnings of events that stay on the screen, and are written where there is none.
_LASTING = ("pass ", "draft: ", "meshing again", "answer: ")
# A stage that takes longer is explained, s.
_PATIENCE = 150.0


@contextmanager
def stages(*, silent: bool, hint: str = "") -> Iterator[Listener | None]:
    """Yield a `Clock` listener that shows stages on stderr; `hint`: a remedy for one that takes minutes."""
    if silent:
        yield None
        return
    with _screen("starting", lambda _stage: None) as (status, write), _explained(write, hint) as watch:

        def show(stage: str) -> None:
            if stage.startswith(_LASTING):
                write(stage)
            else:
                status(f"{in_words(stage)}…")
            watch(stage)

        yield show


@contextmanager
def progress_line(first: str, *, silent: bool) -> Iterator[Callable[..., None]]:
    """Show the progress of a long job on stderr: a line that changes on a terminal, else a line a minute.

    Yields a function that shows a text, which stays, at once, with ``lasting=True``; `first` is shown on a
    terminal before, and nothing if `silent`.
    """
    if silent:
        yield lambda _text, **_options: None
        return
    with _screen(first, by_the_minute()) as (status, write):
        yield lambda text, *, lasting=False: (write if lasting else status)(text)


@contextmanager
def _screen(first: str, otherwise: Listener) -> Iterator[tuple[Listener, Listener]]:
    """Yield a function that shows a text on a terminal, else `otherwise`, and one that writes a line."""
    if not sys.stderr.isatty():
        yield otherwise, _line
        return
    from rich.console import Console  # noqa: PLC0415 - only a terminal shows progress

    console = Console(stderr=True)
    with console.status(first) as status:
        yield status.update, lambda text: console.print(text, style="dim", highlight=False)


def _line(text: str) -> None:
    sys.stderr.write(f"fea: {text}\n")
    sys.stderr.flush()


@contextmanager
def _explained(write: Listener, hint: str) -> Iterator[Listener]:
    """Yield a function to be called with each stage; one that takes long is written, with the hint."""
    stage, ended, changed = "starting", threading.Event(), threading.Event()

    def watch() -> None:
        waited = 0.0
        while not ended.is_set():
            if changed.wait(_PATIENCE):
                changed.clear()
                waited = 0.0
            else:
                waited += _PATIENCE
                write(f"still {in_words(stage)}, for {waited / 60:.0f} min{hint and f'; {hint}'}")

    def change(now: str) -> None:
        nonlocal stage
        stage = now
        changed.set()

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield change
    finally:
        ended.set()
        changed.set()
        thread.join()


def duration(seconds: float) -> str:
    """Return a time as text: ``"35 s"``, ``"12 min"``, ``"3 h 05 min"``."""
    if seconds < _MINUTE:
        return f"{seconds:.0f} s"
    minutes = round(seconds / _MINUTE)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"


def by_the_minute(clock: Callable[[], float] = time.monotonic) -> Callable[..., None]:
    """Return a function that writes a text to stderr if ``lasting=True``, or the last one is a minute old."""
    last = clock()

    def show(text: str, *, lasting: bool = False) -> None:
        nonlocal last
        if lasting or clock() - last >= _MINUTE:
            last = last if lasting else clock()
            _line(text)

    return show


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
