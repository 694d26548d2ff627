"""Rods as `fea run` takes them, at their extremes: equilibrium must hold whatever is asked."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from fea.analysis.pipeline import Analysis, SpeedResult
from fea.machine.clock import Clock
from fea.solid.element import tabulate
from fea.solid.integration import gauss_blocks
from fea.study.engine_table import EngineTable
from fea.study.study import ForcesTable, MeshTable, load_study
from fea.verify.stability.row import ExtremeRow, Verdict, judged
from geometry.invalid import InvalidValue

# As coarse as a rod goes.
SIZE = 12.0
WEBS = (5.0, 2.0, 1.0, 0.6, 0.3)
PULL = 1e4
# Where the web of León's rod is, from there to there, mm.
SLAB = (55.0, 105.0)
SPEEDS = (0.0, 1.0, 6000.0, 20_000.0)
RATIOS = (0.05, 0.6, 0.9)
# At rest; the last is beyond what any engine holds.
HYDROLOCKS = (100.0, 399.0, 1000.0)
OVERSPEEDS = (9000.0, 12_000.0)
# Of the force in a section: recovered stress is not in equilibrium exactly.
SECTION_PERCENT = 3.0
# Of the largest force, and of it times the rod's length: one quadrature integrates all loads.
BALANCE_PERCENT = 1e-8
# Of the quadrature of the section's force.
_DEGREE = 4


def rows() -> list[ExtremeRow]:
    """Thin webs; then speed, λ and gas, by the sums of what acts on the mesh."""
    return [*_webs(), *_engines()]


def _webs() -> list[ExtremeRow]:
    """Pull rods of ever thinner webs: the written stress carries that force through the section."""
    study = load_study("leon-2001")
    if study.rod.rod is None:
        raise AssertionError("the shipped study has dimensions")
    given = replace(study, engine=None, forces=ForcesTable((PULL, 0.0)), mesh=MeshTable(SIZE))
    found = []
    for web in WEBS:
        rod = replace(study.rod, rod=replace(study.rod.rod, web_thickness=web))
        analysis = Analysis(replace(given, rod=rod), Clock())
        result = analysis.at(None)
        error = 100 * abs(section_force(analysis, result) / PULL - 1)
        found.append(_row(("web of a rod, p2", "mm", web), result, error, SECTION_PERCENT))
    return found


def section_force(analysis: Analysis, result: SpeedResult) -> float:
    """Force along the rod in the mean of its sections in `SLAB`, of the stress that is written, N.

    ∫ w σ_xx dV / ∫ w dx with a parabola w(x) that vanishes at both ends.
    """
    mesh, stress = analysis.mesh.whole.mesh, result.cases[0].stress
    values = tabulate(mesh.tets.shape[1], _DEGREE).values
    low, high = SLAB
    total = 0.0
    for block, gauss in gauss_blocks(mesh, _DEGREE):
        tets = mesh.tets[block]
        x, along = mesh.points[tets, 0] @ values.T, stress[tets, 0] @ values.T
        total += float((np.maximum((x - low) * (high - x), 0) * along * gauss.volumes).sum())
    return total / ((high - low) ** 3 / 6)


def _engines() -> list[ExtremeRow]:
    """Nodal forces on a coarse mesh sum to zero, with the inertia that they cause."""
    study = load_study("leon-2001")
    if study.engine is None or study.rod.length is None:
        raise AssertionError("the shipped study has an engine and a rod")
    usual, length = study.engine, study.rod.length
    otto = replace(usual, gas="otto", compression_ratio=8.0, peak_pressure_bar=60.0)
    motored = replace(usual, gas="motored", compression_ratio=8.0)
    analysis = Analysis(replace(study, mesh=MeshTable(SIZE)), Clock())
    found = _sums(analysis, usual, ("engine speed, mesh", "rpm"), {rpm: rpm for rpm in SPEEDS})
    for ratio in RATIOS:
        engine = replace(otto, stroke_mm=2 * ratio * length)
        found += _sums(analysis, engine, ("crank ratio, mesh", "λ"), {ratio: 6000.0})
    for peak in HYDROLOCKS:
        engine = replace(otto, peak_pressure_bar=peak)
        found += _sums(analysis, engine, ("hydrolock, mesh", "bar"), {peak: 0.0})
    return found + _sums(analysis, motored, ("motored, mesh", "rpm"), {rpm: rpm for rpm in OVERSPEEDS})


def _sums(
    analysis: Analysis, table: EngineTable, case: tuple[str, str], speeds: Mapping[float, float]
) -> list[ExtremeRow]:
    """Put another engine on the rod and run it at some speeds, rpm, by the values that their rows show."""
    try:
        engine = table.engine(analysis.mesh.bores.rod_length)
        analysis.engine, analysis.gas = engine, table.gas_model(engine)
    except InvalidValue:
        return [ExtremeRow(*case, value, Verdict.REFUSED) for value in speeds]
    found = []
    for value, rpm in speeds.items():
        result = analysis.at(rpm, cycle=False)
        error = 100 * max(result.checks[name].value for name in ("force_balance", "moment_balance"))
        found.append(_row((*case, value), result, error, BALANCE_PERCENT))
    return found


def _row(place: tuple[str, str, float], result: SpeedResult, error: float, tolerance: float) -> ExtremeRow:
    failed = tuple(name for name, item in result.checks.items() if not item.passed)
    return ExtremeRow(
        *place,
        verdict=judged(error, tolerance, marked=bool(failed)),
        result_error_percent=error,
        backward_error=result.checks["backward_error"].value,
        condition_estimate=result.checks["condition"].value,
        energy_error=result.checks["energy_balance"].value,
        tolerance_percent=tolerance,
        noticed_by=failed,
    )
