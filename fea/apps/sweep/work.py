"""What a worker does: compute one rod, and say why if it cannot."""

import pickle
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from fea.apps.sweep.base import Base, Extras
from fea.apps.sweep.journal import Done
from fea.base.version import __version__
from fea.machine.isolated import CrashError, IsolatedProcess, OvertimeError, fresh
from fea.machine.threads import variables
from fea.study.study import parse_study

_LONGEST_REASON = 600
# Longest time of a rod: the largest shipped study takes some minutes on one core.
DEFAULT_MINUTES = 60.0
# Times that a rod is begun whose process crashes: memory that ran out may be there later.
_TRIES = 3
_OURS = ("fea", "geometry", "loads", "mesh")
# Each thread of a worker has one process, which computes rod after rod and which it outlives.
_of_thread = threading.local()
_processes: set[IsolatedProcess] = set()  # of all threads
_ended = threading.Event()  # they are being ended


class Rod(NamedTuple):
    """A rod to compute: its digest, the values of the varied keys, and its speeds."""

    job: str
    design: Mapping[str, Any]
    speeds: Sequence[float | None]


class Task(NamedTuple):
    """Some rods, their study, and what is asked beside."""

    rods: tuple[Rod, ...]
    base: Base
    extras: Extras
    version: str
    seconds: float = 60 * DEFAULT_MINUTES  #: the most that each rod may take
    threads: int = 1  #: of the process that computes


class VersionError(OSError):
    """A worker has another version of this program (exit code 7)."""


def work(task: Task, compute: Callable[..., Any] | None = None) -> list[Done]:
    """Compute rods in a process of their own; an error, a crash and the time limit of one are its reasons.

    `compute` replaces `fea.apps.sweep.evaluate.evaluate` in tests. Raises `VersionError`: this worker's
    version of the program is not that of the sweep.
    """
    if task.version != __version__:
        raise VersionError(
            f"a worker has version {__version__} of conrod-fea, and this sweep is of {task.version}: "
            "start its workers with the same version."
        )
    return [_worked(task, rod, compute) for rod in task.rods]


def _worked(task: Task, rod: Rod, compute: Callable[..., Any] | None) -> Done:
    start = time.perf_counter()
    ends: list[str] = []
    while len(ends) < _TRIES:
        try:
            return in_own_process(attempt, task, rod, compute, seconds=task.seconds, threads=task.threads)
        except OvertimeError:
            reason = (
                f"took longer than {task.seconds / 60:g} min and was ended: allow more with --limit-minutes, "
                "or use larger elements"
            )
            break
        except CrashError as error:
            if _ended.is_set():
                reason = "the sweep was interrupted"
                break
            ends.append(error.cause)
            memory = ": the memory may be too small; use fewer workers or larger elements"
            why = memory if "SIGKILL" in ends else ""  # as systems do where memory ends
            reason = f"its process crashed {_TRIES} times ({', '.join(dict.fromkeys(ends))}){why}"
    return Done(rod.job, {}, time.perf_counter() - start, reason)


def in_own_process(job: Callable[..., Done], *arguments: Any, seconds: float, threads: int = 1) -> Done:
    """Return a job's result from this thread's process. Raises `CrashError`, `OvertimeError`."""
    import cloudpickle  # noqa: PLC0415 - comes with the extra

    process: IsolatedProcess | None = getattr(_of_thread, "process", None)
    if process is None or not process.alive:
        if process is not None:
            process.close()
            _processes.discard(process)
        process = _of_thread.process = fresh(variables(threads))
        _processes.add(process)
        if _ended.is_set():
            process.close()
    done: Done = process.run(_unpacked, cloudpickle.dumps((job, arguments)), seconds=seconds)
    return done


@contextmanager
def own_processes() -> Iterator[None]:
    """End the processes of all threads with the block, also within a rod."""
    _ended.clear()
    try:
        yield
    finally:
        _ended.set()
        while _processes:
            _processes.pop().close()


def _unpacked(order: bytes) -> Any:
    """Do a job that was pickled by value, as one of a user's script must be."""
    job, arguments = pickle.loads(order)  # noqa: S301 - from our own process
    return job(*arguments)


def attempt(task: Task, rod: Rod, compute: Callable[..., Any] | None) -> Done:
    """Compute a rod of a task in this process; arguments as `work`."""
    start = time.perf_counter()
    try:
        asked = task.base.study(rod.design, rod.speeds)
        study = parse_study(asked.text(), asked.name, task.base.folder)  # as `fea sweep --study` prints it
        if compute is None:
            from fea.apps.sweep.evaluate import evaluate  # noqa: PLC0415 - only workers load what solves

        figures = (compute or evaluate)(study, task.extras)
    except Exception as error:  # noqa: BLE001 - whatever it is, the sweep goes on
        text = " ".join(str(error).split())
        ours = type(error).__module__.partition(".")[0] in _OURS
        reason = text if ours and text else f"internal error: {type(error).__name__}: {text}"
        return Done(rod.job, {}, time.perf_counter() - start, reason[:_LONGEST_REASON])
    return Done(rod.job, figures, time.perf_counter() - start)
