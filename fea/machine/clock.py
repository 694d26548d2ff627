"""Wall time per stage, with a listener for progress messages."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Clock:
    """Adds up wall seconds per stage, and notifies a listener when a stage begins.

    Parameters
    ----------
    listener
        Called with the name of each stage as it begins.
    """

    def __init__(self, listener: Callable[[str], None] | None = None) -> None:
        self.seconds: dict[str, float] = {}
        self._listener = listener
        self._start = time.perf_counter()

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Time a stage; entering the same name again adds to it."""
        if self._listener:
            self._listener(stage)
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - start

    def tell(self, what: str) -> None:
        """Notify the listener of an event within a stage."""
        if self._listener:
            self._listener(what)

    @property
    def total(self) -> float:
        """Seconds since the clock was made."""
        return time.perf_counter() - self._start
