"""What differs between operating systems: interrupts, limits of time and memory, locks, files."""

import atexit
import ctypes
import errno
import math
import os
import shutil
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, ClassVar

from geometry.signals import ENDS

# Whether this process can be copied: what macOS's libraries do in threads does not survive it.
CAN_FORK = hasattr(os, "fork") and sys.platform != "darwin"
# Exit codes of a process that has exceeded a limit which it watches itself.
OVERTIME, OUT_OF_MEMORY = 251, 252
_CALM = 1.0  # seconds during which further signals are ignored
# Seconds after which an interrupted program has ended, and those of them that it may remove files in.
_LONGEST, _CLEANING = 1.5, 0.3
_PR_SET_PDEATHSIG = 1


def interrupt_once(*, afresh: bool = False) -> None:
    """Raise `KeyboardInterrupt` at any of `ENDS`; a quick succession of signals counts as one.

    A signal that is ignored (`nohup`) or that a host program handles is left as it is. Threads other than the
    main one receive no signals and are left alone.

    `afresh` replaces whatever handles the signals now, such as the handlers set while the program starts.
    """
    AtInterrupt.came = False
    if threading.current_thread() is not threading.main_thread():
        return
    last = -_CALM

    def interrupt(_number: int, _frame: object) -> None:
        nonlocal last
        since, last = time.monotonic() - last, time.monotonic()
        if since >= _CALM:
            AtInterrupt.came = True
            raise KeyboardInterrupt

    for number in ENDS:
        handler = signal.getsignal(number)
        ours = handler in (signal.default_int_handler, signal.SIG_DFL)
        if ours or (afresh and handler is not signal.SIG_IGN):
            signal.signal(number, interrupt)


class AtInterrupt:
    """What the program says of an interrupt, and the files and folders that are incomplete meanwhile."""

    message = "interrupted; no incomplete result was left behind"
    came = False  #: whether there was one; libraries may raise an error in its place, as numpy does
    incomplete: ClassVar[set[Path]] = set()


@contextmanager
def saying(message: str) -> Iterator[None]:
    """Let an interrupt within the block say something else."""
    usual, AtInterrupt.message = AtInterrupt.message, message
    try:
        yield
    except KeyboardInterrupt:
        raise
    except BaseException:
        AtInterrupt.message = usual
        raise
    AtInterrupt.message = usual


@contextmanager
def incomplete(path: Path) -> Iterator[None]:
    """Let an interrupt remove a file or folder that is written in the block, where the program cannot."""
    AtInterrupt.incomplete.add(path)
    try:
        yield
    finally:
        AtInterrupt.incomplete.discard(path)


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`; the file written there replaces `path` when the block ends.

    If the block ends with an exception (such as a full disk), `path` stays as it was. Anything that is not a
    regular file, such as a pipe, is written directly. Raises `OSError`: with the name of `path`.
    """
    import secrets  # noqa: PLC0415 - it takes OpenSSL with it

    try:
        if path.exists() and not path.is_file():
            yield path
            return
        target = path.resolve()  # a link stays a link
        part = target.with_name(f".{secrets.token_hex(4)}.part")
        with incomplete(part):
            try:
                yield part
                part.replace(target)
            finally:
                part.unlink(missing_ok=True)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


def end_in_time(code: int) -> None:
    """End this process with `code` at most `_LONGEST` seconds after one of `ENDS`, even within a library.

    Python raises an interrupt once a call of a library returns, which takes a while for a mesh or a factor of
    a large matrix. A thread then removes what is incomplete, and ends the process. For a program's own
    process: copies of it have no such thread.
    """
    read, write = os.pipe()
    if sys.platform != "win32":
        os.set_blocking(write, False)
        os.register_at_fork(after_in_child=lambda: signal.set_wakeup_fd(-1))
    signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    threading.Thread(target=_end_in_time, args=(read, code), daemon=True).start()


def _end_in_time(read: int, code: int) -> None:
    while os.read(read, 1)[0] not in ENDS:
        pass
    time.sleep(_LONGEST - _CLEANING)
    last = threading.Thread(target=_clean, daemon=True)
    last.start()
    last.join(_CLEANING)
    with suppress(OSError):
        os.write(2, f"fea: {AtInterrupt.message}\n".encode())
    os._exit(code)


def _clean() -> None:
    for path in tuple(AtInterrupt.incomplete):
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)
    atexit._run_exitfuncs()  # noqa: SLF001 - temporary directories go


@contextmanager
def broken_pipes_raise() -> Iterator[None]:
    """Let writing to an ended process raise `BrokenPipeError`, even if gmsh left SIGPIPE to end this one."""
    if sys.platform == "win32" or sys.platform == "darwin":  # macOS has no `sigtimedwait`
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
    if sys.platform == "linux":
        with suppress(Exception):  # best effort: the process works without it
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def limit_processor_time(seconds: float) -> None:
    """End this process by SIGPROF, or with the code `OVERTIME`, after some processor time from now on."""
    if sys.platform == "win32":
        _watch.limit(seconds=seconds)
    else:
        signal.signal(signal.SIGPROF, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_PROF, seconds)


def limit_memory(more: int) -> None:
    """Limit this process to more bytes: `MemoryError` on Linux, exit code `OUT_OF_MEMORY` on Windows."""
    if sys.platform == "win32":
        _watch.limit(memory=more)
    elif sys.platform == "linux":
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        most = memory_of_process().vms + more
        most = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(resource.RLIMIT_AS, (most, hard))


def free_under_limit() -> int | None:
    """Return what the limit of this process leaves of its address space, bytes; None where there is none."""
    if sys.platform != "linux":
        return None
    else:  # noqa: RET505 - what stands after the block is read for Windows, too
        soft = resource.getrlimit(resource.RLIMIT_AS)[0]
        return None if soft == resource.RLIM_INFINITY else int(soft - memory_of_process().vms)


def memory_limit() -> int | None:
    """Return the smallest limit on this process's memory, bytes; None without one."""
    if sys.platform == "win32":
        return None
    else:  # noqa: RET505 - what stands after the block is read for Windows, too
        limits = [resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_AS, resource.RLIMIT_DATA)]
        return min((limit for limit in limits if limit != resource.RLIM_INFINITY), default=None)


def peak_memory(*, of_children: bool = False) -> float:
    """Largest resident memory so far, MiB, of this process or its largest ended child (Windows: NaN)."""
    if sys.platform == "win32":
        return math.nan if of_children else memory_of_process().peak_wset / 2**20
    else:  # noqa: RET505
        usage = resource.getrusage(resource.RUSAGE_CHILDREN if of_children else resource.RUSAGE_SELF)
        return usage.ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)


def memory_of_process() -> Any:
    """Return what psutil says of the memory of this process, bytes; on Windows `vms` is what is committed."""
    import psutil  # noqa: PLC0415 - most commands do without it

    return psutil.Process().memory_info()


def memory_of_machine() -> Any:
    """Return what psutil says of the memory of this machine, bytes: `total`, `available`."""
    import psutil  # noqa: PLC0415 - most commands do without it

    return psutil.virtual_memory()


def usable_processors() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


if sys.platform == "win32":
    from fea.machine.windows import ResourceLimiter, WindowsPathLock

    PathLock = WindowsPathLock

    _watch = ResourceLimiter(lambda: memory_of_process().vms, OVERTIME, OUT_OF_MEMORY)
else:
    import fcntl
    import resource

    class PathLock:
        """The lock of a file or directory; the system frees it when the process ends."""

        def __init__(self, path: Path) -> None:
            self._path, self._descriptor = path, -1

        def take(self, *, wait: bool) -> bool:
            """Take the lock; False where it is held, or where the file system has none."""
            try:
                self._descriptor = os.open(self._path, os.O_RDONLY)
            except OSError:
                return False
            try:
                fcntl.flock(self._descriptor, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                os.close(self._descriptor)
                return False
            return True

        def release(self) -> None:
            """Give the lock back."""
            with suppress(OSError):
                os.close(self._descriptor)


def flush(descriptor: int) -> None:
    """Write a file or directory to the disk itself; what macOS calls so leaves it in the disk's cache."""
    if sys.platform == "darwin":
        with suppress(OSError):  # not on every file system
            fcntl.fcntl(descriptor, fcntl.F_FULLFSYNC)
            return
    os.fsync(descriptor)


AT_FDCWD = -100  # Linux: paths are relative to the working directory
RENAME_EXCHANGE = 2
NOT_THERE = {errno.ENOSYS, errno.EINVAL}  # the kernel or the file system does not support the flag


def exchange(one: Path, other: Path) -> bool:
    """Exchange two paths; False, with nothing changed, if the system cannot. Raises `OSError`: it refused."""
    if sys.platform != "linux":
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
