"""The libraries that sweeps need beyond those of a run."""

import hashlib
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from fea.study.paths import is_file

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


def digest(path: Path) -> str:
    """Return a digest of a file's contents; empty where there is no such file."""
    if not is_file(path):
        return ""
    changed = path.stat()
    return _digest(path, changed.st_mtime_ns, changed.st_size)


@cache
def _digest(path: Path, _changed: int, _size: int) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
