"""What to do where something that a run needs is missing on the system at hand, or hidden by a package."""

import platform
import sys
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

from fea.base.shipped import shipped_toml

_REMEDIES = shipped_toml("machine/remedies.toml")

# Packages that lie beside `fea` in the repository; in a wheel they lie inside it (`.ci/wheel.py`).
_BESIDE = ("geometry", "mesh", "loads")


def system_remedy(of: str) -> str:
    """Return what to do where gmsh does not load (``"meshing"``), or pictures cannot be drawn."""
    return str(_REMEDIES[_system()][of])


def solver_remedy() -> str:
    """Return what to do where there is no direct solver: MKL's exists for x86-64 only."""
    intel = platform.machine() in ("x86_64", "AMD64")
    return "pip install pypardiso" if intel else "pip install cvxopt pymetis"


def _system() -> str:
    """Return the key of this system; a Linux distribution is known by itself or those it is like."""
    if sys.platform != "linux":
        return sys.platform if sys.platform in _REMEDIES else "linux"
    with suppress(OSError):
        release = platform.freedesktop_os_release()
        kinds = [release["ID"], *release.get("ID_LIKE", "").split()]
        return next((kind for kind in ("debian", "fedora") if kind in kinds), "linux")
    return "linux"


def foreign_package(error: BaseException) -> str:
    """Return where a foreign package hides one of ours, and the remedy; else "". `error`: the import's."""
    while isinstance(error, ImportError) and isinstance(error.__cause__, ImportError):
        error = error.__cause__
    name = (getattr(error, "name", None) or "").partition(".")[0]
    spec = find_spec(name) if isinstance(error, ImportError) and name in _BESIDE else None
    if spec is None:
        return ""
    ours = Path(__file__).parents[2]
    places = [Path(place) for place in spec.submodule_search_locations or [spec.origin or ""]]
    if ours / name in places:
        return ""
    return (
        f"the package {name!r} in {places[0]} belongs to another project, and hides {ours / name}. "
        "Install conrod-fea into an environment of its own (pipx, or python -m venv), or remove the other one"
    )
