"""What differs between operating systems: signals, limits of a process, locks, exchanged directories.

It stands with the geometry because gmsh's session needs it.
"""

import ctypes
import errno
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

# Sent by Ctrl-C, by `kill` or a batch system at its time limit, and by a terminal that is closed.
ENDS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
CAN_FORK = hasattr(os, "fork")
_CALM = 1.0  # seconds during which further signals are ignored
_PR_SET_PDEATHSIG = 1


@contextmanager
def held_back() -> Iterator[None]:
    """Defer `ENDS` here, and in processes started meanwhile until those call `through`.

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
    """Accept `ENDS` again, in a process that was started while they were deferred."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDS)


def interrupt_once(*, afresh: bool = False) -> None:
    """Raise `KeyboardInterrupt` at any of `ENDS`; a quick succession of signals counts as one.

    A signal that is ignored (`nohup`) or that a host program handles is left as it is. Threads other than the
    main one receive no signals and are left alone.

    `afresh` replaces whatever handles the signals now, such as the handlers set while the program starts.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    last = -_CALM

    def interrupt(_number: int, _frame: object) -> None:
        nonlocal last
        since, last = time.monotonic() - last, time.monotonic()
        if since >= _CALM:
            raise KeyboardInterrupt

    for number in ENDS:
        handler = signal.getsignal(number)
        ours = handler in (signal.default_int_handler, signal.SIG_DFL)
        if ours or (afresh and handler is not signal.SIG_IGN):
            signal.signal(number, interrupt)


@contextmanager
def broken_pipes_raise() -> Iterator[None]:
    """Let writing to a process that has ended raise `BrokenPipeError`, even if SIGPIPE would end this one.

    gmsh, in a thread other than the main one, leaves it so.
    """
    if not hasattr(signal, "sigtimedwait"):
        yield
        return
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPIPE})
    try:
        yield
    finally:
        if signal.SIGPIPE not in mask:
            while signal.SIGPIPE in signal.sigpending():
                signal.sigtimedwait({signal.SIGPIPE}, 0)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def die_with_parent() -> None:
    """Ask the system to end this process when the thread that started it ends, even by ``kill -9``."""
    if sys.platform.startswith("linux"):
        with suppress(Exception):  # best effort: the process works without it
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def limit_processor_time(seconds: float) -> None:
    """End this process by SIGPROF after some processor time from now on, where the system can."""
    if hasattr(signal, "setitimer"):
        signal.signal(signal.SIGPROF, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_PROF, seconds)


def limit_memory(more: int) -> None:
    """Limit this process to so many further bytes, beyond which it gets a `MemoryError`, on Linux."""
    if sys.platform.startswith("linux"):
        import resource  # noqa: PLC0415 - not on Windows

        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        most = pages * resource.getpagesize() + more
        most = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(resource.RLIMIT_AS, (most, hard))


def memory_limit() -> int | None:
    """Return the smallest limit on this process's memory, bytes; None without one."""
    try:
        import resource  # noqa: PLC0415 - not on Windows
    except ImportError:
        return None
    limits = [resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_AS, resource.RLIMIT_DATA)]
    return min((limit for limit in limits if limit != resource.RLIM_INFINITY), default=None)


def peak_memory(*, of_children: bool = False) -> float:
    """Return the largest resident memory so far, MiB, of this process or of its largest ended child."""
    import resource  # noqa: PLC0415 - not on Windows

    usage = resource.getrusage(resource.RUSAGE_CHILDREN if of_children else resource.RUSAGE_SELF)
    return usage.ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)


def physical_memory() -> int | None:
    """Return the memory of this machine, bytes; None where it is unknown."""
    if not hasattr(os, "sysconf") or "SC_PHYS_PAGES" not in os.sysconf_names:
        return None
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def usable_processors() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


if sys.platform == "win32":  # pragma: no cover - directories cannot be locked

    def lock(descriptor: int, *, wait: bool) -> None:
        """Raise OSError."""
        raise OSError(descriptor, wait)

else:
    import fcntl

    def lock(descriptor: int, *, wait: bool) -> None:
        """Lock an open file or raise OSError."""
        fcntl.flock(descriptor, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)


AT_FDCWD = -100  # Linux: paths are relative to the working directory
RENAME_EXCHANGE = 2
NOT_THERE = {errno.ENOSYS, errno.EINVAL}  # the kernel or the file system does not support the flag


def exchange(one: Path, other: Path) -> bool:
    """Exchange two existing paths on one file system.

    Returns
    -------
    bool
        False if the system cannot do this in one step; then nothing has changed.

    Raises
    ------
    OSError
        The system supports it, but refused.
    """
    if not sys.platform.startswith("linux"):
        return False
    renameat2 = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)  # since glibc 2.28
    if renameat2 is None:
        return False
    if not renameat2(AT_FDCWD, os.fsencode(one), AT_FDCWD, os.fsencode(other), RENAME_EXCHANGE):
        return True
    code = ctypes.get_errno()
    if code in NOT_THERE:
        return False
    raise OSError(code, os.strerror(code), str(one), None, str(other))
