"""TOML that users write: studies and sweeps."""

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fea.study.paths import require_size
from geometry.errors import InvalidValue, require

# Values by key, as a file holds them.
TomlTable = dict[str, Any]

# A key with 64 dotted parts or more, refused because the parser's time grows with their square.
_NESTED = re.compile(r"(?:\.[^.,\n\[\]{}]*){64}")
_DECIMAL_COMMA = re.compile(r"(?m)^[^#\n=]*=\s*([+-]?\d+,\d+)\s*(?:#.*)?$")
# TOML reads a backslash between double quotes as the start of an escape.
_WINDOWS_PATH = re.compile(r'(?m)^[^#\n=]*=\s*"((?:[A-Za-z]:|\.{0,2})\\[^"\n]*)"')
_LARGEST = 2**18  # bytes; the longest list of speeds takes a tenth


def read_toml(what: str, path: Path) -> Mapping[str, Any]:
    """Return the tables of a file, `what` in messages. Raises `InvalidValue`: unreadable, no valid TOML."""
    try:
        require_size(what, path, _LARGEST)
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidValue(what, str(path), f"cannot be read ({error})") from error
    return parse_toml(what, path.name, text)


def parse_toml(what: str, name: str, text: str) -> Mapping[str, Any]:
    """Return the tables of the text of a file; errors as `read_toml`."""
    rule, remedy = "nests its keys too deeply", "Use one level of tables, or two as in [material.bushing]."
    require(_NESTED.search(text) is None, what, name, rule, remedy)
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # a number with too many digits gives a plain ValueError
        comma, remedy = _DECIMAL_COMMA.search(text), ""
        if comma is not None:
            remedy = (
                f"Write {comma[1].replace(',', '.')}: TOML has a decimal point, not a comma ({comma[1]})."
            )
        elif (path := _WINDOWS_PATH.search(text)) is not None:
            slashes = path[1].replace("\\", "/")
            remedy = f"Write the path between single quotes, '{path[1]}', or with slashes: \"{slashes}\"."
        raise InvalidValue(what, name, f"is not valid TOML: {error}", remedy) from error
