"""Data files of the package, by paths that begin at it."""

import tomllib
from importlib.resources import files
from typing import Any

# Values by key, as a TOML file holds them.
TomlTable = dict[str, Any]


def shipped_text(path: str) -> str:
    """Return the text of a file."""
    return (files("fea") / path).read_text(encoding="utf-8")


def shipped_toml(path: str) -> TomlTable:
    """Return the tables of a file."""
    return tomllib.loads(shipped_text(path))


def shipped_names(folder: str) -> tuple[str, ...]:
    """Return the names of the TOML files in a folder, without their ending."""
    names = (entry.name for entry in (files("fea") / folder).iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml")))
