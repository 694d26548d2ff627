"""The library of real engines: names, aliases, and figures that are read with their source or assumed.

An engine of the library is a file of `fea/studies/engines`, named after it: ``title``, ``layout``, and in
``aliases`` what else the engine is called. ``[engine]`` and ``[rod]`` hold figures by the keys of a study,
``[speed]`` the redline. A figure has a ``source``, one of ``[sources]``, or says in ``assumed`` where the
estimate comes from. Stroke, bore and length of the rod always have a source.
"""

import difflib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

from fea.base.shipped import TomlTable, shipped_names, shipped_toml
from geometry.errors import InvalidValue

_FOLDER = "studies/engines"
# As names are compared: without regard to case, blanks and hyphens.
_IGNORED = str.maketrans("", "", " -_")


class Figure(NamedTuple):
    """A figure of an engine."""

    value: float | int | str  #: in the unit of its key
    origin: str  #: its source, a key of `EnginePreset.sources`; or how it was estimated
    assumed: bool  #: whether it is an estimate


@dataclass(frozen=True)
class EnginePreset:
    """An engine of the library."""

    #: name, title: its name in a study, and what it is
    name: str
    title: str
    aliases: tuple[str, ...]  #: what else it is called
    layout: str  #: ``in-line``, ``V`` or ``flat``
    sources: Mapping[str, str]  #: what is cited, by the names that the figures give
    #: engine, rod: figures by the keys of [engine] and of [rod]
    engine: Mapping[str, Figure]
    rod: Mapping[str, Figure]
    redline: Figure  #: the highest speed that the engine is meant for, rpm

    def entries(self) -> TomlTable:
        """Return the keys of [engine] with their values."""
        return {key: figure.value for key, figure in self.engine.items()}

    @property
    def redline_rpm(self) -> float:
        """The redline as a number."""
        return float(self.redline.value)

    @property
    def rod_length(self) -> float:
        """Distance of the bores' centres of its own rod, mm."""
        return float(self.rod["length_mm"].value)


@cache
def engine_names() -> tuple[str, ...]:
    """Return the names of all engines."""
    return shipped_names(_FOLDER)


def engine_aliases() -> dict[str, str]:
    """Return the names of engines by their aliases."""
    return {alias: name for name in engine_names() for alias in _read(name).aliases}


def engine_preset(name: str, where: str = "engine.preset") -> EnginePreset:
    """Return an engine by its name or an alias, in any case, with or without blanks and hyphens.

    `where` names the key. Raises `InvalidValue`: unknown name.
    """
    found = _by_plain_name()
    if _plain(name) in found:
        return _read(found[_plain(name)])
    names = ", ".join(engine_names())
    near = dict.fromkeys(found[each] for each in difflib.get_close_matches(_plain(name), found))
    guess = f"Did you mean {' or '.join(near)}? " if near else ""
    remedy = f"{guess}Valid names: {names}. Figures of any other engine go into [engine] of a study."
    raise InvalidValue(where, name, "is not an engine of the library", remedy)


def _plain(name: str) -> str:
    return name.casefold().translate(_IGNORED)


@cache
def _by_plain_name() -> dict[str, str]:
    names = {name: name for name in engine_names()}
    return {_plain(known): name for known, name in (engine_aliases() | names).items()}


@cache
def _read(name: str) -> EnginePreset:
    raw = shipped_toml(f"{_FOLDER}/{name}.toml")
    engine, rod, speed = (
        {
            key: Figure(entry["value"], entry.get("assumed") or entry["source"], "assumed" in entry)
            for key, entry in raw[table].items()
        }
        for table in ("engine", "rod", "speed")
    )
    title, aliases, layout = raw["title"], tuple(raw.get("aliases", ())), raw["layout"]
    return EnginePreset(name, title, aliases, layout, raw["sources"], engine, rod, speed["redline_rpm"])
