"""Signals that end the program, deferred while gmsh opens and closes, and SIGPIPE, which gmsh changes."""

import ctypes
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

# Sent by Ctrl-C, by `kill` or a batch system at its time limit, and by a terminal that is closed.
_ENDS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
ENDS = tuple(getattr(signal, name) for name in _ENDS if hasattr(signal, name))


@contextmanager
def held_back() -> Iterator[None]:
    """Defer `ENDS` here, and in processes started meanwhile until those call `through`.

    The first signal that arrived is raised afterwards. Ignored signals stay ignored, and those whose handlers
    Python did not set are left alone. Has no effect in other threads than the main one.
    """
    if sys.platform == "win32" or threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    # A mask alone would do if this were the only thread, but the system may deliver a signal to any thread.
    handlers = {number: signal.getsignal(number) for number in ENDS}
    awaited = {number: how for number, how in handlers.items() if how not in (signal.SIG_IGN, None)}
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
    """Accept `ENDS` again, in a process that was started while they were deferred."""
    if sys.platform != "win32":
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDS)


def ignore_broken_pipes_again() -> None:
    """Ignore SIGPIPE where Python does, whatever a library set: from any thread, unlike Python's own call."""
    if sys.platform != "win32" and signal.getsignal(signal.SIGPIPE) == signal.SIG_IGN:
        ctypes.CDLL(None).signal(signal.SIGPIPE, ctypes.c_void_p(int(signal.SIG_IGN)))
