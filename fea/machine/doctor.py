"""Examine the machine: try everything that a run needs, in a separate process if it may crash."""

import importlib.metadata
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

_APT = "apt-get install libglu1-mesa libgl1 libxrender1 libxcursor1 libxft2 libxinerama1 libgomp1 libegl1"


@dataclass(frozen=True)
class Finding:
    """The result of examining one requirement.

    Attributes
    ----------
    what, found
        In words.
    good
        Whether it works.
    needed
        Whether `fea run` needs it.
    remedy
        What to do if it does not work; shown only then.
    """

    what: str
    found: str
    good: bool
    needed: bool
    remedy: str


def examine() -> list[Finding]:
    """Try everything that a run may need."""
    return [
        _python(),
        _library("geometry and meshing", "gmsh", "import gmsh; gmsh.initialize(); gmsh.finalize()", _APT),
        _library("finite elements", "scikit-fem", "import skfem", "pip install scikit-fem"),
        _pardiso(),
        _rendering(),
        _processors(),
        _memory(),
        _disk(),
    ]


def _python() -> Finding:
    return Finding(
        "Python",
        platform.python_version(),
        sys.version_info >= (3, 11),
        needed=True,
        remedy="install Python 3.11 or later",
    )


def _tried(code: str) -> str | None:
    """None if `code` runs in a new interpreter, else the last line of its error message.

    Temporary files that it may leave after an interrupt are in a directory that is removed with the call.
    """
    try:
        with TemporaryDirectory() as scratch:
            return _complaint(code, os.environ | {"TMPDIR": scratch})
    except OSError as error:
        return str(error)


def _complaint(code: str, environment: Mapping[str, str]) -> str | None:
    try:
        done = subprocess.run(  # noqa: S603 - our own interpreter, our own code
            [sys.executable, "-P", "-c", code],
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
            env=environment,
        )
    except subprocess.TimeoutExpired:
        return "it did not finish within two minutes"
    if done.returncode == 0:
        return None
    lines = done.stderr.strip().splitlines()
    return lines[-1] if lines else f"it ended with status {done.returncode}"


def _library(what: str, package: str, code: str, remedy: str) -> Finding:
    complaint = _tried(code)
    found = complaint or f"{package} {importlib.metadata.version(package)}"
    return Finding(what, found, complaint is None, needed=True, remedy=remedy)


def _pardiso() -> Finding:
    complaint = _tried("from fea.solvers.linear.pardiso import PardisoCholesky; PardisoCholesky(1)")
    if complaint is None:
        found = f"Pardiso (pypardiso {importlib.metadata.version('pypardiso')})"
        return Finding("linear solver", found, good=True, needed=False, remedy="")
    fallback = _tried("import cvxopt.cholmod, pymetis")
    if fallback is None:
        return Finding("linear solver", f"CHOLMOD ({complaint})", good=True, needed=True, remedy="")
    return Finding(
        "linear solver",
        complaint,
        good=False,
        needed=True,
        remedy="pip install pypardiso (on x86-64), or pip install cvxopt pymetis",
    )


def _rendering() -> Finding:
    complaint = _tried("from fea.output.pictures.picture import try_rendering; try_rendering()")
    found = complaint or f"VTK {importlib.metadata.version('vtk')}, off-screen"
    return Finding("pictures", found, complaint is None, needed=False, remedy=_APT)


def _processors() -> Finding:
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return Finding("processors", str(usable), good=True, needed=False, remedy="")


def _memory() -> Finding:
    if not hasattr(os, "sysconf") or "SC_PHYS_PAGES" not in os.sysconf_names:
        return Finding("memory", "unknown", good=True, needed=False, remedy="")
    gib = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2**30
    remedy = "use a machine with at least 2 GiB of memory"
    return Finding("memory", f"{gib:.1f} GiB", gib >= 2, needed=True, remedy=remedy)


def _disk() -> Finding:
    here = Path.cwd()
    writable, free = os.access(here, os.W_OK), shutil.disk_usage(here).free / 2**30
    found = f"{free:.1f} GiB free, {'writable' if writable else 'read-only'}"
    remedy = "choose a writable directory with free space (--out)"
    return Finding("current directory", found, writable and free > 0.1, needed=True, remedy=remedy)
