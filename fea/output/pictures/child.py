"""Run a drawing process.

Pictures are drawn in a separate process, because a missing or broken OpenGL library may end it at once.
"""

import json
import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from tempfile import TemporaryFile
from typing import IO, Any

REMEDY = "Install the OpenGL libraries; on Debian or Ubuntu: apt-get install libegl1 libgl1 libxrender1."
PICTURES = "fea.output.pictures.render"

# A write to a process that has ended ends this one where gmsh is in use; a socket can be told not to.
_QUIETLY = getattr(socket, "MSG_NOSIGNAL", 0)
_NOTHING = "the drawing process wrote no picture"


def environments() -> list[dict[str, str]]:
    """Return what to try in the environment of the drawing process; on Linux, first without a display."""
    headless = {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}
    if not sys.platform.startswith("linux") or headless.keys() <= os.environ.keys():
        return [{}]
    has_display = bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    return [headless, {}] if has_display else [headless]


@dataclass(frozen=True)
class DrawingProcess:
    """A process that draws what it is told; see `drawing_process`."""

    module: str
    environment: dict[str, str]
    process: subprocess.Popen[bytes]
    orders: socket.socket
    said: IO[bytes]

    def can_draw(self, module: str, environment: dict[str, str]) -> bool:
        """Return whether it is alive, and a process of this module in this environment."""
        return (self.module, self.environment) == (module, environment) and self.process.poll() is None

    def draw(self, orders: object, timeout: float) -> str:
        """Have orders (for JSON) carried out; return an explanation of a failure, in one line."""
        try:
            self.orders.settimeout(timeout)
            with suppress(ConnectionError):
                self.orders.sendall(json.dumps(orders).encode() + b"\n", _QUIETLY)
                if self.orders.recv(1):
                    return _NOTHING
            code = self.process.wait(timeout)
        except (TimeoutError, subprocess.TimeoutExpired):
            self.process.kill()
            return f"it took longer than {timeout:g} s"
        if code < 0:
            return f"the drawing process was ended by signal {-code}"
        self.said.seek(0)
        lines = self.said.read().decode(errors="replace").strip().splitlines()
        return lines[-1].rstrip(".") if code and lines else _NOTHING


@contextmanager
def drawing_process(module: str, environment: dict[str, str]) -> Iterator[DrawingProcess]:
    """Start ``python -m MODULE``, which ends with the block, or when this process has ended.

    `environment` is added to that of this process.

    Raises
    ------
    OSError
        It could not be started.
    """
    command = [sys.executable, "-P", "-m", module]  # -P: ignore the user's directory
    alone = os.environ | {"OPENBLAS_NUM_THREADS": "1"}  # waiting threads would slow the analysis down
    ours, its = socket.socketpair()
    with ours, TemporaryFile() as said:
        with its:
            process = subprocess.Popen(  # noqa: S603 - our own interpreter and module
                command,
                stdin=its.fileno(),
                stdout=subprocess.DEVNULL,
                stderr=said,
                env=alone | environment,
            )
        try:
            yield DrawingProcess(module, environment, process, ours, said)
        finally:
            process.kill()
            process.wait()


_ready: ContextVar[DrawingProcess | None] = ContextVar("_ready", default=None)


@contextmanager
def ready_to_draw(*, wanted: bool = True) -> Iterator[None]:
    """Keep a process for all pictures of the block, which loads its libraries meanwhile."""
    with ExitStack() as stack:
        if wanted:
            with suppress(OSError):  # to be reported where something is to be drawn
                process = stack.enter_context(drawing_process(PICTURES, environments()[0]))
                stack.callback(_ready.reset, _ready.set(process))
        yield


def run_drawing(module: str, orders: object, environment: dict[str, str], timeout: float) -> str:
    """Have orders carried out by the process that is ready, or a new one; return as `DrawingProcess.draw`."""
    ready = _ready.get()
    if ready is not None and ready.can_draw(module, environment):
        return ready.draw(orders, timeout)
    try:
        with drawing_process(module, environment) as process:
            return process.draw(orders, timeout)
    except OSError as error:
        return str(error)


def ordered() -> Iterator[Any]:
    """In the process: yield orders while there may be more; asking for the next says that they are done."""
    for line in sys.stdin:
        yield json.loads(line)
        os.write(sys.stdin.fileno(), b"\n")
