"""The process that draws: apart from the analysis, because a broken OpenGL library may end it at once."""

import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from importlib import import_module

from fea.machine.isolated import CrashError, IsolatedProcess, OvertimeError, fresh

_RENDER = "fea.output.pictures.drawing"
_ready: ContextVar[IsolatedProcess | None] = ContextVar("_ready", default=None)


def environments() -> list[dict[str, str]]:
    """Return what to try in the environment of the drawing process; on Linux, first without a display."""
    headless = {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}
    if not sys.platform.startswith("linux") or headless.keys() <= os.environ.keys():
        return [{}]
    has_display = bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    return [headless, {}] if has_display else [headless]


@contextmanager
def ready_to_draw(*, wanted: bool = True) -> Iterator[None]:
    """Keep a process for all pictures of the block, which loads its libraries meanwhile."""
    with ExitStack() as stack:
        if wanted:
            with suppress(OSError):  # to be reported where something is to be drawn
                process = stack.enter_context(drawing_process(environments()[0]))
                process.begin(_called, f"{_RENDER}:warm_up")
                stack.callback(_ready.reset, _ready.set(process))
        yield


def drawing_process(environment: dict[str, str]) -> IsolatedProcess:
    """Start a process whose environment is that of this one and the given one."""
    alone = {"OPENBLAS_NUM_THREADS": "1"}  # waiting threads would slow the analysis down
    return fresh(alone | environment, messages=True)


def run_drawing(job: str, *arguments: object, environment: dict[str, str], timeout: float) -> str:
    """Do a job in the process that is ready, or a new one; return why it failed, in one line, or "".

    The job is a function, ``"module:name"``, whose module only that process imports.
    """
    ready = _ready.get()
    if ready is not None and ready.alive and environment == environments()[0]:
        return explained(ready, job, *arguments, timeout=timeout)
    try:
        with drawing_process(environment) as process:
            return explained(process, job, *arguments, timeout=timeout)
    except OSError as error:  # it could not be started
        return str(error)


def explained(process: IsolatedProcess, job: str, *arguments: object, timeout: float) -> str:
    """Do a job in a process; return as `run_drawing`."""
    try:
        process.run(_called, job, *arguments, seconds=timeout)
    except OvertimeError as error:
        return str(error)
    except CrashError as error:
        exited = error.cause.startswith("exit")
        said = process.last_message if exited else f"the drawing process ended ({error.cause})"
        return said.rstrip(".") or str(error)
    except Exception as error:  # noqa: BLE001 - whatever a library raises
        return f"{type(error).__name__}: {error}".rstrip(".")
    return ""


def _called(job: str, *arguments: object) -> None:
    module, _, name = job.partition(":")
    getattr(import_module(module), name)(*arguments)
