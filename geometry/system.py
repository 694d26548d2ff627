"""Files that are written completely or not at all."""

import contextlib
import secrets
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`; the file written there replaces `path` when the block ends.

    If the block ends with an exception (such as a full disk), `path` stays as it was. Anything that is not a
    regular file, such as a pipe, is written directly.

    Raises
    ------
    OSError
        With the name of `path`.
    """
    try:
        if path.exists() and not path.is_file():
            yield path
            return
        with _renamed(path.resolve()) as part:  # a link stays a link
            yield part
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


@contextmanager
def _renamed(target: Path) -> Iterator[Path]:
    """Yield a new name beside `target`, which is renamed to `target` if the block succeeds."""
    part = target.with_name(f".{secrets.token_hex(4)}.part")
    try:
        yield part
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)


# Sent by Ctrl-C, by `kill` or a batch system at its time limit, and by a terminal that is closed.
ENDS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
_PR_SET_PDEATHSIG = 1


@contextlib.contextmanager
def held_back() -> Iterator[None]:
    """Defer these signals here, and in processes started meanwhile until those call `through`.

    The first signal that arrived is raised afterwards. Signals that are ignored stay ignored, and signals
    whose handlers Python did not set (and could not restore) are left alone. Has no effect in threads other
    than the main one, which receive no signals.
    """
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "pthread_sigmask"):
        yield
        return
    came: list[int] = []
    # A mask alone would do if this were the only thread, but the system may deliver a signal to any thread.
    handlers = {number: signal.getsignal(number) for number in ENDS}
    awaited = {
        number: handler for number, handler in handlers.items() if handler not in (signal.SIG_IGN, None)
    }
    for number in awaited:
        signal.signal(number, lambda number, _frame: came.append(number))
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, awaited)
    try:
        yield
    finally:
        for number, handler in awaited.items():
            signal.signal(number, handler)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for number in came[:1]:
            signal.raise_signal(number)


def through() -> None:
    """Accept the signals again, in a process that was started while they were deferred."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDS)


def die_with_parent() -> None:
    """Ask the system to end this process when its parent is killed."""
    if sys.platform.startswith("linux"):
        with contextlib.suppress(Exception):  # best effort: the process works without it
            import ctypes  # noqa: PLC0415

            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
