"""The program run as a process."""

import os
import subprocess
import sys

COARSE = ("--size", 12)


def fea(*arguments, cwd, environment=None):
    """Run `fea` in a directory; the finished process with its output as text."""
    return subprocess.run(
        [sys.executable, "-m", "fea", *map(str, arguments)],
        cwd=cwd,
        env=os.environ | (environment or {}),
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
