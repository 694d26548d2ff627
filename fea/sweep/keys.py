"""The keys of a study that a sweep may set, with the types of their values."""

import typing
from collections.abc import Iterator, Mapping
from typing import Any

from fea.study.rod_table import rod_keys
from fea.study.study import TABLES
from fea.study.tables import unknown_key
from geometry.invalid import InvalidValue

# The files of a run are not written by a sweep, and a sweep searches by itself.
_TABLES = ("rod", *(name for name in TABLES if name not in ("optimise", "output")))


def leaves(where: str, raw: object) -> Iterator[tuple[str, Any]]:
    """Return what a table of tables says of each key: ``("rod.web_thickness_mm", value)``.

    Keys may be nested (``[vary.rod]``), dotted or quoted (``"rod.web_thickness_mm"``).

    Parameters
    ----------
    where
        Its name in the sweep file, for messages.
    raw
        From the TOML parser.

    Raises
    ------
    InvalidValue
        It is not a table, or names a table or a key that a study does not have.
    """
    if not isinstance(raw, Mapping):
        raise InvalidValue(where, raw, f"must be a table, [{where}]")
    for path, value in _flat(raw, ()):
        kind_of(".".join(path), where)
        yield ".".join(path), value


def kind_of(key: str, where: str) -> Any:
    """Return the annotated type of a key of a study.

    Raises
    ------
    InvalidValue
        There is no such key.
    """
    table, _, name = key.rpartition(".")
    first, _, part = table.partition(".")
    if not table or first not in _TABLES or (part and first != "material"):
        raise unknown_key(f"[{where}]", table or key, _TABLES)
    hints = rod_keys() if table == "rod" else typing.get_type_hints(TABLES[first])
    if name not in hints:
        raise unknown_key(f"[{where}.{table}]", name, hints)
    return hints[name]


def _flat(raw: Mapping[str, Any], above: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any]]:
    for key, value in raw.items():
        path = (*above, *key.split("."))
        if isinstance(value, Mapping) and _is_table(path):
            yield from _flat(value, path)
        else:
            yield path, value


def _is_table(path: tuple[str, ...]) -> bool:
    """Whether a path names a table, or a part's own material, rather than a key."""
    if len(path) == 1:
        return True
    return (
        len(path) == 2 and path[0] == "material" and path[1] not in typing.get_type_hints(TABLES["material"])
    )
