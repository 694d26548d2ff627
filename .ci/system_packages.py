#!/usr/bin/env python3
"""Install the system libraries that gmsh and VTK need but pip cannot bring, or say how.

Each library is looked for by loading it, so that it does not matter which distribution this is. What is
missing is installed with apt by root; anyone else is told the exact command. Needs nothing but Python.
"""

import ctypes
import importlib.util
import os
import shutil
import subprocess
import sys

OLDEST = (3, 11)
PACKAGES = {  # by the library that proves it is there; names as in Debian and Ubuntu
    "libGLU.so.1": "libglu1-mesa",
    "libGL.so.1": "libgl1",
    "libXrender.so.1": "libxrender1",
    "libXcursor.so.1": "libxcursor1",
    "libXft.so.2": "libxft2",
    "libXinerama.so.1": "libxinerama1",
    "libgomp.so.1": "libgomp1",
    "libEGL.so.1": "libegl1",  # pictures without a display
}


def missing() -> list[str]:
    """Return the packages that are missing."""
    packages = [package for library, package in PACKAGES.items() if not loads(library)]
    if importlib.util.find_spec("ensurepip") is None:  # Debian keeps it apart: no virtual environment without
        packages.append("python3-venv")
    return packages


def loads(library: str) -> bool:
    """Return whether the dynamic linker finds a library."""
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def main() -> int:
    """Install what is missing, or explain."""
    if sys.version_info < OLDEST:
        return complain(f"Python {sys.version.split()[0]} is too old: 3.11 or later is needed.")
    packages = missing() if sys.platform == "linux" else []
    if not packages:
        return 0
    command = ["apt-get", "install", "--yes", "--no-install-recommends", *packages]
    if shutil.which("apt-get") is None:
        return complain(
            f"System packages are missing. Debian calls their packages: {' '.join(packages)}.\n"
            "Install what your distribution calls them, then repeat."
        )
    if os.geteuid() != 0:
        return complain(f"System packages are missing. Type this, then repeat:\n  {as_root(packages)}")
    environment = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    for step in (["apt-get", "update"], command):
        if subprocess.run(step, env=environment, check=False).returncode:  # noqa: S603 - fixed words
            return complain(f"`{' '.join(step)}` failed.")
    return 0


def as_root(packages: list[str]) -> str:
    """Return the line that brings packages, for someone who is not root but may become it."""
    line = f"apt-get update && apt-get install {' '.join(packages)}"
    if shutil.which("sudo") is None:
        return f"su -c '{line}'"
    return line.replace("apt-get", "sudo apt-get")


def complain(message: str) -> int:
    """Say what is wrong; return the exit code."""
    print(message, file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
