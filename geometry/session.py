"""The only place that opens and closes gmsh, whose state is global to the process."""

import signal
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import gmsh

from geometry.signals import ENDS, held_back, ignore_broken_pipes_again

# The signals whose handlers gmsh changes.
_SIGNALS = [*ENDS, *([signal.SIGPIPE] if hasattr(signal, "SIGPIPE") else [])]

_one_thread = threading.RLock()


class GmshLog:
    """The messages of gmsh during a session; they can still be read after the session has ended."""

    ended: list[str] | None = None  #: every message, once the session has ended

    @property
    def lines(self) -> tuple[str, ...]:
        """Every message, each line with its kind in front (``"Warning: …"``)."""
        return tuple(gmsh.logger.get() if self.ended is None else self.ended)

    def warnings(self, first: int = 0) -> tuple[str, ...]:
        """Warnings and errors from line number `first` on, without repetition, in their order."""
        kinds = ("Warning", "Error")
        return tuple(dict.fromkeys(line for line in self.lines[first:] if line.startswith(kinds)))


@contextmanager
def session() -> Iterator[GmshLog]:
    """Open gmsh, silent and reproducible, and close it whatever happens; other threads wait until then.

    Yields its messages so far. Raises `RuntimeError`: a session is open already in this process.
    """
    with _one_thread:
        if gmsh.isInitialized():
            raise RuntimeError("a gmsh session is already open in this process: close it first")
        main = threading.current_thread() is threading.main_thread()
        handlers = {number: signal.getsignal(number) for number in _SIGNALS} if main else {}
        log = GmshLog()
        try:
            with held_back():  # an interrupt must not come while gmsh is half open
                # A user's ~/.gmshrc must not change results, nor gmsh take over Ctrl-C and broken pipes.
                gmsh.initialize(readConfigFiles=False, interruptible=False)
                gmsh.option.setNumber("General.Terminal", 0)
                gmsh.option.setNumber("General.NumThreads", 1)  # with more its meshes differ from run to run
                # For STEP files that are written; else the kernel takes that of the last one that it read.
                gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
                gmsh.logger.start()
            _restore(handlers)
            yield log
        finally:
            with held_back():
                if gmsh.isInitialized():
                    log.ended = list(gmsh.logger.get())
                    gmsh.logger.stop()
                    gmsh.finalize()
                _restore(handlers)


def _restore(handlers: Mapping[signal.Signals, Any]) -> None:
    """Restore the handlers of signals, except those that Python did not set and so cannot restore."""
    for number, handler in handlers.items():
        if handler is not None:
            signal.signal(number, handler)
    ignore_broken_pipes_again()
