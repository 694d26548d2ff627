"""The study that a sweep starts from, and the designs made of it."""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from fea.base.shipped import TomlTable, shipped_toml
from fea.study.files import is_file, read_toml
from fea.study.speed_tables import SpeedTable
from fea.study.study import (
    TABLES,
    Study,
    load_study,
    shipped_studies,
    study_of_tables,
    with_own_units,
)
from fea.study.tables import full_key, hints_of, keys_of, number_of, unknown_key
from geometry.errors import InvalidValue, require


class Extras(NamedTuple):
    """What a sweep asks for beside the figures of a run."""

    frequencies: int = 0  #: number of natural frequencies to find
    limits: bool = False  #: whether the largest speed and peak pressure are found, as by `fea limits`


@dataclass(frozen=True)
class Base:
    """The tables of a sweep's study common to all designs, and their files; paths start at `folder`."""

    name: str
    raw: Mapping[str, Any]
    folder: Path
    files: tuple[Path, ...] = ()

    def study(self, design: Mapping[str, Any], speeds: Sequence[float | None] = ()) -> Study:
        """Return the study with a design's values, at some speeds, rpm. `InvalidValue`: a broken rule."""
        study = study_of_tables(changed(self.raw, design), self.name, self.folder)
        study.require_plausible()
        rpm = tuple(speed for speed in speeds if speed is not None)
        return study if not rpm else replace(study, speed=SpeedTable(rpm[0] if len(rpm) == 1 else rpm))

    def require_presets_alone(self, keys: Mapping[str, Any]) -> None:
        """Refuse to change a preset beside keys that override each of them. Raises `InvalidValue`."""
        for key in keys:
            table, _, name = key.rpartition(".")
            if name != "preset":
                continue
            own = _table(self.raw, table)
            beside = sorted(own.keys() - {"preset"}) if isinstance(own, Mapping) else []
            beside = [other for other in beside if not isinstance(own[other], Mapping)]
            rule = f"cannot be changed: [{table}] of the study gives {', '.join(beside)}, which override it"
            require(not beside, key, None, rule, "Remove those keys from the study.")


def read_base(source: str, folder: Path, fixed: Mapping[str, Any]) -> Base:
    """Read the study of a sweep: a shipped one, or a file (TOML, CAD or mesh) relative to the sweep's folder.

    `fixed` is what all designs have in common, by key. Raises `InvalidValue`: it is not a study, or what is
    fixed breaks a rule.
    """
    shipped = source in shipped_studies()
    place = source if shipped else str(folder / source)
    study = load_study(place)
    if shipped:
        raw: Mapping[str, Any] = shipped_toml(f"studies/{source}.toml")
    elif Path(place).suffix.lower() == ".toml":
        raw = read_toml("study", Path(place))
    else:
        raw = {"rod": study.rod.as_dict()}
    tables = with_own_units(raw)
    tables.pop("output", None)
    base = Base(study.name, tables, study.folder)
    base.require_presets_alone(fixed)
    base = replace(base, raw=changed(tables, fixed))
    return replace(base, files=tuple(files_of(base.study({}).as_dict())))


def changed(raw: Mapping[str, Any], design: Mapping[str, Any]) -> TomlTable:
    """Return a study's tables with other values for some keys."""
    tables = deepcopy(dict(raw))
    for key, value in design.items():
        *above, name = key.split(".")
        table = tables
        for step in above:
            if isinstance(table.get(step), str):  # an engine by its name
                table[step] = {"preset": table[step]}
            table = table.setdefault(step, {})
        table[name] = value
    return tables


def files_of(tables: Mapping[str, Any]) -> list[Path]:
    """Return the files that the tables of a resolved study name: its paths are absolute."""
    paths = []
    for value in tables.values():
        if isinstance(value, Mapping):
            paths += files_of(value)
        elif isinstance(value, str) and Path(value).is_absolute():
            paths.append(Path(value))
    return paths


def _table(raw: Mapping[str, Any], name: str) -> Any:
    table: Any = raw
    for step in name.split("."):
        table = table.get(step, {}) if isinstance(table, Mapping) else {}
    return table


# The files of a run are not written by a sweep, and a sweep searches by itself.
_TABLES = tuple(name for name in TABLES if name not in ("optimise", "output"))


def leaves(where: str, raw: object) -> Iterator[tuple[str, Any]]:
    """Return what a table of tables says of each key: ``("rod.web_thickness_mm", value)``, in its unit.

    Keys may be nested (``[vary.rod]``), dotted or quoted (``"rod.web_thickness_mm"``); `where` is the name of
    the table, for messages. Raises `InvalidValue`: it is not a table, or names a table or a key that a study
    does not have.
    """
    if not isinstance(raw, Mapping):
        raise InvalidValue(where, raw, f"must be a table, [{where}]")
    for path, value in _flat(raw, ()):
        *above, given = path
        table = TABLES.get(above[0]) if above else None
        name = given if table is None else full_key(given, keys_of(table))
        key, said, bare = ".".join((*above, name)), ".".join((where, *path)), name != given
        kind_of(key, where)
        if not isinstance(value, Mapping):
            yield key, number_of(said, value, name, bare=bare)
            continue
        span = {
            bound: number_of(f"{said}.{bound}", value[bound], name, bare=bare, change=bound == "deviation")
            for bound in value
            if bound in _QUANTITIES
        }
        yield key, {**value, **span}


# What of a range or a distribution is in the unit of its key.
_QUANTITIES = ("from", "to", "mean", "deviation", "mode")


def kind_of(key: str, where: str) -> Any:
    """Return the annotated type of a key of a study; raises `InvalidValue`: there is no such key."""
    table, _, name = key.rpartition(".")
    first, _, part = table.partition(".")
    if not table or first not in _TABLES or (part and first != "material"):
        raise unknown_key(f"[{where}]", table or key, _TABLES)
    hints = hints_of(TABLES[first])
    if name not in hints:
        raise unknown_key(f"[{where}.{table}]", name, hints)
    return hints[name]


def _flat(raw: Mapping[str, Any], above: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any]]:
    materials = keys_of(TABLES["material"])
    for key, value in raw.items():
        path = (*above, *key.split("."))
        part = len(path) == 2 and path[0] == "material" and full_key(path[1], materials) not in materials
        if isinstance(value, Mapping) and (len(path) == 1 or part):
            yield from _flat(value, path)
        else:
            yield path, value


_NEEDED = ("dask", "distributed", "pyarrow", "SALib")


def require_extra() -> None:
    """Refuse to begin without them; raises `ImportError`: one is missing (exit code 7)."""
    missing = [name for name in _NEEDED if find_spec(name) is None]
    if missing:
        packages = " ".join({"dask": "distributed"}.get(name, name) for name in missing)
        raise ImportError(f"fea sweep needs {', '.join(missing)}, not installed here: pip install {packages}")


def digest(path: Path) -> str:
    """Return a digest of a file's contents; empty where there is no such file."""
    if not is_file(path):
        return ""
    changed = path.stat()
    return _digest(path, changed.st_mtime_ns, changed.st_size)


@cache
def _digest(path: Path, _changed: int, _size: int) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
