"""The JSON Schema of a study, from the dataclasses that read it.

Keys, types, choices and defaults are those of the tables, the descriptions those of the template. Rules
between values are left to the reader.
"""

import dataclasses
import types
import typing
from collections.abc import Mapping
from enum import StrEnum
from typing import Any

from fea.study.engine_presets import engine_names
from fea.study.material_presets import MATERIALS
from fea.study.rod_table import rod_keys, sufficient
from fea.study.study import TABLES
from fea.study.tables import required
from fea.study.template import description
from geometry.imports import UNITS
from geometry.presets import PRESETS

# Beside a study that `fea init` writes, whose first line names it.
SCHEMA_FILE = "fea-study.schema.json"
_TITLE = "Study of a connecting rod for fea"
_TYPES = {float: "number", int: "integer", str: "string", bool: "boolean"}

Schema = dict[str, Any]


def study_schema() -> Schema:
    """Return the schema (draft 2020-12) of a study as a TOML or JSON document."""
    tables = {"rod": _rod(), **{name: _table(name, cls) for name, cls in TABLES.items()}}
    part = tables["material"]
    tables["part_material"] = part
    tables["material"] = part | {"additionalProperties": _reference("part_material")}
    tables["engine"] |= _or_a_name(tables["engine"].pop("required"))
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": _TITLE,
        "type": "object",
        "properties": {name: _reference(name) for name in ("rod", *TABLES)},
        "required": ["rod"],
        "not": {"required": ["engine", "forces"]},
        "additionalProperties": False,
        "$defs": tables,
    }


def is_schema(text: str) -> bool:
    """Whether a text is this schema, of any version of the program."""
    return f'"title": "{_TITLE}"' in text


def _rod() -> Schema:
    properties = {key: _key("rod", key, hint) for key, hint in rod_keys().items()}
    properties["preset"] |= _choices(PRESETS)
    properties["unit"] |= _choices(UNITS)
    return _object(properties) | {"anyOf": _alternatives(sufficient())}


def _table(name: str, cls: type[Any]) -> Schema:
    hints, defaults = typing.get_type_hints(cls), _defaults(cls)
    properties = {key: _key(name, key, hint) | defaults.get(key, {}) for key, hint in hints.items()}
    presets = {"material": MATERIALS, "engine": engine_names()}
    if name in presets:
        properties["preset"] |= _choices(presets[name])
    needed = required(cls)
    return _object(properties) | ({"required": needed} if needed else {})


def _or_a_name(needed: list[str]) -> Schema:
    """Keywords of an engine: a name of the library, or a table with a preset or with what it cannot lack.

    Not as alternatives of two schemas, for which editors could not tell the key that is wrong.
    """
    return {
        "type": ["string", "object"],
        "if": {"type": "string"},
        "then": _choices(engine_names()),
        "anyOf": _alternatives([["preset"], needed]),
    }


def _object(properties: Mapping[str, Schema]) -> Schema:
    return {"type": "object", "properties": dict(properties), "additionalProperties": False}


def _alternatives(keys: list[list[str]]) -> list[Schema]:
    return [{"required": names} for names in keys]


def _reference(name: str) -> Schema:
    return {"$ref": f"#/$defs/{name}"}


def _choices(names: typing.Iterable[str]) -> Schema:
    return {"type": "string", "enum": sorted(names)}


def _defaults(cls: type[Any]) -> dict[str, Schema]:
    """Defaults of a table's fields, where they have one that a study could state."""
    given = {field.name: field.default for field in dataclasses.fields(cls)}
    absent = (dataclasses.MISSING, None)
    return {
        name: {"default": str(value) if isinstance(value, StrEnum) else value}
        for name, value in given.items()
        if value not in absent
    }


def _key(table: str, key: str, hint: Any) -> Schema:
    options = typing.get_args(hint) if isinstance(hint, types.UnionType) else (hint,)
    kinds = [_type(option) for option in options if option is not types.NoneType]
    kind = kinds[0] if len(kinds) == 1 else {"anyOf": kinds}
    return {"description": description(table, key)} | kind


def _type(option: Any) -> Schema:
    if typing.get_origin(option) is tuple:
        return {"type": "array", "items": _type(typing.get_args(option)[0])}
    if typing.get_origin(option) is dict:
        return {"type": "object", "additionalProperties": _type(typing.get_args(option)[1])}
    if issubclass(option, StrEnum):
        return {"type": "string", "enum": [str(choice) for choice in option]}
    return {"type": _TYPES[option]}
