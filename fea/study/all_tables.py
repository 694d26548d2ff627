"""The tables of a study by their names."""

from collections.abc import Mapping
from typing import Any

from fea.base.shipped import TomlTable
from fea.study.assembly_table import AssemblyTable
from fea.study.defect_table import DefectTable
from fea.study.engine_table import EngineTable
from fea.study.film_table import FilmTable
from fea.study.material_table import MaterialTable
from fea.study.option_tables import (
    AnalysisTable,
    ContactTable,
    ForcesTable,
    MeshTable,
    OptimiseTable,
    OutputTable,
)
from fea.study.overload_table import OverloadTable
from fea.study.rod_table import RodKeys
from fea.study.scatter_table import ScatterTable
from fea.study.speed_tables import DutyTable, SpeedTable
from fea.study.tables import in_own_units

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
