"""Files that users name: paths in studies and flags, limits of size, and TOML."""

import difflib
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fea.base.shipped import TomlTable, shipped_text
from geometry.errors import InvalidValue, require

_LONGEST = 4096  # bytes of a path, on Linux; elsewhere fewer
# A key with 64 dotted parts or more, refused because the parser's time grows with their square.
_NESTED = re.compile(r"(?:\.[^.,\n\[\]{}]*){64}")
_DECIMAL_COMMA = re.compile(r"(?m)^[^#\n=]*=\s*([+-]?\d+,\d+)\s*(?:#.*)?$")
# TOML reads a backslash between double quotes as the start of an escape.
_WINDOWS_PATH = re.compile(r'(?m)^[^#\n=]*=\s*"((?:[A-Za-z]:|\.{0,2})\\[^"\n]*)"')
_LARGEST = 2**18  # bytes; the longest list of speeds takes a tenth


def located(name: str, path: str, folder: Path) -> Path:
    """Return the absolute path, relative to `folder`; `name` is its key. Raises `InvalidValue`: not valid."""
    remedy = "Give another path."
    require("\0" not in path, name, path, "must not contain a NUL character", remedy)
    require_text(name, path)
    short = len(path.encode(errors="replace")) < _LONGEST
    require(short, name, path, f"must be shorter than {_LONGEST} bytes", remedy)
    try:
        place = (folder / path).resolve()
        loop = place.is_symlink()  # from Python 3.13 on, which no longer raises an error there
    except (OSError, RuntimeError, ValueError) as error:
        raise InvalidValue(name, path, f"is not a valid path ({error})", remedy) from error
    require(not loop, name, path, "is not a valid path (its links lead round in a circle)", remedy)
    return place


def absolute(option: str, path: object) -> str:
    """Return the absolute form of the path of a flag; raises the errors of `located`."""
    require(isinstance(path, str | Path), option, path, "must be a path")
    return str(located(option, str(path), Path.cwd()))


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
    """Refuse a file that is not regular or above `largest` bytes (`InvalidValue`), or missing (`OSError`)."""
    size = path.stat().st_size
    require(path.is_file(), name, str(path), "is not a regular file", "Name a file.")
    rule = f"is {size / 2**20:.1f} MiB large; at most {largest / 2**20:g} MiB are read"
    require(size <= largest, name, str(path), rule, "Check that it is the right file.")


def read_toml(what: str, path: Path) -> TomlTable:
    """Return the tables of a file, `what` in messages. Raises `InvalidValue`: unreadable, no valid TOML."""
    try:
        require_size(what, path, _LARGEST)
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidValue(what, str(path), f"cannot be read ({error})") from error
    return parse_toml(what, path.name, text)


def parse_toml(what: str, name: str, text: str) -> TomlTable:
    """Return the tables of the text of a file; errors as `read_toml`."""
    rule, remedy = "nests its keys too deeply", "Use one level of tables, or two as in [material.bushing]."
    require(_NESTED.search(text) is None, what, name, rule, remedy)
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # a number with too many digits gives a plain ValueError
        comma, remedy = _DECIMAL_COMMA.search(text), ""
        if comma is not None:
            pointed = comma[1].replace(",", ".")
            remedy = f"Write {pointed}: TOML has a decimal point, not a comma ({comma[1]})."
        elif (path := _WINDOWS_PATH.search(text)) is not None:
            slashes = path[1].replace("\\", "/")
            remedy = f"Write the path between single quotes, '{path[1]}', or with slashes: \"{slashes}\"."
        raise InvalidValue(what, name, f"is not valid TOML: {error}", remedy) from error


def toml_text(tables: Mapping[str, Any]) -> str:
    """Return tables of plain values as TOML text."""
    import tomli_w  # noqa: PLC0415 - only a study that is written needs it

    return tomli_w.dumps(tables)


def beside(path: Path) -> str:
    """Return the remedy for a file that does not exist: one of a similar name beside it."""
    folder = path.resolve().parent
    if not folder.is_dir():
        return f"There is no folder {folder}."
    names = [each.name for each in folder.iterdir() if each.suffix.lower() == path.suffix.lower()]
    near = difflib.get_close_matches(path.name, names, n=1)
    return f"Did you mean {near[0]}?" if near else f"Check its name; relative paths start in {Path.cwd()}."


def ready_study(name: str, rod: Mapping[str, Any]) -> tuple[str, str]:
    """Return the remedy for a rod of a file without an engine, and a study to complete."""
    remedy = (
        f"Name an engine with --engine, or save the lines below as {name}.toml, replace the figures by those "
        f"of your engine and material, and run fea run {name}.toml."
    )
    return remedy, f"{toml_text({'rod': dict(rod)})}\n{shipped_text('study/engine_to_edit.toml')}"
