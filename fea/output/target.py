"""Files that a user names for results, refused before anything is computed for them."""

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
        Those it may have, in lower case; any where there are none.

    Raises
    ------
    InvalidValue
        The suffix is another, there is no such directory, or it is one itself.
    """
    if path is None:
        return
    rule = f"must end in {' or '.join(suffixes)}"
    require(not suffixes or path.suffix.lower() in suffixes, option, path.name, rule)
    if not path.parent.is_dir():
        raise InvalidValue(option, str(path), "lies in a directory that does not exist", "Make it first.")
    require(not path.is_dir(), option, str(path), "is a directory", "Name a file.")
