"""Output files named by the user: checked before anything is computed, and shown as short paths."""

import sys
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from geometry.errors import public, require


def require_target(
    option: str, path: Path | None, suffixes: Collection[str], *, parents: bool = False
) -> None:
    """Refuse a file, given by an option, that cannot be written; None stands for none.

    Suffixes are in lower case; an existing device or pipe may have any. With `parents`, missing directories
    above it will be created. Raises `InvalidValue`: the suffix is not allowed, the path is a directory, or
    there is none that it can be written into.
    """
    if path is None:
        return
    require(not path.is_dir(), option, str(path), "is a directory", "Name a file.")
    device = path.exists() and not path.is_file()
    rule = f"must end in {' or '.join(suffixes)}"
    require(device or path.suffix.lower() in suffixes, option, str(path), rule)
    if parents:
        above = next(parent for parent in path.absolute().parents if parent.exists())
        rule, remedy = f"is inside {above}, which is not a directory", "Choose another path."
    else:
        above, remedy = path.parent, "Create the directory first."
        rule = "is in a directory that does not exist"
    require(above.is_dir(), option, str(path), rule, remedy)


def near(path: Path) -> Path:
    """Return a path relative to the current directory if it is below it and that is not the root."""
    here = Path.cwd()
    short = path.is_relative_to(here) and here != here.parent
    return path.relative_to(here) if short else path


def picture_name(result: str) -> str:
    """Return the name of the picture of a result file, which stands beside it."""
    return Path(result).with_suffix(".png").name


class OutputError(Exception):
    """A result could not be written or shown."""


@public
class OccupiedError(OutputError):
    """The output directory contains something other than an earlier run (exit code 2)."""


@public
class StorageError(OutputError):
    """A full disk, a permission or the file system prevents writing (exit code 7)."""


@public
class PictureError(OutputError):
    """No usable picture could be drawn; the result files are not affected (exit code 7)."""


_LONG = 260 - 40  # characters of a folder, without the random part of its name and the names of its files


@contextmanager
def reported(
    path: Path, remedy: str, *, verb: str = "written", kind: type[OutputError] = StorageError
) -> Iterator[None]:
    """Turn an error of the system, met while a path is written, into one of a kind that says what to do."""
    try:
        yield
    except OSError as error:
        if sys.platform == "win32" and len(str(path.absolute())) > _LONG:
            remedy = f"Paths of more than 260 characters need Windows' long paths enabled. {remedy}"
        raise kind(f"{path} could not be {verb}: {error.strerror or error}. {remedy}") from error
