"""Locks on directories, which the system releases when their process ends, however it ends."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

if sys.platform == "win32":  # pragma: no cover - no lock on a directory there: `take` always answers None

    def _lock(descriptor: int, *, wait: bool) -> None:
        raise OSError(descriptor, wait)

else:
    import fcntl

    def _lock(descriptor: int, *, wait: bool) -> None:
        """Lock an open file or raise OSError."""
        fcntl.flock(descriptor, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def held(directory: Path) -> Iterator[None]:
    """Hold the lock of `directory` during the block; without locks on its file system, just go on."""
    descriptor = take(directory, wait=True)
    try:
        yield
    finally:
        release(descriptor)


def take(directory: Path, *, wait: bool = False) -> int | None:
    """Return a descriptor that holds the lock of `directory`, or None where that cannot be had."""
    try:
        descriptor = os.open(directory, os.O_RDONLY)
    except OSError:
        return None
    try:
        _lock(descriptor, wait=wait)
    except OSError:
        os.close(descriptor)
        return None
    return descriptor


def release(descriptor: int | None) -> None:
    """Give a lock back; None is no lock."""
    if descriptor is not None:
        with suppress(OSError):
            os.close(descriptor)
