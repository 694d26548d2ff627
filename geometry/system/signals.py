"""The signals that ask a program to end, and how to put them off for a moment."""

import contextlib
import signal
import sys
import threading
from collections.abc import Iterator

# Ctrl-C, `kill` or a batch system whose time is up, a terminal that was closed.
ENDS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
_PR_SET_PDEATHSIG = 1


@contextlib.contextmanager
def held_back() -> Iterator[None]:
    """Put off these signals here, and in processes started meanwhile until these let them `through`.

    The first that came is raised afterwards. Those that are ignored stay so, and those that Python does not
    handle, which it could not give back; threads other than the main one get none.
    """
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "pthread_sigmask"):
        yield
        return
    came: list[int] = []
    # A mask alone would do if this were the only thread: the system may hand a signal to any of them.
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
    """In a process started while they were held back: let the signals through."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDS)


def die_with_parent() -> None:
    """Ask the system to end this process when its parent is killed."""
    if sys.platform.startswith("linux"):
        with contextlib.suppress(Exception):  # it is a courtesy
            import ctypes  # noqa: PLC0415

            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
