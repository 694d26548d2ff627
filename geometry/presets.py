"""Rods of published engines, from `presets.toml`, which states what is published and what is ours."""

import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from geometry.dimensions import ShankSection
from geometry.rod import Rod

_TABLES = tomllib.loads(Path(__file__).with_name("presets.toml").read_text(encoding="utf-8"))
# What is published of each, and what is ours.
ORIGINS = MappingProxyType({name: table.pop("origin") for name, table in _TABLES.items()})


class _Presets(Mapping[str, Rod]):
    """The rods by name, each checked where it is asked for."""

    def __init__(self, tables: Mapping[str, Mapping[str, Any]]) -> None:
        self._tables = tables

    def __getitem__(self, name: str) -> Rod:
        sizes = {key.removesuffix("_mm"): value for key, value in self._tables[name].items()}
        return Rod(**sizes | {"shank_section": ShankSection(sizes["shank_section"])})

    def __iter__(self) -> Iterator[str]:
        return iter(self._tables)

    def __len__(self) -> int:
        return len(self._tables)


PRESETS = _Presets(_TABLES)
