"""Try first in a child process what may end its process."""

import os
import signal
import sys
from collections.abc import Callable

from geometry.errors import GeometryError

SECONDS = 300  # of one trial; a rod takes a tenth of one


def survive(job: Callable[[], object], what: str) -> None:
    """Do `job` in a copy of this process, and refuse it when the copy does not live through it.

    The CAD kernel follows references in a file without looking where they lead, and a damaged file
    makes it step on memory that is not its own. What goes wrong in an orderly way is left for the real
    attempt to tell. Where processes cannot be copied (Windows) nothing is tried.

    Parameters
    ----------
    job
        What is tried; it may not write anything that lasts.
    what
        In words, for the message.

    Raises
    ------
    GeometryError
        The copy was ended by a signal, or took longer than `SECONDS`.
    """
    if not hasattr(os, "fork"):
        return
    sys.stdout.flush()
    sys.stderr.flush()
    child = os.fork()
    if not child:
        _attempt(job)
    try:
        _, status = os.waitpid(child, 0)
    except BaseException:  # an interrupt: leave no orphan behind
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        raise
    if os.WIFSIGNALED(status):
        raise GeometryError(f"the CAD kernel dies when it is to {what}. The file is damaged: export it again")


def _attempt(job: Callable[[], object]) -> None:
    """In the child: do the job and end, silently and without any clean-up."""
    try:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        signal.alarm(SECONDS)
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        job()
    finally:
        os._exit(0)
