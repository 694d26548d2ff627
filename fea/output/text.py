"""Small text files and the directories they are in."""

from pathlib import Path

from fea.output.errors import StorageError
from geometry.system.files import replaced


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text with the newlines it has, wholly or not at all; `StorageError` where refused."""
    try:
        with replaced(path) as place:
            place.write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise StorageError(f"{path} could not be written: {error.strerror}.") from error


def make_directory(path: Path) -> None:
    """Make a directory and its parents where they are missing; `StorageError` where the system refuses."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StorageError(f"{path} could not be made: {error.strerror}.") from error
