"""A rod in a process of its own, which its worker outlives: a crash or an endless rod ends no worker."""

import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from queue import SimpleQueue
from typing import IO, Any

import cloudpickle

from geometry.system import ENDS, die_with_parent

_START = "from fea.apps.sweep.apart import serve; serve()"
_own = threading.local()


class CrashError(Exception):
    """The process ended in the middle of a job; how it ended is the message."""


class EndlessError(Exception):
    """The job took longer than it may; the process was ended."""


def apart(job: Callable[..., Any], *arguments: Any, seconds: float) -> Any:
    """Return the result of a job from this thread's own process, which is started where there is none.

    Parameters
    ----------
    job, arguments
        Together with the result they must be picklable, by cloudpickle.
    seconds
        How long it may take, the start of the process included.

    Raises
    ------
    CrashError
        The process ended.
    EndlessError
        The job took longer; the process was killed.
    """
    process = _current()
    late = threading.Event()

    def end() -> None:
        late.set()
        process.kill()

    timer = threading.Timer(seconds, end)
    timer.daemon = True
    timer.start()
    try:
        return _asked(process, job, arguments)
    except (EOFError, OSError, pickle.UnpicklingError) as error:
        code = _buried(process)
        raise EndlessError if late.is_set() else CrashError(_how(code)) from error
    finally:
        timer.cancel()


def serve() -> None:
    """In the process: do what is asked until the worker ends."""
    die_with_parent()
    for number in ENDS:  # Ctrl-C is meant for the program, which ends its workers
        signal.signal(number, signal.SIG_IGN)
    asked: SimpleQueue[Any] = SimpleQueue()
    with os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(2, 1)  # libraries print: to nowhere
        threading.Thread(target=_listen, args=(sys.stdin.buffer, asked), daemon=True).start()
        while True:
            job, arguments = asked.get()
            _send(answers, job(*arguments))


def _current() -> "subprocess.Popen[bytes]":
    """Return this thread's process, a new one where it has ended."""
    process: subprocess.Popen[bytes] | None = getattr(_own, "process", None)
    if process is not None and process.poll() is None:
        return process
    if process is not None:
        _buried(process)
    process = _own.process = _started()
    return process


def _started() -> "subprocess.Popen[bytes]":
    """Start a process that finds the same modules as this one."""
    path = os.pathsep.join(place or str(Path.cwd()) for place in sys.path)
    return subprocess.Popen(  # noqa: S603 - our own interpreter and module
        [sys.executable, "-c", _START],
        env={**os.environ, "PYTHONPATH": path},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )


def _buried(process: "subprocess.Popen[bytes]") -> int:
    """Forget a process that has ended, and return its exit code."""
    _own.process = None
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with suppress(OSError):  # what was not sent
                pipe.close()
    return process.wait()


def _asked(process: "subprocess.Popen[bytes]", job: Callable[..., Any], arguments: Any) -> Any:
    into, out_of = process.stdin, process.stdout
    if into is None or out_of is None:  # never: both are pipes
        raise EOFError
    _send(into, (job, arguments))
    return _received(out_of)


def _send(pipe: IO[bytes], what: Any) -> None:
    pipe.write(cloudpickle.dumps(what))
    pipe.flush()


def _received(pipe: IO[bytes]) -> Any:
    return pickle.load(pipe)  # noqa: S301 - our own process wrote it


def _listen(pipe: IO[bytes], asked: "SimpleQueue[Any]") -> None:
    """Take jobs; end this process as soon as the worker has ended, also in the middle of a job."""
    try:
        while True:
            asked.put(_received(pipe))
    finally:
        os._exit(0)


def _how(code: int) -> str:
    """Say how a process ended."""
    if code >= 0:
        return f"exit code {code}"
    with suppress(ValueError):
        return signal.Signals(-code).name
    return f"signal {-code}"
