"""Do in a child process what may end its process, and bring back what it gave."""

import contextlib
import os
import pickle
import signal
import sys
from collections.abc import Callable
from typing import IO, Any, TypeVar

from geometry.errors import GeometryError
from geometry.system.signals import ENDS, die_with_parent, held_back, through

Result = TypeVar("Result")

# Of processor time: a rod is read in a tenth of a second.
SECONDS = 60.0
_apart = False  # whether this process is the copy


def apart(job: Callable[[], Result], what: str) -> Result:
    """Return what `job` returns in a copy of this process, or raise what it raises there.

    The CAD kernel follows references in a file without looking where they lead, and heals and meshes what
    cannot be: a damaged file makes it step on memory that is not its own, or search without end. Where
    processes cannot be copied (Windows) the job is done here.

    Parameters
    ----------
    job
        What is done; what it returns and raises can be pickled, and it leaves nothing else behind.
    what
        In words, for the message.

    Raises
    ------
    GeometryError
        The copy was ended by a signal, left without a word, or took longer than `SECONDS` of processor
        time or what it was allowed.
    """
    if not hasattr(os, "fork"):
        return job()
    sys.stdout.flush()
    sys.stderr.flush()
    read, write = os.pipe()
    child = 0
    try:
        with held_back():  # until it is known whom to take along
            child = os.fork()
            if not child:
                os.close(read)
                _attempt(job, write)
        os.close(write)
        with os.fdopen(read, "rb") as pipe:
            said = pipe.read()
        _, status = os.waitpid(child, 0)
    except BaseException:  # an interrupt: leave no orphan behind
        if child:
            with contextlib.suppress(ProcessLookupError, ChildProcessError):  # it had ended
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
        raise
    if status:
        raise _death(status, what)
    result, error = pickle.loads(said)  # noqa: S301 - our own copy wrote it
    if error is not None:
        raise error
    return result  # type: ignore[no-any-return]


def allow(seconds: float) -> None:
    """Give a job that is done apart so much processor time from now on; elsewhere nothing is limited."""
    if _apart:
        signal.setitimer(signal.ITIMER_PROF, seconds)


def _death(status: int, what: str) -> BaseException:
    """Say how the copy ended."""
    if not os.WIFSIGNALED(status):
        how = "gives up"
    elif os.WTERMSIG(status) in ENDS:
        return KeyboardInterrupt()
    elif os.WTERMSIG(status) == signal.SIGPROF:
        how = "finds no end"
    else:
        how = f"dies ({signal.Signals(os.WTERMSIG(status)).name})"
    return GeometryError(f"the CAD kernel {how} when it is to {what}. The file is damaged: export it again")


def _attempt(job: Callable[[], Any], write: int) -> None:
    """In the child: do the job, say its outcome and end without any clean-up."""
    global _apart
    _apart, code = True, 1
    try:
        die_with_parent()
        for number in (*ENDS, signal.SIGPROF):
            signal.signal(number, signal.SIG_DFL)
        through()
        allow(SECONDS)
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        with os.fdopen(write, "wb") as pipe:
            _tell(job, pipe)
        code = 0
    finally:
        os._exit(code)


def _tell(job: Callable[[], Any], pipe: IO[bytes]) -> None:
    """Write the pair of result and error."""
    outcome: tuple[Any, Exception | None]
    try:
        outcome = job(), None
    except Exception as error:  # noqa: BLE001 - whatever it is, the parent raises it
        outcome = None, error
    pickle.dump(outcome, pipe, protocol=pickle.HIGHEST_PROTOCOL)
