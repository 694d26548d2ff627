"""What a file holds, as a digest: a study that names it is another one when it has changed."""

import hashlib
from functools import cache
from pathlib import Path

from fea.study.paths import is_file


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
