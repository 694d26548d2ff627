"""Paths given in studies and flags, and size limits of input files."""

import math
import re
from pathlib import Path

from fea.study.quantities import quantity
from geometry.errors import InvalidValue, require, require_number

_LONGEST = 4096  # bytes of a path, on Linux; elsewhere fewer


def located(name: str, path: str, folder: Path) -> Path:
    """Return the absolute path, relative to `folder`; `name` is its key. Raises `InvalidValue`: not valid."""
    remedy = "Give another path."
    require("\0" not in path, name, path, "must not contain a NUL character", remedy)
    require_text(name, path)
    short = len(path.encode(errors="replace")) < _LONGEST
    require(short, name, path, f"must be shorter than {_LONGEST} bytes", remedy)
    try:
        return (folder / path).resolve()
    except (OSError, RuntimeError, ValueError) as error:
        raise InvalidValue(name, path, f"is not a valid path ({error})", remedy) from error


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


_FORMS = 'Write 6000, 800,3000,6000 or 800:9000:200 (both ends included), in rpm or with a unit: "100 Hz".'
_MOST = 2000
_THOUSANDS = re.compile(r"[12]?\d,\d{3}(?!\d)")  # below 30 rpm, the first is no speed of an engine
_UNIT = re.compile(r"(?<=[\d.])\s*(?:[^\W\d_]|1?\s*/)[^,:]*$")  # after the last number


def parse_speeds(given: object) -> tuple[float, ...]:
    """Read ``6000``, ``800,3000,6000``, ``800:9000:200`` or numbers, as speeds, rpm; else `InvalidValue`.

    A unit at the end, as in ``"80,100 Hz"``, is that of all.
    """
    if not isinstance(given, str):
        entries = given if isinstance(given, list | tuple) else [given]
        return tuple(_number(one) if isinstance(one, str) else require_number("rpm", one) for one in entries)
    rule, remedy = "may be one speed with a comma in its number, or several", "Write 6000 without a comma."
    require(_THOUSANDS.match(given.strip()) is None, "--rpm", given, rule, remedy)
    *others, last = given.split(",")
    unit = _unit(last)
    parts = [part if _unit(part) else f"{part}{unit}" for part in others] + [last]
    speeds = [speed for part in parts for speed in (_range(part) if ":" in part else [_number(part)])]
    return tuple(dict.fromkeys(speeds))


def _unit(text: str) -> str:
    """Return the unit at the end of a speed or a range, "" if it has none."""
    try:
        float(text.rpartition(":")[2])
    except ValueError:
        found = _UNIT.search(text)
        return f" {found[0].strip()}" if found else ""
    return ""


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError as error:
        if _unit(text):
            return quantity("--rpm", text, "rpm")
        raise InvalidValue("--rpm", text, "is not a speed", _FORMS) from error
    if not math.isfinite(value):
        raise InvalidValue("--rpm", text, "must be finite", _FORMS)
    return value


def _range(text: str) -> list[float]:
    parts = text.split(":")
    if len(parts) != 3:
        raise InvalidValue("--rpm", text, "a range must have a start, an end and a step", _FORMS)
    unit = _unit(text)
    start, end, step = (_number(part if _unit(part) else f"{part}{unit}") for part in parts)
    if step <= 0 or end < start:
        rule = "the end of a range must not be below its start, and its step must be positive"
        raise InvalidValue("--rpm", text, rule, _FORMS)
    steps = (end - start) / step * (1 + 1e-12) + 1e-9
    if not steps < _MOST:
        rule = f"gives {steps + 1:.0f} speeds; at most {_MOST} are allowed"
        raise InvalidValue("--rpm", text, rule, "Use a larger step.")
    count = math.floor(steps) + 1
    speeds = [type(start)(start + index * step) for index in range(count)]
    if not math.isclose(speeds[-1], end):
        speeds.append(end)
    return speeds
