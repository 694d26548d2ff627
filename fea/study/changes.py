"""Changes to the tables of a study, as `Study.with_` takes them: read and checked as in a study file."""

import dataclasses
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

from fea.base import choices
from fea.base.shipped import TomlTable
from fea.study.assembly_table import AssemblyTable
from fea.study.defect_table import DefectTable
from fea.study.engine_table import EngineTable, with_implied_gas, with_preset
from fea.study.film_table import FilmTable
from fea.study.material_table import MaterialTable
from fea.study.option_tables import (
    AnalysisTable,
    ContactTable,
    ForcesTable,
    GaugeTable,
    MeshTable,
    OptimiseTable,
    OutputTable,
    read_gauges,
)
from fea.study.overload_table import OverloadTable
from fea.study.rod_table import RodKeys, RodTable
from fea.study.scatter_table import ScatterTable
from fea.study.speed_tables import DutyTable, SpeedTable, parse_speeds
from fea.study.tables import (
    entries_of,
    hints_of,
    in_own_units,
    keys_of,
    options_of,
    read_table,
    unknown_key,
    with_changes,
)
from geometry.errors import InvalidValue

if TYPE_CHECKING:
    from fea.study.study import Study


_ENGINE: tuple[Any, ...] = RodKeys, MaterialTable, EngineTable, SpeedTable, DutyTable, ScatterTable
_LOADED: tuple[Any, ...] = OverloadTable, ForcesTable, AssemblyTable
# In the order of the commented study.
_SOLVED: tuple[Any, ...] = MeshTable, AnalysisTable, ContactTable, FilmTable
_LAST: tuple[Any, ...] = DefectTable, OptimiseTable, OutputTable
TABLES: Mapping[str, Any] = {table.TABLE: table for table in (*_ENGINE, *_LOADED, *_SOLVED, *_LAST)}


def with_own_units(raw: Mapping[str, Any]) -> TomlTable:
    """Return the tables of a study with values that have units as `in_own_units`; errors as there."""
    tables = {name: table for name, table in raw.items() if name in TABLES and isinstance(table, Mapping)}
    return {**raw, **{name: in_own_units(TABLES[name], name, table) for name, table in tables.items()}}


Keys = Mapping[str, Any]  #: of a table, with their values; None takes a key away


class Changes(TypedDict, total=False):
    """What `Study.with_` takes: a table, keys of it, a name or a number, or None for no table."""

    rod: RodTable | Keys
    material: MaterialTable | Keys | str | None
    engine: EngineTable | Keys | str | None
    speed: SpeedTable | Keys | float | str | Sequence[float] | None
    duty: DutyTable | Keys | None
    scatter: ScatterTable | Keys | None
    overload: OverloadTable | Keys | None
    forces: ForcesTable | Keys | None
    assembly: AssemblyTable | Keys | None
    mesh: MeshTable | Keys | None
    analysis: AnalysisTable | Keys | None
    contact: ContactTable | Keys | None
    film: FilmTable | Keys | None
    defect: DefectTable | Keys | None
    optimise: OptimiseTable | Keys | None
    output: OutputTable | Keys | None
    gauge: Sequence[GaugeTable | Keys] | None


def changed_fields(study: Any, changes: Keys) -> TomlTable:
    """Return the fields of a `Study` that changes give other values; files are relative to this directory.

    Raises `InvalidValue`: a table or key is unknown, or a value breaks a rule.
    """
    for name in changes:
        if name not in (*TABLES, "gauge"):
            raise unknown_key("with_:", name, (*TABLES, "gauge"))
    usual = {field.name: field for field in dataclasses.fields(study)}
    fields: TomlTable = {}
    new = {name for name in changes if getattr(study, name) in (None, _default(usual[name]))}
    given = {name: change for name, change in changes.items() if change is not None}
    on = switched_on({name: change for name, change in given.items() if name in new or name == "analysis"})
    for name, change in {**changes, **on}.items():
        present = getattr(study, name)
        if name == "material" and isinstance(change, Mapping | None):
            fields["part_material"] = {} if change is None else _parts(study.part_material, change)
        if change is None and name != "rod":
            fields[name] = _default(usual[name])
        elif name == "gauge":
            fields[name] = read_gauges(change)
        elif isinstance(change, RodTable if name == "rod" else TABLES[name]):
            fields[name] = change
        else:
            fields[name] = _changed(name, present, change)
    return fields


def _default(field: "dataclasses.Field[Any]") -> Any:
    made = field.default_factory
    return field.default if made is dataclasses.MISSING else made()


def _changed(name: str, present: Any, change: Any) -> Any:
    if name == "rod":
        return present.with_keys(change, Path.cwd())
    if name in ("material", "engine") and isinstance(change, str):
        change = {"preset": change}
    if name == "speed" and not isinstance(change, Mapping):
        speeds = parse_speeds(change)
        change = {"rpm": speeds[0] if len(speeds) == 1 else speeds}
    if name == "material" and isinstance(change, Mapping):
        change = {key: value for key, value in change.items() if not _is_part(key, value)}
        if not change:
            return present
    if name == "engine" and isinstance(change, Mapping):
        change = in_own_units(EngineTable, name, change)
        if change.get("preset") is not None:
            change = with_preset(change)
        if present is None or present.gas == "none":
            change = with_implied_gas(change)
    table = changed_table(TABLES[name], name, present, change)
    return table.located(Path.cwd()) if name in ("engine", "duty") else table


def changed_table(cls: Any, where: str, present: Any, change: Any) -> Any:
    """Return a table whose keys change; with a preset, only its keys count. Errors as `read_table`."""
    if not isinstance(change, Mapping):
        return read_table(cls, where, change)
    kept = {} if present is None or change.get("preset") is not None else entries_of(present)
    return read_table(cls, where, with_changes(cls, where, kept, change))


def _is_part(key: str, value: object) -> bool:
    """Whether an entry of [material] is the table of a part, or takes one away."""
    return isinstance(value, Mapping | MaterialTable) or (value is None and key not in keys_of(MaterialTable))


def _parts(present: Mapping[str, MaterialTable], change: Keys) -> dict[str, MaterialTable]:
    parts = dict(present)
    for name, value in change.items():
        if not _is_part(name, value):
            continue
        if value is None:
            parts.pop(name, None)
        elif isinstance(value, MaterialTable):
            parts[name] = value
        else:
            parts[name] = changed_table(MaterialTable, f"material.{name}", parts.get(name), value)
    return parts


def switched_on(raw: Keys) -> TomlTable:
    """Return the tables of a study with what others switch on in [analysis] unless that says otherwise."""
    analysis = raw.get("analysis", {})
    by_table = {"assembly": ("pressure", choices.CONTACT), "film": ("film", True)}
    by_table |= dict.fromkeys(("duty", "scatter", "defect"), ("cycle", True))
    switched: TomlTable = dict(entry for table, entry in by_table.items() if table in raw)
    if not switched or not isinstance(analysis, Mapping):
        return dict(raw)
    return {**raw, "analysis": {**switched, **analysis}}


def parted(raw: Keys) -> tuple[TomlTable, dict[str, MaterialTable]]:
    """Return the tables of a study without the materials of parts, and these by the names of their parts."""
    material = raw.get("material")
    if not isinstance(material, Mapping):
        return dict(raw), {}
    parts = {key: value for key, value in material.items() if isinstance(value, Mapping)}
    rest = {key: value for key, value in material.items() if key not in parts}
    tables = {key: read_table(MaterialTable, f"material.{key}", value) for key, value in parts.items()}
    left = {key: value for key, value in raw.items() if key != "material"}
    return (left | {"material": rest} if rest else left), tables


def load_cases_alone(study: "Study", **options: Any) -> "Study":
    """Return the study without the crank cycle and what needs it, and with other keys of [analysis]."""
    analysis = replace(study.analysis, cycle=False, fretting=False, **options)
    beside: dict[str, Any] = {"duty": None, "scatter": None, "overload": None, "optimise": None}
    return replace(study, analysis=analysis, defect=DefectTable(), output=OutputTable(), **beside)


# Commands of the shell stay as they are; a word beside a flag may be its value.
_SHELL = r"`[^`]*`|\b(?:fea|pip) (?!is\b|has\b)[a-z]+(?: --[\w-]+| [\w.-]+\.toml)+"
_FLAG = re.compile(rf"{_SHELL}|--(?P<no>no-)?(?P<name>[a-z][a-z-]+)(?: (?P<value>[\w.-]*\w)(?P<end>\))?)?")


@cache
def _values() -> dict[str, Any]:
    """Return by each flag what words its value may be; None for a switch."""
    flags: dict[str, Any] = {}
    for cls in TABLES.values():
        for key, declared in keys_of(cls).items():
            options = options_of(declared.kind or hints_of(cls)[key])
            words = {str(word) for option in options if hasattr(option, "__members__") for word in option}
            flags[declared.flag] = None if options == [bool] else words
    return flags


def in_python(text: str) -> str:
    """Return a message whose flags are named as arguments: ``--tolerance 0`` is ``tolerance=0``."""

    def argument(found: re.Match[str]) -> str:
        if found["name"] is None:
            return found[0]
        name, value = found["name"].replace("-", "_"), found["value"]
        words = _values().get(name, set())
        rest = found[0].partition(" ")[2]
        if words is None or found["no"]:
            return f"{name}={not found['no']}" + (f" {rest}" if rest else "")
        if value and re.fullmatch(r"[\d.]+|[A-Z]+", value):
            return f"{name}={rest}"
        if value and (value in words or found["end"] or "." in value):
            return f'{name}="{value}"{found["end"] or ""}'
        return f"{name}=" + (f" {rest}" if rest else "")

    return _FLAG.sub(argument, text)


@contextmanager
def python_words() -> Iterator[None]:
    """Let errors that leave the block, or the function that this decorates, speak Python's words."""
    try:
        yield
    except InvalidValue as error:
        name = "study" if error.name == "STUDY" else error.name
        name = name[2:].replace("-", "_") if name.startswith("--") else name
        words = in_python(error.rule), in_python(error.remedy), error.example
        InvalidValue.__init__(error, name, error.value, *words)
        raise
    except Exception as error:
        error.args = tuple(in_python(arg) if isinstance(arg, str) else arg for arg in error.args)
        raise
