"""What a worker does: compute one rod, and tell why where it cannot."""

import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

from fea.sweep.journal import Done

_LONGEST_REASON = 600
_OURS = ("fea", "geometry", "loads", "mesh")


class Task(NamedTuple):
    """A rod to compute: its digest, its study as a file, where paths start, and what is asked beside."""

    job: str
    name: str
    text: str
    folder: str
    frequencies: int
    version: str


class VersionError(OSError):
    """A worker has another version of this program (exit code 7)."""


def program_version() -> str:
    """Version of this program."""
    return version("conrod-fea")


def work(task: Task, compute: Callable[..., Any] | None = None) -> Done:
    """Compute a rod; its errors are reasons.

    Parameters
    ----------
    task
        The rod.
    compute
        In place of `fea.sweep.evaluate.evaluate`, for tests.

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
    from fea.study.study import parse_study  # noqa: PLC0415 - a scheduler imports this module, too

    start = time.perf_counter()
    try:
        study = parse_study(task.text, task.name, Path(task.folder))
        figures = (compute or _analysis())(study, task.frequencies)
    except Exception as error:  # noqa: BLE001 - whatever it is, the sweep goes on
        return Done(task.job, {}, time.perf_counter() - start, reason_of(error))
    return Done(task.job, figures, time.perf_counter() - start)


def _analysis() -> Callable[..., Any]:
    from fea.sweep.evaluate import evaluate  # noqa: PLC0415 - what solves is loaded by workers only

    return evaluate


def reason_of(error: BaseException) -> str:
    """Return why a rod failed, in a line."""
    text = " ".join(str(error).split())
    ours = type(error).__module__.partition(".")[0] in _OURS
    return (text if ours and text else f"internal error: {type(error).__name__}: {text}")[:_LONGEST_REASON]
