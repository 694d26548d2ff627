"""Data that come with the packages."""

import tomllib
from pathlib import Path
from typing import Any


def tables_beside(module: str, name: str) -> dict[str, Any]:
    """Return the tables of a TOML file beside a module, whose ``__file__`` is given."""
    return tomllib.loads(Path(module).with_name(name).read_text(encoding="utf-8"))
