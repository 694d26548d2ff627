"""Buckling in a run: column formulas always, modes of the meshed rod where they are asked for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fea.analysis.modes import moves
from fea.analysis.pipeline import Analysis, SpeedResult
from fea.assess.column import Column, Plane, column
from fea.checks import Check, check
from fea.machine.clock import Clock
from fea.rod.omission import Omission
from fea.solid.parity import Parity
from fea.solvers.buckling import BucklingMode
from geometry.arrays import Floats
from loads.cases import LoadCase
from mesh.mirror import MirroredMesh

COUNT = 3
# Of a table of cases: the formulas' (of the case that presses most) and the solid's lowest factor.
BUCKLING_COLUMNS = ("column_safety_factor", "buckling_factor")
_ONLY_PULLED = Omission("modes of buckling", "no case presses the rod")
# The stress of these is the reference load of the eigenvalue problem.
_CASES = ("compression", "gas", "given")


@dataclass(frozen=True)
class BucklingReport:
    """Buckling at one speed.

    Attributes
    ----------
    figures
        For the summary, in the units their names say.
    shapes
        Mode shapes (n_nodes, 3) of the worst case by name, their largest displacement 1 mm.
    checks
        By name.
    left_out
        What was not computed, and why.
    """

    figures: dict[str, Any]
    shapes: dict[str, Floats] = field(default_factory=dict)
    checks: dict[str, Check] = field(default_factory=dict)
    left_out: tuple[Omission, ...] = ()


def buckling_report(analysis: Analysis, result: SpeedResult, clock: Clock) -> BucklingReport:
    """Judge the rod against buckling at one speed.

    Parameters
    ----------
    analysis
        The meshed rod.
    result
        Its load cases.
    clock
        Times the stage ``buckling``.

    Raises
    ------
    SingularMatrixError
        A factorisation broke down.
    """
    cases = [case.case for case in result.cases]
    columns = _columns(analysis, cases)
    factors = [plane["safety_factor"] for plane in columns["planes"].values()]
    figures: dict[str, Any] = {"column": columns}
    shapes: dict[str, Floats] = {}
    checks: dict[str, Check] = {}
    pushed = [case.name for case in cases if case.name in _CASES and compression(case) > 0]
    left_out: tuple[Omission, ...] = ()
    if analysis.study.analysis.buckling and not pushed:
        figures["modes"], left_out = {}, (_ONLY_PULLED,)
    elif analysis.study.analysis.buckling:
        with clock("buckling"):
            found = _modes(analysis, result.rpm, cases, pushed)
        whole = analysis.mesh.whole
        figures["modes"] = {name: [_mode(whole, mode) for mode in modes] for name, modes in found.items()}
        worst = min(found, key=lambda name: min((mode.factor for mode in found[name]), default=np.inf))
        figures["shapes_of"] = worst
        shapes = {f"mode_{i}": _shape(whole, mode) for i, mode in enumerate(found[worst], start=1)}
        every = [mode for modes in found.values() for mode in modes]
        checks["buckling"] = check("buckling", max((mode.residual for mode in every), default=0.0))
        factors += [mode.factor for mode in every]
    figures["min_safety_factor"] = min((factor for factor in factors if factor is not None), default=None)
    return BucklingReport(figures, shapes, checks, left_out)


def column_figures(analysis: Analysis, cases: Sequence[LoadCase]) -> dict[str, Any]:
    """Return what the column formulas say of load cases, as the summary's ``buckling`` holds it."""
    columns = _columns(analysis, cases)
    factors = [plane["safety_factor"] for plane in columns["planes"].values()]
    least = min((factor for factor in factors if factor is not None), default=None)
    return {"column": columns, "min_safety_factor": least}


def buckling_factors(figures: Mapping[str, Any], case: str) -> tuple[float | None, float | None]:
    """Return the `BUCKLING_COLUMNS` of a case from the summary's ``buckling``; None where there is none."""
    column = figures["column"]
    planes = [plane["safety_factor"] for plane in column["planes"].values()] if column["case"] == case else []
    modes = [mode["factor"] for mode in figures.get("modes", {}).get(case, [])]
    return min(planes, default=None), min(modes, default=None)


def compression(case: LoadCase) -> float:
    """Return the larger force that presses the rod together, at either end, N; 0 where it is pulled."""
    return max(0.0, -case.pin_axial, -case.crank_axial)


def _columns(analysis: Analysis, cases: Sequence[LoadCase]) -> dict[str, Any]:
    worst = max(cases, key=compression)
    force = compression(worst)
    stations, least = analysis.sections
    material = analysis.shank_material
    planes = {
        plane.value: _plane(
            column(plane, stations, least, material.youngs_modulus, material.yield_strength), force
        )
        for plane in Plane
    }
    case = worst.name if force else None
    return {"force_N": force, "case": case, "least_area_mm2": least.area, "planes": planes}


def _plane(found: Column, force: float) -> dict[str, Any]:
    return {
        "slenderness": found.slenderness,
        "euler_N": found.euler,
        "johnson_N": found.johnson,
        "rankine_N": found.rankine,
        "safety_factor": found.least / force if force else None,
    }


def _modes(
    analysis: Analysis, rpm: float | None, cases: Sequence[LoadCase], names: Sequence[str]
) -> dict[str, list[BucklingMode]]:
    forces = [part for part, case in zip(analysis.forces(rpm), cases, strict=True) if case.name in names]
    displacement = analysis.model.solve(forces).displacement
    return dict(zip(names, analysis.buckling.modes(displacement, COUNT), strict=True))


def _mode(whole: MirroredMesh, mode: BucklingMode) -> dict[str, Any]:
    return {"factor": mode.factor, "moves": moves(whole.mesh.points, _shape(whole, mode))}


def _shape(whole: MirroredMesh, mode: BucklingMode) -> Floats:
    """Displacement (n_nodes, 3) of the whole rod, its largest 1 mm."""
    shape = whole.vector(mode.shape[Parity.SYMMETRIC], mode.shape.get(Parity.ANTISYMMETRIC))
    if mode.parity_z is Parity.ANTISYMMETRIC:
        shape = shape * whole.sign[:, 2:]
    return np.asarray(shape / np.linalg.norm(shape, axis=1).max())
