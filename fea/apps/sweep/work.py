"""What a worker does: compute one rod, and say why if it cannot."""

import pickle
import threading
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

from fea.apps.sweep.journal import Done
from fea.machine.isolated import CrashError, IsolatedProcess, OvertimeError, fresh

_LONGEST_REASON = 600
# Longest time of a rod: the largest shipped study takes some minutes on one core.
DEFAULT_MINUTES = 60.0
# Times that a rod is begun whose process crashes: memory that ran out may be there later.
_TRIES = 3
_OURS = ("fea", "geometry", "loads", "mesh")
# Each thread of a worker has one process, which computes rod after rod and which it outlives.
_of_thread = threading.local()


class Task(NamedTuple):
    """A rod to compute: its digest, its study as a file, where paths start, and what is asked beside.

    `seconds` are those that it may take.
    """

    job: str
    name: str
    text: str
    folder: str
    frequencies: int
    version: str
    seconds: float = 60 * DEFAULT_MINUTES


class VersionError(OSError):
    """A worker has another version of this program (exit code 7)."""


def program_version() -> str:
    """Version of this program."""
    return version("conrod-fea")


def work(task: Task, compute: Callable[..., Any] | None = None) -> Done:
    """Compute a rod in a process of its own; its errors, its crash and its time limit are reasons.

    `compute` replaces `fea.apps.sweep.evaluate.evaluate` in tests.

    Raises
    ------
    VersionError
        This worker's version of the program is not that of the sweep.
    """
    if task.version != program_version():
        raise VersionError(
            f"a worker has version {program_version()} of conrod-fea, and this sweep is of {task.version}: "
            "start its workers with the same version."
        )
    start = time.perf_counter()
    ends: list[str] = []
    while len(ends) < _TRIES:
        try:
            return in_own_process(attempt, task, compute, seconds=task.seconds)
        except OvertimeError:
            reason = (
                f"took longer than {task.seconds / 60:g} min and was ended: allow more with --limit-minutes, "
                "or use larger elements"
            )
            break
        except CrashError as error:
            ends.append(error.cause)
            reason = f"its process crashed {_TRIES} times ({', '.join(dict.fromkeys(ends))}){_cause(ends)}"
    return Done(task.job, {}, time.perf_counter() - start, reason)


def in_own_process(job: Callable[..., Done], *arguments: Any, seconds: float) -> Done:
    """Return the result of a job from this thread's process; a new one is started where there is none.

    Raises
    ------
    CrashError, OvertimeError
        See `IsolatedProcess.run`; `seconds` include the start of the process.
    """
    import cloudpickle  # noqa: PLC0415 - comes with the extra

    process: IsolatedProcess | None = getattr(_of_thread, "process", None)
    if process is None or not process.alive:
        if process is not None:
            process.close()
        process = _of_thread.process = fresh()
    done: Done = process.run(_unpacked, cloudpickle.dumps((job, arguments)), seconds=seconds)
    return done


def _unpacked(order: bytes) -> Any:
    """Do a job that was pickled by value, as one of a user's script must be."""
    job, arguments = pickle.loads(order)  # noqa: S301 - from our own process
    return job(*arguments)


def attempt(task: Task, compute: Callable[..., Any] | None) -> Done:
    """Compute a rod in this process; arguments as `work`."""
    from fea.study.study import parse_study  # noqa: PLC0415 - a scheduler imports this module, too

    start = time.perf_counter()
    try:
        study = parse_study(task.text, task.name, Path(task.folder))
        figures = (compute or _analysis())(study, task.frequencies)
    except Exception as error:  # noqa: BLE001 - whatever it is, the sweep goes on
        return Done(task.job, {}, time.perf_counter() - start, reason_of(error))
    return Done(task.job, figures, time.perf_counter() - start)


def _cause(ends: list[str]) -> str:
    """What the system does to a process when its memory ends."""
    return ": the memory may be too small; use fewer workers or larger elements" if "SIGKILL" in ends else ""


def _analysis() -> Callable[..., Any]:
    from fea.apps.sweep.evaluate import evaluate  # noqa: PLC0415 - what solves is loaded by workers only

    return evaluate


def reason_of(error: BaseException) -> str:
    """Return why a rod failed, in a line."""
    text = " ".join(str(error).split())
    ours = type(error).__module__.partition(".")[0] in _OURS
    return (text if ours and text else f"internal error: {type(error).__name__}: {text}")[:_LONGEST_REASON]
