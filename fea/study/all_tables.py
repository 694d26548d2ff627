"""The tables of a study by their names."""

from collections.abc import Mapping
from typing import Any

from fea.study.assembly_table import AssemblyTable
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

_ENGINE: tuple[Any, ...] = RodKeys, MaterialTable, EngineTable, SpeedTable, DutyTable, ScatterTable
_LOADED: tuple[Any, ...] = OverloadTable, ForcesTable, AssemblyTable
_SOLVED: tuple[Any, ...] = MeshTable, AnalysisTable, ContactTable, FilmTable, OptimiseTable, OutputTable
# In the order of the commented study.
TABLES: Mapping[str, Any] = {table.TABLE: table for table in (*_ENGINE, *_LOADED, *_SOLVED)}
