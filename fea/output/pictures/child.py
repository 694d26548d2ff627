"""Run the drawing process.

Pictures are drawn in a separate process, because a missing or broken OpenGL library may end it at once.
"""

import os
import subprocess
import sys
from collections.abc import Mapping

REMEDY = "Install the OpenGL libraries; on Debian or Ubuntu: apt-get install libegl1 libgl1 libxrender1."


def environments() -> list[dict[str, str]]:
    """Return the environments to try for the drawing process; on Linux, first one without a display."""
    plain = dict(os.environ)
    headless = plain | {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}
    if not sys.platform.startswith("linux") or "VTK_DEFAULT_OPENGL_WINDOW" in plain:
        return [plain]
    has_display = bool(plain.get("DISPLAY") or plain.get("WAYLAND_DISPLAY"))
    return [headless, plain] if has_display else [headless]


def run_drawing(module: str, orders: str, environment: Mapping[str, str], timeout: float) -> str:
    """Run ``python -m MODULE ORDERS``; return an explanation of a failure, in one line."""
    # No pipe to its input: with gmsh a broken pipe would end this process. -P: ignore the user's directory.
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
        return f"it took longer than {timeout:g} s"
    if done.returncode < 0:
        return f"the drawing process was ended by signal {-done.returncode}"
    lines = done.stderr.strip().splitlines()
    return lines[-1].rstrip(".") if done.returncode and lines else "the drawing process wrote no picture"
