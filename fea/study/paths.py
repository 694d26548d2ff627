"""Paths that users write into studies, and files read whole."""

from pathlib import Path

from geometry.invalid import InvalidValue, require

_LONGEST = 4096  # bytes of a path, on Linux; elsewhere fewer


def located(name: str, path: str, folder: Path) -> Path:
    """Return a path as a study gives it, absolute; a relative one starts at `folder`.

    Parameters
    ----------
    name
        The key it stands at, for messages.

    Raises
    ------
    InvalidValue
        No system can have such a path.
    """
    require("\0" not in path, name, path, "holds a NUL character, which no path may")
    require_text(name, path)
    require(len(path.encode(errors="replace")) < _LONGEST, name, path, f"is longer than {_LONGEST} bytes")
    try:
        return (folder / path).resolve()
    except (OSError, RuntimeError, ValueError) as error:
        raise InvalidValue(name, path, f"is no path here ({error})") from error


def absolute(option: str, path: Path | None) -> str | None:
    """Return a path as a flag gives it, absolute; None where it gives none; refused as `located` does."""
    return None if path is None else str(located(option, str(path), Path.cwd()))


def require_text(name: str, path: str) -> None:
    """Refuse a path whose bytes are no UTF-8: neither TOML nor JSON could name it."""
    letters = path.encode(errors="replace").decode()
    require(letters == path, name, path, "is not UTF-8, which the files of a run are", "Choose another name.")


def is_file(path: Path) -> bool:
    """Whether there is a file; a path that the system refuses has none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def require_size(name: str, path: Path, largest: int) -> None:
    """Refuse a file that is no plain file or larger than `largest` bytes, before it is read whole.

    Raises
    ------
    InvalidValue
        It is too large, or a device or a pipe, whose end may never come.
    OSError
        There is none.
    """
    size = path.stat().st_size
    require(path.is_file(), name, str(path), "is not a file")
    rule = f"holds {size / 2**20:.1f} MiB, more than the {largest / 2**20:g} MiB that are read"
    require(size <= largest, name, str(path), rule, "Is it the right file?")
