"""Files that are written completely or not at all."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from geometry.system import incomplete


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
    import secrets  # noqa: PLC0415 - it takes OpenSSL with it

    try:
        if path.exists() and not path.is_file():
            yield path
            return
        target = path.resolve()  # a link stays a link
        part = target.with_name(f".{secrets.token_hex(4)}.part")
        with incomplete(part):
            try:
                yield part
                part.replace(target)
            finally:
                part.unlink(missing_ok=True)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error
