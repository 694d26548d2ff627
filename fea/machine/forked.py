"""Run a job that may crash in a child process, and return its result."""

import contextlib
import os
import pickle
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any, TypeVar

from geometry.errors import GeometryError
from geometry.system import ENDS, die_with_parent, held_back, through

Result = TypeVar("Result")

# Processor time allowed; a sound rod is read in a tenth of a second.
SECONDS = 60.0
# In the copy: the pipe to its parent.
_parent: IO[bytes] | None = None


def apart(
    job: Callable[[], Result],
    what: str,
    listener: Callable[[str], None] | None = None,
    *,
    who: str = "the CAD kernel",
) -> Result:
    """Return the result of `job` from a forked copy of this process, or raise the error raised there.

    The CAD kernel follows references in a file without checking them, and tries to heal and mesh impossible
    solids: a damaged file makes it access invalid memory or run forever. If processes cannot be forked
    (Windows), the job runs in this process.

    Parameters
    ----------
    job
        The job. Its result and its errors must be picklable, and it must have no other effects.
    what
        What it does, in words, for the message.
    listener
        Told what the job passes to `say`.
    who
        Which library does it, for the message.

    Raises
    ------
    GeometryError
        The copy was ended by a signal, ended without a result, or took longer than `SECONDS` of processor
        time or than it was allowed.
    """
    if not hasattr(os, "fork"):
        return job()
    sys.stdout.flush()
    sys.stderr.flush()
    read, write = os.pipe()
    child = 0
    try:
        with held_back():  # until the number of the child is known
            child = os.fork()
            if not child:
                os.close(read)
                _attempt(job, write)
        os.close(write)
        with os.fdopen(read, "rb") as pipe:
            told, outcome = _heard(pipe, listener)
        _, status, usage = os.wait4(child, 0)
    except BaseException:  # an interrupt: do not leave an orphan behind
        if child:
            with contextlib.suppress(ProcessLookupError, ChildProcessError):  # it has already ended
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
        raise
    if status:
        raise _death(status, usage.ru_utime + usage.ru_stime, f"{who} could not {what}", told)
    result, error = outcome
    if error is not None:
        raise error
    return result  # type: ignore[no-any-return]


def allow(seconds: float) -> None:
    """Allow a job that runs in a copy this much processor time from now on; otherwise do nothing."""
    if _parent is not None:
        signal.setitimer(signal.ITIMER_PROF, seconds)


def allow_memory(more: int) -> None:
    """Allow a job that runs in a copy this many further bytes, beyond which it gets a `MemoryError`."""
    if _parent is None or not sys.platform.startswith("linux"):
        return
    import resource  # noqa: PLC0415 - not on Windows

    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    most = pages * resource.getpagesize() + more
    resource.setrlimit(
        resource.RLIMIT_AS, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard)
    )


def say(what: str) -> None:
    """Tell the parent of a copy what the job does now; otherwise do nothing."""
    if _parent is not None:
        pickle.dump(what, _parent)
        _parent.flush()


def _heard(pipe: IO[bytes], listener: Callable[[str], None] | None) -> tuple[str, Any]:
    """Pass on what a copy says until it ends; return the last of it and the outcome, None without one."""
    last = ""
    with contextlib.suppress(EOFError, pickle.UnpicklingError):  # it died
        while isinstance(said := pickle.load(pipe), str):  # noqa: S301 - our own copy wrote it
            last = said
            if listener:
                listener(said)
        return last, said
    return last, None


def _death(status: int, seconds: float, what: str, told: str) -> BaseException:
    """Return the error of a copy that ended with a status after some seconds of processor time."""
    during = f", while {told}" if told else ""
    if not os.WIFSIGNALED(status):
        how = f"it stopped without a message{during}"
    elif os.WTERMSIG(status) in ENDS:
        return KeyboardInterrupt()
    elif os.WTERMSIG(status) == signal.SIGPROF:
        how = f"it did not finish within {seconds:.3g} s of processor time{during}"
    else:
        how = f"it crashed ({signal.Signals(os.WTERMSIG(status)).name}){during}"
    return GeometryError(f"{what}: {how}. The file may be damaged: export it again, with the rod alone")


def _attempt(job: Callable[[], Any], write: int) -> None:
    """In the child: run the job, send its outcome and end without any clean-up."""
    global _parent
    code = 1
    try:
        die_with_parent()
        for number in (*ENDS, signal.SIGPROF):
            signal.signal(number, signal.SIG_DFL)
        through()
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        with os.fdopen(write, "wb") as _parent:
            allow(SECONDS)
            _tell(job, _parent)
        code = 0
    finally:
        os._exit(code)


def _tell(job: Callable[[], Any], pipe: IO[bytes]) -> None:
    """Send the pair of result and error."""
    outcome: tuple[Any, Exception | None]
    try:
        outcome = job(), None
    except Exception as error:  # noqa: BLE001 - the parent raises any error
        outcome = None, error
    pickle.dump(outcome, pipe, protocol=pickle.HIGHEST_PROTOCOL)
