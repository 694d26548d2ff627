"""The tables of a study by their names."""

from collections.abc import Mapping
from typing import Any

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
from fea.study.rod_table import RodKeys
from fea.study.scatter_table import ScatterTable
from fea.study.speed_tables import DutyTable, SpeedTable

_LOADED: tuple[Any, ...] = RodKeys, MaterialTable, EngineTable, SpeedTable, DutyTable, ScatterTable
_BUILT: tuple[Any, ...] = ForcesTable, AssemblyTable, MeshTable, AnalysisTable, ContactTable, FilmTable
# In the order of the commented study.
_LAST: tuple[Any, ...] = DefectTable, OptimiseTable, OutputTable
TABLES: Mapping[str, Any] = {table.TABLE: table for table in (*_LOADED, *_BUILT, *_LAST)}
