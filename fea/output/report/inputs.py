"""The inputs of a run with where they come from."""

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any, NamedTuple

from fea.output.report.wording import named, shown
from fea.study.presets import MATERIALS, SOURCES
from fea.study.study import ASSUMED_MATERIAL, TABLES, Study
from geometry.presets import ORIGINS, PRESETS

_TITLES = {
    "rod": "Rod", "material": "Material", "engine": "Engine and gas", "speed": "Speed",
    "forces": "Given forces", "mesh": "Mesh", "analysis": "Analysis", "contact": "Pins in contact",
}  # fmt: skip
_GIVEN, _DEFAULT = "the study", "the program's default"


class Input(NamedTuple):
    """An input: its name, its value as text, its unit, and where it comes from."""

    name: str
    value: str
    unit: str
    origin: str


class InputTable(NamedTuple):
    """Inputs of one kind, and what holds for all of them."""

    title: str
    remark: str
    rows: tuple[Input, ...]

    @property
    def origin(self) -> str:
        """Where all of them come from; empty where they differ."""
        origins = {row.origin for row in self.rows}
        return origins.pop() if len(origins) == 1 else ""


def input_tables(study: Study) -> list[InputTable]:
    """Return all inputs of a study but those that say where results are written."""
    found = []
    for name, values in study.as_dict().items():
        if name == "output":
            continue
        plain = {key: value for key, value in values.items() if not isinstance(value, Mapping)}
        found.append(_table(study, name, _titled(name), plain))
        for part, own in values.items():
            if isinstance(own, Mapping):
                found.append(_table(study, "material", f"Material of {part.replace('_', ' ')}", own))
    return [table for table in found if table.rows]


def _titled(name: str) -> str:
    return _TITLES.get(name, name.replace("_", " ").capitalize())


def _table(study: Study, table: str, title: str, values: Mapping[str, Any]) -> InputTable:
    return InputTable(title, _remark(study, table, values), tuple(_rows(study, table, values)))


def _rows(study: Study, table: str, values: Mapping[str, Any]) -> Iterator[Input]:
    usual = _defaults(table)
    for key, value in values.items():
        name, unit = named(key)
        origin = _engine_origin(study, key, value) if table == "engine" else ""
        if not origin:
            origin = _DEFAULT if key in usual and usual[key] == value else _GIVEN
        yield Input(name, shown(value), unit, origin)


def _defaults(table: str) -> dict[str, Any]:
    kind = TABLES.get(table)
    if kind is None or table in {"rod", "material", "engine", "speed"}:
        return {}
    return {field.name: field.default for field in fields(kind)}


def _engine_origin(study: Study, key: str, value: object) -> str:
    """The source of a figure of an engine of the library; empty where the study gives it itself."""
    preset = None if study.engine is None else study.engine.library()
    known = None if preset is None else preset.engine.get(key)
    if preset is None or known is None or known.value != value:
        return ""
    return f"assumed: {known.origin}" if known.assumed else preset.sources.get(known.origin, known.origin)


def _remark(study: Study, table: str, values: Mapping[str, Any]) -> str:
    if table == "rod":
        same = [name for name, rod in PRESETS.items() if rod == study.rod.dimensions]
        return f"The rod {same[0]} of the library: {ORIGINS[same[0]]}" if same else ""
    if table == "material":
        known = ("E_GPa", "nu", "density_kg_m3", "yield_MPa", "ultimate_MPa", "endurance_MPa")
        own = {key: values[key] for key in known if values.get(key) is not None}
        same = [
            name
            for name, listed in MATERIALS.items()
            if own == {k: v for k, v in listed.items() if k in known}
        ]
        assumed = "Assumed, as the study says nothing. " if study.material is ASSUMED_MATERIAL else ""
        return assumed + (f"The material {same[0]} of the library: {SOURCES[same[0]]}" if same else "")
    if table == "engine" and study.engine is not None and study.engine.library() is not None:
        preset = study.engine.library()
        return f"The engine {preset.name} of the library: {preset.title}." if preset else ""
    return ""
