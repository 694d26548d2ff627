"""Rods of published engines, from `presets.toml`, which tells what is published and what is ours."""

from types import MappingProxyType

from geometry.dimensions import ShankSection
from geometry.rod import Rod
from geometry.shipped import tables_beside

_TABLES = tables_beside(__file__, "presets.toml")
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
