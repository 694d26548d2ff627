"""The real engines that come with the program, each figure with its source.

An engine is a file of `fea/studies/engines`: ``[engine]`` and
``[rod]`` hold figures by the keys of a study, ``[speed]`` the redline. A figure has a ``source``, one of
``[sources]``, or says in ``assumed`` where the estimate comes from.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

from fea.base.shipped import shipped_names, shipped_toml
from fea.study.tables import checked, nearest
from fea.study.toml_files import TomlTable
from geometry.errors import InvalidValue

_FOLDER = "studies/engines"


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


def engine_preset(name: str, where: str = "engine.preset") -> EnginePreset:
    """Return an engine by its name; `where` names the key. Raises `InvalidValue`: unknown name."""
    if name not in engine_names():
        remedy = nearest(name, engine_names())
        raise InvalidValue(where, name, "is not an engine of the library", remedy)
    return _read(name)


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
    title, layout, sources = raw["title"], raw["layout"], raw["sources"]
    return EnginePreset(name, title, layout, sources, engine, rod, redline=speed["redline_rpm"])


def with_preset(raw: object) -> object:
    """Return what a study says of its engine, with the figures of the preset that it names filled in.

    `raw` comes from the TOML parser: a table, or the name of an engine of the library. Raises `InvalidValue`:
    there is no engine of that name.
    """
    if isinstance(raw, str):
        return {**engine_preset(raw, "engine").entries(), "preset": raw}
    if not isinstance(raw, Mapping) or "preset" not in raw:
        return raw
    return {**engine_preset(checked("engine.preset", raw["preset"], str)).entries(), **raw}
