"""The libraries that sweeps need beyond those of a run."""

from importlib.util import find_spec

_NEEDED = ("dask", "distributed", "pyarrow", "SALib")


def require_extra() -> None:
    """Refuse to begin without them.

    Raises
    ------
    ImportError
        One is missing (exit code 7).
    """
    missing = [name for name in _NEEDED if find_spec(name) is None]
    if missing:
        raise ImportError(
            f"fea sweep needs {', '.join(missing)}, not installed here: pip install 'conrod-fea[sweep]'"
        )
