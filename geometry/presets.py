"""Rods of published engines, from `presets.toml`, which states what is published and what is ours."""

import tomllib
from pathlib import Path
from types import MappingProxyType

from geometry.dimensions import ShankSection
from geometry.rod import Rod

_TABLES = tomllib.loads(Path(__file__).with_name("presets.toml").read_text(encoding="utf-8"))
# What is published of each, and what is ours.
ORIGINS = MappingProxyType({name: table.pop("origin") for name, table in _TABLES.items()})
PRESETS = MappingProxyType(
    {
        name: Rod(
            shank_section=ShankSection(table.pop("shank_section")),
            **{key.removesuffix("_mm"): value for key, value in table.items()},
        )
        for name, table in _TABLES.items()
    }
)
LEON_2001, FORSA_G10, MOLINA_2000CC = PRESETS.values()
