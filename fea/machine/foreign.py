"""Packages of other projects that stand in the way of ours: looked for only where an import has failed."""

from importlib.util import find_spec
from pathlib import Path

# Packages that lie beside `fea` in the repository; in a wheel they lie inside it (`.ci/wheel.py`).
_BESIDE = ("geometry", "mesh", "loads")


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
