"""Engines and rods with extreme parameters: equilibrium must always hold."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from fea.analysis.pipeline import prepare, solve_speed
from fea.analysis.prepared_rod import PreparedRod
from fea.base.units import BAR, KG, KG_M2, RPM
from fea.judge.case_result import CaseResult
from fea.rod.loading import EngineLoading
from fea.solid.assembly import gauss_blocks, tabulate
from fea.study.engine_table import EngineTable
from fea.study.option_tables import ForcesTable, MeshTable
from fea.study.study import load_study
from fea.verify.stability.outcome import ExtremeRow, Outcome, Setting, judged
from geometry.errors import InvalidValue
from geometry.mass import MassProperties
from loads.dynamics import cycle
from loads.engine import Engine
from loads.gas import Otto

_LENGTH = 141.0  # mm
_ZERO = (0.0, 0.0, 0.0)
_ROD = MassProperties(0.785 * KG, (64.0, 0.0, 0.0), (_ZERO, _ZERO, (0.0, 0.0, 3e-3 * KG_M2)))


def engines() -> Iterator[ExtremeRow]:
    """Pin, crank and inertia forces of the rod must sum to zero.

    The speed varies with León's proportions, λ at 6000 rpm, and the gas pressure at rest: the last of them is
    a hydraulic lock.
    """
    for rpm in (0.0, 1.0, 6000.0, 20_000.0, 50_000.0):
        yield _balance(("engine speed", "rpm", rpm), rpm=rpm)
    for ratio in (0.05, 0.3, 0.6, 0.9):
        yield _balance(("crank ratio", "λ", ratio), ratio=ratio)
    for peak in (20.0, 100.0, 399.0):
        yield _balance(("gas pressure at rest", "bar", peak), rpm=0.0, peak=peak)


def _balance(
    setting: Setting, *, ratio: float = 1 / 3, rpm: float = 6000.0, peak: float = 60.0
) -> ExtremeRow:
    """Judge the balance relative to the largest force on the rod, or to that times the rod's length."""
    engine = Engine(crank_radius=ratio * _LENGTH, rod_length=_LENGTH, bore=76.0, piston_mass=1.0 * KG)
    gas = Otto(engine, 8.0, peak * BAR)
    error = 100 * max(_imbalance(engine, gas, rpm * RPM, angle) for angle in np.arange(0, 4 * math.pi, 0.1))
    return judged(setting, error, 1e-10, {})


def _imbalance(engine: Engine, gas: Otto, speed: float, angle: float) -> float:
    """Largest resultant, force or moment about the crank pin, relative to the largest force."""
    c = cycle(engine, _ROD, gas, speed, angle)
    x, y, _ = _ROD.center
    along, square, across, alpha = map(float, c.motions)
    a_x = along - alpha * y - square * x
    a_y = across + alpha * x - square * y
    along = float(c.pin_axial - c.crank_axial) - _ROD.mass * a_x
    across = float(c.pin_transverse + c.crank_transverse) - _ROD.mass * a_y
    turning = float(c.pin_transverse) * _LENGTH - _ROD.inertia_z * alpha - _ROD.mass * (x * a_y - y * a_x)
    largest = float(np.abs([c.pin, c.crank]).max())
    return max(abs(along), abs(across), abs(turning) / _LENGTH) / (largest or 1.0)


_SIZE = 12.0  # the coarsest mesh of a rod, mm
WEBS = (5.0, 2.0, 1.0, 0.6, 0.3)  # mm
_PULL = 1e4  # N
# Range of x in which León's rod has its web, mm.
_SLAB = (55.0, 105.0)


def rods() -> Iterator[ExtremeRow]:
    """Thin webs as in `fea run`; then speed, λ and gas pressure, by the sums of the forces on the mesh."""
    study = load_study("leon-2001")
    if study.engine is None or study.rod.length is None or study.rod.dimensions is None:
        raise AssertionError("the shipped study has an engine and a rod")
    pulled = replace(study, engine=None, forces=ForcesTable((_PULL, 0.0)), mesh=MeshTable(_SIZE))
    for web in WEBS:
        table = replace(study.rod, dimensions=replace(study.rod.dimensions, web_thickness=web))
        result = solve_speed(prepare(replace(pulled, rod=table)), None)
        # The written stress must transmit the force; recovered stress is not exactly in equilibrium.
        error = 100 * abs(_section_force(result.cases["given"]) / _PULL - 1)
        yield judged(("web of a rod, p2", "mm", web), error, 3.0, result.checks)
    usual, rod = study.engine, prepare(replace(study, mesh=MeshTable(_SIZE)))
    otto = replace(usual, gas="otto", compression_ratio=8.0, peak_pressure_bar=60.0)
    motored = replace(usual, gas="motored", compression_ratio=8.0)
    speeds = {rpm: rpm for rpm in (0.0, 1.0, 6000.0, 20_000.0)}
    yield from _sums(rod, usual, ("engine speed, mesh", "rpm"), speeds)
    for ratio in (0.05, 0.6, 0.9):
        engine = replace(otto, stroke_mm=2 * ratio * study.rod.length)
        yield from _sums(rod, engine, ("crank ratio, mesh", "λ"), {ratio: 6000.0})
    for peak in (100.0, 399.0, 1000.0):  # at rest; no engine withstands the last
        engine = replace(otto, peak_pressure_bar=peak)
        yield from _sums(rod, engine, ("hydrolock, mesh", "bar"), {peak: 0.0})
    yield from _sums(rod, motored, ("motored, mesh", "rpm"), {rpm: rpm for rpm in (9000.0, 12_000.0)})


def _section_force(case: CaseResult) -> float:
    """Force along the rod in the mean of its sections in the slab, of the stress that is written, N.

    It is ∫ w σ_xx dV / ∫ w dx with a parabola w(x) that is zero at both ends.
    """
    mesh, stress, degree = case.mesh, case.stress, 4
    values = tabulate(mesh.tets.shape[1], degree).values
    low, high = _SLAB
    total = 0.0
    for block, gauss in gauss_blocks(mesh, degree):
        tets = mesh.tets[block]
        x, along = mesh.points[tets, 0] @ values.T, stress[tets, 0] @ values.T
        total += float((np.maximum((x - low) * (high - x), 0) * along * gauss.volumes).sum())
    return total / ((high - low) ** 3 / 6)


def _sums(
    rod: PreparedRod, table: EngineTable, case: tuple[str, str], speeds: Mapping[float, float]
) -> Iterator[ExtremeRow]:
    """Combine the rod with another engine and run it at some speeds, rpm, by the parameter of their rows.

    Nodal forces, including inertia, must sum to zero: one quadrature integrates all loads.
    """
    try:
        rod = replace(rod, loading=EngineLoading.of(table, rod.mesh.bores.rod_length))
    except InvalidValue:
        yield from (ExtremeRow(*case, value, verdict=Outcome.REFUSED) for value in speeds)
        return
    for value, rpm in speeds.items():
        result = solve_speed(rod, rpm)
        error = 100 * max(result.checks[name].value for name in ("force_balance", "moment_balance"))
        yield judged((*case, value), error, 1e-8, result.checks)
