"""Paths given in studies and flags, and size limits of input files."""

from pathlib import Path

from geometry.invalid import InvalidValue, require

_LONGEST = 4096  # bytes of a path, on Linux; elsewhere fewer


def located(name: str, path: str, folder: Path) -> Path:
    """Return the absolute form of a path from a study; a relative path starts at `folder`.

    Parameters
    ----------
    name
        Its key, for messages.

    Raises
    ------
    InvalidValue
        The path is not valid.
    """
    remedy = "Give another path."
    require("\0" not in path, name, path, "must not contain a NUL character", remedy)
    require_text(name, path)
    short = len(path.encode(errors="replace")) < _LONGEST
    require(short, name, path, f"must be shorter than {_LONGEST} bytes", remedy)
    try:
        return (folder / path).resolve()
    except (OSError, RuntimeError, ValueError) as error:
        raise InvalidValue(name, path, f"is not a valid path ({error})", remedy) from error


def absolute(option: str, path: Path | None) -> str | None:
    """Return the absolute form of a flag's path, None if it is not given; raises the errors of `located`."""
    return None if path is None else str(located(option, str(path), Path.cwd()))


def require_text(name: str, path: str) -> None:
    """Refuse a path that is not valid UTF-8: neither TOML nor JSON could store it."""
    letters = path.encode(errors="replace").decode()
    rule = "must be valid UTF-8, because the files of a run are in UTF-8"
    require(letters == path, name, path, rule, "Choose another name.")


def is_file(path: Path) -> bool:
    """Whether there is a file; False for a path that the system rejects."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def require_size(name: str, path: Path, largest: int) -> None:
    """Refuse a path that is not a regular file, or a file larger than `largest` bytes, before reading it.

    Raises
    ------
    InvalidValue
        It is too large, or a device or a pipe, which may never end.
    OSError
        It does not exist.
    """
    size = path.stat().st_size
    require(path.is_file(), name, str(path), "is not a regular file", "Name a file.")
    rule = f"is {size / 2**20:.1f} MiB large; at most {largest / 2**20:g} MiB are read"
    require(size <= largest, name, str(path), rule, "Check that it is the right file.")
