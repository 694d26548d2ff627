"""Write small text files, and create directories for them."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from fea.output.target import StorageError
from geometry.files import replaced


@contextmanager
def stored(path: Path) -> Iterator[Path]:
    """Yield a place to write a file, as `replaced` does; raises `StorageError`, which says what to do."""
    try:
        with replaced(path) as place:
            yield place
    except OSError as error:
        message = f"{path} could not be written: {error.strerror}. Choose another path, or free disk space."
        raise StorageError(message) from error


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text with unchanged newlines, completely or not at all; raises `StorageError`."""
    with stored(path) as place:
        place.write_text(text, encoding="utf-8", newline="\n")


def make_directory(path: Path) -> None:
    """Create a directory and its missing parents; raises `StorageError` if the system refuses."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        message = f"{path} could not be created: {error.strerror}. Choose another path."
        raise StorageError(message) from error


_AT_SPEED = " at\0rpm"  # stands for the speed in a note
_WHOLE = 9.95  # percent: error bars from here on have no decimals


def error_bar(percent: float) -> str:
    """Return an error bar as text with two digits."""
    return f"{percent:.{0 if percent >= _WHOLE else 1}f}"


def gathered(notes: Iterable[tuple[float, Sequence[str]]]) -> list[str]:
    """Return the notes of several speeds, rpm; those that differ only in the speed are merged."""
    speeds: dict[str, list[str]] = {}
    for rpm, said in notes:
        for note in said:
            speeds.setdefault(note.replace(f" at {rpm:g} rpm", _AT_SPEED), []).append(f"{rpm:g}")
    return [note.replace(_AT_SPEED, f" at {', '.join(rpm)} rpm") for note, rpm in speeds.items()]
