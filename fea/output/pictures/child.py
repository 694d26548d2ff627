"""The process that draws, as the process that asks for it sees it.

Drawing is a process of its own because an OpenGL library that is missing or broken may end it at once.
"""

import os
import subprocess
import sys
from collections.abc import Mapping

REMEDY = "On Debian or Ubuntu, `apt-get install libegl1 libgl1 libxrender1` brings what drawing needs."


def environments() -> list[dict[str, str]]:
    """Return what to tell the drawing process, in the order to try: on Linux first to need no display."""
    plain = dict(os.environ)
    headless = plain | {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}
    if not sys.platform.startswith("linux") or "VTK_DEFAULT_OPENGL_WINDOW" in plain:
        return [plain]
    has_display = bool(plain.get("DISPLAY") or plain.get("WAYLAND_DISPLAY"))
    return [headless, plain] if has_display else [headless]


def run_drawing(module: str, orders: str, environment: Mapping[str, str], timeout: float) -> str:
    """Run ``python -m MODULE ORDERS``; return what went wrong, in a line."""
    # Without a pipe to it: gmsh lets a broken one end this process. -P: no module of the user's directory.
    command = [sys.executable, "-P", "-m", module, orders]
    try:
        done = subprocess.run(  # noqa: S603 - our own interpreter and module
            command,
            stdin=subprocess.DEVNULL,
            env=environment,
            timeout=timeout,
            capture_output=True,
            text=True,
            encoding="utf-8",
            errors="replace",
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"drawing took longer than {timeout:g} s"
    if done.returncode < 0:
        return f"the drawing process was ended by signal {-done.returncode}"
    lines = done.stderr.strip().splitlines()
    return lines[-1].rstrip(".") if done.returncode and lines else "nothing came out"
