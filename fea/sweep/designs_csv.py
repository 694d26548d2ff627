"""Designs from a CSV file: a column for each key, a row for each design."""

import csv
import io
from pathlib import Path
from typing import Any

from fea.study.paths import require_size
from fea.study.tables import checked
from fea.sweep.keys import kind_of
from fea.sweep.sampling import MOST, Design
from geometry.invalid import InvalidValue, require

_LARGEST = 2**28  # bytes
_WORDS = {"true": True, "false": False}


def read_designs(path: Path) -> list[Design]:
    """Read designs.

    Raises
    ------
    InvalidValue
        The file cannot be read, a column names no key of a study, or a value is not of its key's type.
    """
    name = path.name
    try:
        require_size("designs", path, _LARGEST)
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidValue("designs", str(path), f"cannot be read ({error})") from error
    table = csv.reader(io.StringIO(text))
    try:
        keys = [key.strip() for key in next(table, [])]
        rows = [(table.line_num, row) for row in table if any(cell.strip() for cell in row)]
    except csv.Error as error:
        raise InvalidValue("designs", name, f"is not a CSV file ({error})") from error
    kinds = {key: kind_of(key, name) for key in keys}
    require(len(kinds) == len(keys) > 0, name, keys, "must name each of its columns once, by a study's keys")
    require(0 < len(rows) <= MOST, name, len(rows), f"must have 1 to {MOST} designs")
    return [_design(f"{name}, line {line}", kinds, row) for line, row in rows]


def _design(where: str, kinds: dict[str, Any], row: list[str]) -> Design:
    rule = f"must have {len(kinds)} values, one for each column"
    require(len(row) == len(kinds), where, row, rule)
    return {
        key: _value(f"{where}, {key}", cell.strip(), kind)
        for (key, kind), cell in zip(kinds.items(), row, strict=True)
    }


def _value(name: str, cell: str, kind: Any) -> Any:
    """Return a cell as the type of its key: a number where it reads as one, else true or false, else text."""
    for read in (int, float):
        try:
            number = read(cell)
        except ValueError:
            continue
        checked(name, number, kind)
        return number
    value = _WORDS.get(cell.lower(), cell)
    checked(name, value, kind)
    return value
