"""How far a sweep is, at which rate, and how long it will take."""

import time
from collections import deque
from collections.abc import Callable

_MINUTE = 60.0
# The rate is that of the last so many results: the first ones wait for libraries to load.
_RECENT = 50


class Progress:
    """Counts what comes back.

    Parameters
    ----------
    total
        Rods to compute now.
    clock
        Seconds.
    """

    def __init__(self, total: int, clock: Callable[[], float] = time.monotonic) -> None:
        self.total, self.done = total, 0
        self._clock = clock
        self._times: deque[tuple[float, int]] = deque([(clock(), 0)], maxlen=_RECENT)

    def add(self, count: int) -> None:
        """Count rods that came back."""
        if count:
            self.done += count
            self._times.append((self._clock(), self.done))

    @property
    def rate(self) -> float | None:
        """Rods a second of late; None before any came back."""
        (start, before), now = self._times[0], self._clock()
        return (self.done - before) / (now - start) if self.done > before and now > start else None

    def text(self, threads: int) -> str:
        """Say how far it is, in a line."""
        share = f"{self.done} of {self.total} rods"
        if threads == 0:
            return f"{share}; no worker is there: waiting for one"
        rate = self.rate
        if rate is None:
            return f"{share}, {threads} at a time"
        left = (self.total - self.done) / rate
        return f"{share}, {_rate(rate)}, {duration(left)} left"

    def telling(self, say: Callable[[str], None]) -> Callable[[int, int], None]:
        """Return what is to be told how many rods came back, and how many threads compute."""

        def tell(count: int, threads: int) -> None:
            self.add(count)
            say(self.text(threads))

        return tell


def duration(seconds: float) -> str:
    """Return a time as text: ``"35 s"``, ``"12 min"``, ``"3 h 05 min"``."""
    if seconds < _MINUTE:
        return f"{seconds:.0f} s"
    minutes = round(seconds / _MINUTE)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"


def _rate(rate: float) -> str:
    return f"{rate:.2g} a second" if rate >= 1 else f"{_MINUTE * rate:.2g} a minute"
