"""Files that are written completely or not at all."""

import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`; the file written there replaces `path` when the block ends.

    If the block ends with an exception (such as a full disk), `path` stays as it was. Anything that is not a
    regular file, such as a pipe, is written directly.

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
    """Yield a new name beside `target`, which is renamed to `target` if the block succeeds."""
    part = target.with_name(f".{secrets.token_hex(4)}.part")
    try:
        yield part
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)
