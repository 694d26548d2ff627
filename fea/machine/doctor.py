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
from fea.machine.system import memory_of_machine, usable_processors

_GMSH = "import gmsh; gmsh.initialize(); gmsh.finalize()"
_PICTURE = "from fea.output.pictures.picture import try_rendering; try_rendering()"
_PARDISO = "from fea.solvers.direct import Pardiso; Pardiso(1)"


@dataclass(frozen=True)
class Requirement:
    """The result of examining one requirement."""

    what: str
    found: str
    good: bool = True
    needed: bool = True  #: by `fea run`
    remedy: str = ""


def examine() -> list[Requirement]:
    """Try everything that a run may need."""
    python, good = platform.python_version(), sys.version_info >= (3, 11)
    return [
        Requirement("Python", python, good, remedy="install Python 3.11 or later"),
        _library("geometry and meshing", "gmsh", _GMSH, system_remedy("meshing")),
        _library("finite elements", "scikit-fem", "import skfem", "pip install scikit-fem"),
        _solver(),
        _pictures(),
        Requirement("processors", str(usable_processors()), needed=False),
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


def _library(what: str, package: str, code: str, remedy: str) -> Requirement:
    complaint = _tried(code)
    found = complaint or f"{package} {importlib.metadata.version(package)}"
    return Requirement(what, found, complaint is None, remedy=remedy)


def _pictures() -> Requirement:
    complaint = _tried(_PICTURE)
    found = complaint or f"VTK {importlib.metadata.version('vtk')}, off-screen"
    return Requirement("pictures", found, complaint is None, needed=False, remedy=system_remedy("pictures"))


def _solver() -> Requirement:
    complaint = _tried(_PARDISO)
    if complaint is None:
        found = f"Pardiso (pypardiso {importlib.metadata.version('pypardiso')})"
        return Requirement("linear solver", found, needed=False)
    if _tried("import cvxopt.cholmod, pymetis") is None:
        return Requirement("linear solver", f"CHOLMOD ({complaint})")
    return Requirement("linear solver", complaint, good=False, remedy=solver_remedy())


def _memory() -> Requirement:
    gib = memory_of_machine().total / 2**30
    remedy = "use a machine with at least 2 GiB of memory"
    return Requirement("memory", f"{gib:.1f} GiB", gib >= 2, remedy=remedy)


def _disk() -> Requirement:
    here = Path.cwd()
    writable, free = os.access(here, os.W_OK), shutil.disk_usage(here).free / 2**30
    found = f"{free:.1f} GiB free, {'writable' if writable else 'read-only'}"
    remedy = "choose a writable directory with free space (--out)"
    return Requirement("current directory", found, writable and free > 0.1, remedy=remedy)
