"""Documents on the keys of a study: the commented study of `fea init`, and the JSON Schema.

Keys, types, choices and defaults are those of the tables, the descriptions those of their declarations. Rules
between values are left to the reader.
"""

import dataclasses
import re
import textwrap
import typing
from collections.abc import Iterable
from enum import StrEnum
from typing import Any

from fea.base.shipped import TomlTable
from fea.study.changes import TABLES
from fea.study.engine_library import engine_aliases, engine_names
from fea.study.material_table import LIBRARY
from fea.study.option_tables import GaugeTable
from fea.study.rod_table import sufficient
from fea.study.tables import Key, hints_of, keys_of, options_of, own_unit, required, stem, unit_of
from geometry.imports import UNITS
from geometry.presets import PRESETS

# Beside a study that `fea init` writes, whose first line names it.
SCHEMA_FILE = "fea-study.schema.json"
_HEAD = f"""#:schema ./{SCHEMA_FILE}
# A study for fea. Edit it, then run: fea run THIS-FILE
# Lengths are in mm, forces in N, stresses in MPa; each key names its unit. A value may have another unit, by
# the key without one: length = "5.7 in", peak_pressure = "1000 psi", bolt_torque = "45 lbf ft". Keys that
# are commented out show their default value or an alternative. Flags on the command line override the values
# in this file.
"""
# Tables of a part's material, after the table that they belong to.
_PARTS = {
    "material": """
# A part may have a material of its own; `fea rod` lists the names of the parts of a STEP file. Those of an
# assembly are: cap, bolt, bushing and shell.
# [material.bushing]
# E_GPa = 110.0
# nu = 0.34
# density_kg_m3 = 8800.0
# yield_MPa = 250.0
""",
    "contact": """
# [material.piston_pin]    # steel if left out; E_GPa and nu are enough, also for [material.crank_pin]
# E_GPa = 206.0
# nu = 0.3
""",
}
# Columns in which comments begin, and in which lines end.
_STOPS, _WIDTH = (27, 36, 46), 118


def template() -> str:
    """Return the commented study."""
    parts = [_HEAD]
    for name, table in {**TABLES, GaugeTable.TABLE: GaugeTable}.items():
        heading = f"[{name}]" if name in TABLES else f"[[{name}]]"
        parts += [*_comment(table.INTRO), f"{'# ' if table.OPTIONAL else ''}{heading}"]
        for key, declared in keys_of(table).items():
            parts += [*_comment(declared.above), *_entry(key, declared)]
        parts += ["", *([_PARTS[name].lstrip()] if name in _PARTS else [])]
    return "\n".join(parts)


def commented(table: str, names: Iterable[str]) -> str:
    """Return some keys of a table as the commented study has them, in its order."""
    wanted = set(names)
    keys = {name: declared for name, declared in keys_of(TABLES[table]).items() if name in wanted}
    return "".join(f"{line}\n" for name, declared in keys.items() for line in _entry(name, declared))


def _comment(text: str) -> list[str]:
    return textwrap.wrap(text, _WIDTH - 4, initial_indent="# ", subsequent_indent="# ")


def _entry(name: str, declared: Key) -> list[str]:
    entry = f"{'' if declared.stated else '# '}{name} = {declared.example}"
    if not declared.comment:
        return [entry]
    column = next((stop for stop in _STOPS if len(entry) < stop), len(entry) + 1)
    return textwrap.wrap(
        declared.comment,
        _WIDTH,
        initial_indent=f"{entry:<{column}}# ",
        subsequent_indent=f"{'':<{_STOPS[0]}}# ",
        break_long_words=False,
        break_on_hyphens=False,
    )


_TITLE = "Study of a connecting rod for fea"
_TYPES = {int: "integer", str: "string", bool: "boolean"}
Schema = TomlTable
_NUMBER: Schema = {"type": "number"}
_QUANTITY = (
    r"[0-9].*([A-DF-Za-df-z%\"'°]|[^ -~]|[eE][^0-9+-])"  # a number and its unit, which may end in a digit
)


def study_schema() -> Schema:
    """Return the schema (draft 2020-12) of a study as a TOML or JSON document."""
    tables = {name: _schema_of(cls) for name, cls in TABLES.items()}
    named: dict[str, Iterable[str]] = {"preset": PRESETS, "unit": UNITS}
    for key, names in named.items():
        tables["rod"]["properties"][key] |= _choices(sorted(names))
    engines = _in_any_case(sorted((*engine_names(), *engine_aliases())))
    tables["engine"]["properties"]["preset"] |= engines
    materials = [name for material in LIBRARY.values() for name in (material.name, *material.also)]
    # In any case, with or without hyphens.
    tables["material"]["properties"]["preset"]["examples"] = sorted(materials)
    tables["rod"] |= {"anyOf": [_needs(names) for names in sufficient()]}
    tables["part_material"] = tables["material"]
    tables["material"] = tables["material"] | {"additionalProperties": {"$ref": "#/$defs/part_material"}}
    tables["engine"].pop("allOf")
    tables["engine"] |= {
        "type": ["string", "object"],
        "if": {"type": "string"},
        "then": engines,
        "anyOf": [_needs(names) for names in (["preset"], required(TABLES["engine"]))],
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": _TITLE,
        "type": "object",
        "properties": {name: {"$ref": f"#/$defs/{name}"} for name in TABLES}
        | {GaugeTable.TABLE: {"type": "array", "items": _schema_of(GaugeTable)}},
        "required": ["rod"],
        "not": {"required": ["engine", "forces"]},
        "additionalProperties": False,
        "$defs": tables,
    }


def is_schema(text: str) -> bool:
    """Whether a text is this schema, of any version of the program."""
    return f'"title": "{_TITLE}"' in text


def _schema_of(cls: Any) -> Schema:
    defaults = {field.name: field.default for field in dataclasses.fields(cls)}
    properties: dict[str, Schema] = {}
    for name, declared in keys_of(cls).items():
        takes_text = own_unit(name) or declared.entries()
        number = {"type": ["number", "string"], "pattern": _QUANTITY} if takes_text else _NUMBER
        kind = _type(hints_of(cls)[name], number)
        words = ", ".join(filter(None, unit_of(name)))
        description = f"{words}: {declared.comment}" if declared.comment else words
        properties[name] = {"description": description} | kind
        if declared.alias:
            properties[declared.alias] = {"description": f"now {name}", "deprecated": True} | kind
        if stem(name) != name:
            text = _type(hints_of(cls)[name], {"type": "string", "pattern": _QUANTITY})
            description = f"{name}, as a text with its unit: {declared.comment}"
            properties[stem(name)] = {"description": description} | text
        if defaults[name] not in (dataclasses.MISSING, None):
            properties[name]["default"] = defaults[name]
    needed = _needs(required(cls)) if required(cls) else {}
    return {"type": "object", "properties": properties, "additionalProperties": False} | needed


def _needs(names: Iterable[str]) -> Schema:
    ways = [dict.fromkeys((name, stem(name))) for name in names]
    return {"allOf": [{"anyOf": [{"required": [key]} for key in keys]} for keys in ways]}


def _choices(names: Iterable[str]) -> Schema:
    return {"type": "string", "enum": list(names)}


def _in_any_case(names: Iterable[str]) -> Schema:
    """Return the choices of names that are read in any case, with or without blanks and hyphens."""
    spelt = (
        "[ _-]*".join(f"[{one.upper()}{one}]" if one.isalpha() else re.escape(one) for one in name)
        for name in (each.replace("-", "") for each in names)
    )
    return {"type": "string", "anyOf": [{"enum": list(names)}, {"pattern": f"^({'|'.join(spelt)})$"}]}


def _type(hint: Any, number: Schema) -> Schema:
    """Return the type of a key, in which `number` is that of a real number."""
    option, *others = options_of(hint)
    if others:
        return {"anyOf": [_type(each, number) for each in (option, *others)]}
    if typing.get_origin(option) is tuple:
        return {"type": "array", "items": _type(typing.get_args(option)[0], number)}
    if typing.get_origin(option) is dict:
        return {"type": "object", "additionalProperties": _type(typing.get_args(option)[1], number)}
    if option is float:
        return number
    return _choices(map(str, option)) if issubclass(option, StrEnum) else {"type": _TYPES[option]}
