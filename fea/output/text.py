"""Small text files."""

from pathlib import Path

from fea.output.errors import StorageError


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text with the newlines it has; `StorageError` where the system refuses."""
    try:
        path.write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise StorageError(f"{path} could not be written: {error.strerror}.") from error
