"""Write small text files, and create directories for them."""

from pathlib import Path

from fea.output.errors import StorageError
from geometry.system.files import replaced


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text with unchanged newlines, completely or not at all; raises `StorageError`."""
    try:
        with replaced(path) as place:
            place.write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        message = f"{path} could not be written: {error.strerror}. Choose another path, or free disk space."
        raise StorageError(message) from error


def make_directory(path: Path) -> None:
    """Create a directory and its missing parents; raises `StorageError` if the system refuses."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        message = f"{path} could not be created: {error.strerror}. Choose another path."
        raise StorageError(message) from error
