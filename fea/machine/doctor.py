"""Examines the machine: each thing a run needs is tried, in a process of its own where it may crash."""

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
    """One thing examined.

    Attributes
    ----------
    what, found
        In words.
    good
        Whether it works.
    needed
        Whether `fea run` needs it.
    remedy
        What to do when it does not work; not shown when it does.
    """

    what: str
    found: str
    good: bool
    needed: bool
    remedy: str


def examine() -> list[Finding]:
    """Try everything a run may need."""
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
        remedy="Python 3.11 or later",
    )


def _tried(code: str) -> str | None:
    """None when `code` runs in a new interpreter, else the last line of its complaint.

    What an interrupt makes it leave is in a directory that goes with the call.
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
        return "no answer within two minutes"
    if done.returncode == 0:
        return None
    lines = done.stderr.strip().splitlines()
    return lines[-1] if lines else f"ended with status {done.returncode}"


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
        remedy="pip install pypardiso (x86-64), or cvxopt pymetis",
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
    return Finding("memory", f"{gib:.1f} GiB", gib >= 2, needed=True, remedy="a run needs 1 GiB or more")


def _disk() -> Finding:
    here = Path.cwd()
    writable, free = os.access(here, os.W_OK), shutil.disk_usage(here).free / 2**30
    found = f"{free:.1f} GiB free, {'writable' if writable else 'read-only'}"
    return Finding("current directory", found, writable and free > 0.1, needed=True, remedy="--out elsewhere")
