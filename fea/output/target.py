"""Files that a user names: refused before anything is computed for them, and told in short."""

from collections.abc import Collection
from pathlib import Path

from geometry.invalid import InvalidValue, require


def require_target(option: str, path: Path | None, suffixes: Collection[str]) -> None:
    """Refuse a file that could not be written in the end.

    Parameters
    ----------
    option
        Where it was given (``"--csv"``), for messages.
    path
        The file; None where there is none to write.
    suffixes
        Those it may have, in lower case; what is there and no plain file (a device, a pipe) may have any.

    Raises
    ------
    InvalidValue
        The suffix is another, there is no such directory, or it is one itself.
    """
    if path is None:
        return
    _require_file(option, path, suffixes)
    if not path.parent.is_dir():
        raise InvalidValue(option, str(path), "lies in a directory that does not exist", "Make it first.")


def require_report(path: Path | None) -> None:
    """Refuse a Markdown report that could not be written in the end; the directories above it are made.

    Raises
    ------
    InvalidValue
        It does not end in .md, it is a directory, or something above it is none.
    """
    if path is None:
        return
    _require_file("--report", path, (".md",))
    above = next(parent for parent in path.absolute().parents if parent.exists())
    require(above.is_dir(), "--report", str(path), f"lies below {above}, which is a file")


def _require_file(option: str, path: Path, suffixes: Collection[str]) -> None:
    require(not path.is_dir(), option, str(path), "is a directory", "Name a file.")
    device = path.exists() and not path.is_file()
    rule = f"must end in {' or '.join(suffixes)}"
    require(device or path.suffix.lower() in suffixes, option, str(path), rule)


def near(path: Path) -> Path:
    """Return a path in short: from the current directory, unless that is the root, where it is below it."""
    here = Path.cwd()
    short = path.is_relative_to(here) and here != here.parent
    return path.relative_to(here) if short else path
