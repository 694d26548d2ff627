"""Locks on directories, which the system releases when their process ends for any reason."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

if sys.platform == "win32":  # pragma: no cover - directories cannot be locked: `take` always returns None

    def _lock(descriptor: int, *, wait: bool) -> None:
        raise OSError(descriptor, wait)

else:
    import fcntl

    def _lock(descriptor: int, *, wait: bool) -> None:
        """Lock an open file or raise OSError."""
        fcntl.flock(descriptor, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def held(directory: Path) -> Iterator[None]:
    """Hold the lock of `directory` during the block; on a file system without locks, do nothing."""
    descriptor = take(directory, wait=True)
    try:
        yield
    finally:
        release(descriptor)


def take(directory: Path, *, wait: bool = False) -> int | None:
    """Return a descriptor that holds the lock of `directory`, or None if it cannot be locked."""
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
    """Release a lock; None means that there is none."""
    if descriptor is not None:
        with suppress(OSError):
            os.close(descriptor)
