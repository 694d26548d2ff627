"""What differs between rods and between cycles: [scatter] of a study, with the defaults of a gas."""

import math

from fea.base.choices import Fatigue
from fea.judge.reliability import Scatter
from fea.rod.loading import EngineLoading
from fea.study.scatter_table import ScatterTable

# Scatter of the gas load where a study gives none: between cylinders, and from cycle to cycle by fuel.
_CYLINDERS, _PETROL, _DIESEL = 3.0, 5.0, 1.5
UNFIRED = {"none", "motored", "boyle", "compressor"}  # gases that do not burn


def scatter_of(table: ScatterTable | None, loading: EngineLoading, criterion: Fatigue) -> Scatter:
    """Return what [scatter] says, with the defaults of a gas."""
    table, engine = table or ScatterTable(), loading.table
    library = engine.library()
    diesel = "diesel" in (engine.fuel, "diesel" if library is not None and "diesel" in library.title else "")
    usual = (_CYLINDERS, _DIESEL if diesel else _PETROL) if engine.gas not in UNFIRED else (0.0, 0.0)
    given = table.peak_pressure_percent, table.cycle_pressure_percent
    cylinder, cycle = (own if one is None else one for one, own in zip(given, usual, strict=True))
    static = table.yield_percent if criterion is Fatigue.SODERBERG else table.ultimate_percent
    batch = table.strength_percent * math.sqrt(table.batch_percent / 100)
    every = table.strength_percent, batch, static, cylinder, table.boost_percent, cycle
    return Scatter(*(percent / 100 for percent in every))
