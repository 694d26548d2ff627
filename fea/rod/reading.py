"""Read a file from outside in a process of its own.

The CAD kernel follows references in a file without checking them, and tries to heal and mesh impossible
solids: a damaged file makes it access invalid memory or run forever.
"""

from collections.abc import Callable
from typing import TypeVar

from fea.machine.isolated import CrashError, OvertimeError, begun
from geometry.errors import GeometryError

Result = TypeVar("Result")

# Processor time allowed; a sound rod is read in a tenth of a second.
SECONDS = 60.0


def read_isolated(
    job: Callable[[], Result],
    what: str,
    *,
    who: str = "the CAD kernel",
    seconds: float | None = None,
    memory: int | None = None,
) -> Result:
    """Return the result of a job of a process as `begun` takes it; `who` could not do `what` if that ends.

    Raises `GeometryError`: it crashed, or took longer than `SECONDS`, the given time, or what it was allowed.
    """
    with begun(job, seconds=seconds or SECONDS, memory=memory) as process:
        result: Result = reading_errors(process.result, what, who)
    return result


def reading_errors(asked: Callable[[], Result], what: str, who: str = "the CAD kernel") -> Result:
    """Return what is asked of another process; `GeometryError` where that crashed or took too long."""
    try:
        return asked()
    except (CrashError, OvertimeError) as error:
        remedy = "The file may be damaged: export it again, with the rod alone"
        raise GeometryError(f"{who} could not {what}: {error}. {remedy}") from error
