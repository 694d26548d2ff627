"""Examine the machine: try everything that a run needs, in a separate process if it may crash."""

import importlib.metadata
import os
import platform
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from fea.machine.isolated import CrashError, OvertimeError, fresh
from fea.machine.remedies import solver_remedy, system_remedy
from fea.machine.system import physical_memory, usable_processors

_GMSH = "import gmsh; gmsh.initialize(); gmsh.finalize()"


@dataclass(frozen=True)
class Finding:
    """The result of examining one requirement; `needed` says whether `fea run` needs it."""

    what: str
    found: str
    good: bool
    needed: bool
    remedy: str


def examine() -> list[Finding]:
    """Try everything that a run may need."""
    python = "install Python 3.11 or later"
    complaint = _tried("from fea.output.pictures.picture import try_rendering; try_rendering()")
    found = complaint or f"VTK {importlib.metadata.version('vtk')}, off-screen"
    return [
        Finding("Python", platform.python_version(), sys.version_info >= (3, 11), needed=True, remedy=python),
        _library("geometry and meshing", "gmsh", _GMSH, system_remedy("meshing")),
        _library("finite elements", "scikit-fem", "import skfem", "pip install scikit-fem"),
        _pardiso(),
        Finding("pictures", found, complaint is None, needed=False, remedy=system_remedy("pictures")),
        Finding("processors", str(usable_processors()), good=True, needed=False, remedy=""),
        _memory(),
        _disk(),
    ]


def _tried(code: str) -> str | None:
    """None if `code` runs in a new interpreter and temporary folder, else the last line of its error."""
    try:
        # Windows removes no folder in which a process that has just ended holds a file.
        folder = TemporaryDirectory(ignore_cleanup_errors=True)
        with folder as scratch, fresh({"TMPDIR": scratch}, messages=True) as process:
            process.run(exec, code, seconds=120)
    except CrashError as error:
        return process.last_message or str(error)
    except OvertimeError:
        return "it did not finish within two minutes"
    except Exception as error:  # noqa: BLE001 - whatever a library raises
        return f"{type(error).__name__}: {error}"
    return None


def _library(what: str, package: str, code: str, remedy: str) -> Finding:
    complaint = _tried(code)
    found = complaint or f"{package} {importlib.metadata.version(package)}"
    return Finding(what, found, complaint is None, needed=True, remedy=remedy)


def _pardiso() -> Finding:
    complaint = _tried("from fea.solvers.linear.pardiso import Pardiso; Pardiso(1)")
    if complaint is None:
        found = f"Pardiso (pypardiso {importlib.metadata.version('pypardiso')})"
        return Finding("linear solver", found, good=True, needed=False, remedy="")
    fallback = _tried("import cvxopt.cholmod, pymetis")
    if fallback is None:
        return Finding("linear solver", f"CHOLMOD ({complaint})", good=True, needed=True, remedy="")
    return Finding("linear solver", complaint, good=False, needed=True, remedy=solver_remedy())


def _memory() -> Finding:
    memory = physical_memory()
    if memory is None:
        return Finding("memory", "unknown", good=True, needed=False, remedy="")
    gib = memory / 2**30
    remedy = "use a machine with at least 2 GiB of memory"
    return Finding("memory", f"{gib:.1f} GiB", gib >= 2, needed=True, remedy=remedy)


def _disk() -> Finding:
    here = Path.cwd()
    writable, free = os.access(here, os.W_OK), shutil.disk_usage(here).free / 2**30
    found = f"{free:.1f} GiB free, {'writable' if writable else 'read-only'}"
    remedy = "choose a writable directory with free space (--out)"
    return Finding("current directory", found, writable and free > 0.1, needed=True, remedy=remedy)
