"""Files that are whole or not there."""

import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """Give a place beside `path` to write to; what is there takes the place of `path` when the block ends.

    When the block ends with an exception (the disk is full), `path` is as it was before. What is no plain
    file, such as a pipe, is written directly.

    Raises
    ------
    OSError
        With the name of `path`.
    """
    try:
        if path.exists() and not path.is_file():
            yield path
            return
        with _renamed(path.resolve()) as part:  # a link stays a link
            yield part
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


@contextmanager
def _renamed(target: Path) -> Iterator[Path]:
    """Give a new name beside `target`, which becomes `target` when the block ends well."""
    part = target.with_name(f".{secrets.token_hex(4)}.part")
    try:
        yield part
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)
