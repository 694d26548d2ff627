"""Rods with extreme parameters, as in `fea run`: equilibrium must always hold."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from fea.judge.case_result import CaseResult
from fea.rod.loading import EngineLoading
from fea.run.prepare import PreparedRod, prepare
from fea.run.speed import SpeedResult, solve_speed
from fea.solid.element import gauss_blocks, tabulate
from fea.study.engine_table import EngineTable
from fea.study.option_tables import ForcesTable, MeshTable
from fea.study.study import load_study
from fea.verify.stability.row import ExtremeRow, Verdict, judged
from geometry.errors import InvalidValue

# The coarsest mesh of a rod.
SIZE = 12.0
WEBS = (5.0, 2.0, 1.0, 0.6, 0.3)
PULL = 1e4
# Range of x in which León's rod has its web, mm.
SLAB = (55.0, 105.0)
SPEEDS = (0.0, 1.0, 6000.0, 20_000.0)
RATIOS = (0.05, 0.6, 0.9)
# Bar, at rest; no engine withstands the last.
HYDROLOCKS = (100.0, 399.0, 1000.0)
OVERSPEEDS = (9000.0, 12_000.0)
# For the force in a section, because recovered stress is not exactly in equilibrium.
SECTION_PERCENT = 3.0
# Relative to the largest force, or to that force times the rod's length: one quadrature integrates all loads.
BALANCE_PERCENT = 1e-8
# Degree of the quadrature of the force in the section.
_DEGREE = 4


def rows() -> list[ExtremeRow]:
    """Thin webs; then speed, λ and gas pressure, by the sums of the forces on the mesh."""
    return [*_webs(), *_engines()]


def _webs() -> list[ExtremeRow]:
    """Pull rods with thinner and thinner webs: the written stress must transmit the force at each section."""
    study = load_study("leon-2001")
    if study.rod.dimensions is None:
        raise AssertionError("the shipped study has dimensions")
    given = replace(study, engine=None, forces=ForcesTable((PULL, 0.0)), mesh=MeshTable(SIZE))
    found = []
    for web in WEBS:
        rod = replace(study.rod, dimensions=replace(study.rod.dimensions, web_thickness=web))
        result = solve_speed(prepare(replace(given, rod=rod)), None)
        error = 100 * abs(section_force(result.cases["given"]) / PULL - 1)
        found.append(_row(("web of a rod, p2", "mm", web), result, error, SECTION_PERCENT))
    return found


def section_force(case: CaseResult) -> float:
    """Force along the rod in the mean of its sections in `SLAB`, of the stress that is written, N.

    It is ∫ w σ_xx dV / ∫ w dx with a parabola w(x) that is zero at both ends.
    """
    mesh, stress = case.mesh, case.stress
    values = tabulate(mesh.tets.shape[1], _DEGREE).values
    low, high = SLAB
    total = 0.0
    for block, gauss in gauss_blocks(mesh, _DEGREE):
        tets = mesh.tets[block]
        x, along = mesh.points[tets, 0] @ values.T, stress[tets, 0] @ values.T
        total += float((np.maximum((x - low) * (high - x), 0) * along * gauss.volumes).sum())
    return total / ((high - low) ** 3 / 6)


def _engines() -> list[ExtremeRow]:
    """Nodal forces on a coarse mesh, including inertia, must sum to zero."""
    study = load_study("leon-2001")
    if study.engine is None or study.rod.length is None:
        raise AssertionError("the shipped study has an engine and a rod")
    usual, length = study.engine, study.rod.length
    otto = replace(usual, gas="otto", compression_ratio=8.0, peak_pressure_bar=60.0)
    motored = replace(usual, gas="motored", compression_ratio=8.0)
    rod = prepare(replace(study, mesh=MeshTable(SIZE)))
    found = _sums(rod, usual, ("engine speed, mesh", "rpm"), {rpm: rpm for rpm in SPEEDS})
    for ratio in RATIOS:
        engine = replace(otto, stroke_mm=2 * ratio * length)
        found += _sums(rod, engine, ("crank ratio, mesh", "λ"), {ratio: 6000.0})
    for peak in HYDROLOCKS:
        engine = replace(otto, peak_pressure_bar=peak)
        found += _sums(rod, engine, ("hydrolock, mesh", "bar"), {peak: 0.0})
    return found + _sums(rod, motored, ("motored, mesh", "rpm"), {rpm: rpm for rpm in OVERSPEEDS})


def _sums(
    rod: PreparedRod, table: EngineTable, case: tuple[str, str], speeds: Mapping[float, float]
) -> list[ExtremeRow]:
    """Combine the rod with another engine and run it at some speeds, rpm, by the parameter of their rows."""
    try:
        rod = replace(rod, loading=EngineLoading.of(table, rod.mesh.bores.rod_length))
    except InvalidValue:
        return [ExtremeRow(*case, value, Verdict.REFUSED) for value in speeds]
    found = []
    for value, rpm in speeds.items():
        result = solve_speed(rod, rpm)
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
