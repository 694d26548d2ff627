"""Buckling in a run: column formulas always, modes of the meshed rod where they are asked for."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from fea.analysis.figures import figures
from fea.analysis.modes import moves
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.analysis.summary_figures import BucklingFigures, BucklingModeFigures, ColumnFigures, PlaneFigures
from fea.base.checks import Check, check
from fea.base.material import Material
from fea.base.note import Note, omission
from fea.judge.column import ColumnLoads, Plane, column
from fea.judge.safety_factor import without_bar
from fea.solid.parity import Parity
from fea.solvers.buckling import BucklingMode
from geometry.arrays import Floats
from loads.instants import Instants
from mesh.tetmesh import MirroredMesh, TetMesh


def part_at(mesh: TetMesh, station: float) -> int:
    """Number of the part that fills most of the cross-section at x = `station`, mm."""
    if mesh.part is None:
        return 0
    corners = mesh.points[mesh.tets[:, :4]]
    cut = (corners[..., 0].min(axis=1) <= station) & (station <= corners[..., 0].max(axis=1))
    volumes = np.abs(np.linalg.det(corners[cut, 1:] - corners[cut, :1]))
    return int(np.bincount(mesh.part[cut], volumes).argmax())


COUNT = 3
_NO_CONTACT = omission("contact in the buckling modes", "they are found with the pressure cosine-180")
_ONLY_PULLED = omission("buckling modes", "no load case compresses the rod")
# The stress of these is the reference load of the eigenvalue problem.
_CASES = ("compression", "gas", "given")


@dataclass(frozen=True)
class BucklingReport:
    """Buckling at one speed."""

    figures: BucklingFigures  #: for the summary
    #: Mode shapes (n_nodes, 3) of the worst case by name, their largest displacement 1 mm
    shapes: Mapping[str, Floats] = field(default_factory=dict)
    checks: Mapping[str, Check] = field(default_factory=dict)  #: by name
    notes: tuple[Note, ...] = ()  #: what was not computed, and why


def buckling_report(rod: PreparedRod, result: SpeedResult) -> BucklingReport:
    """Judge buckling under the cases of one speed. Raises `SingularMatrixError`: a factorisation failed."""
    cases = result.loads.cases
    columns = column_figures(rod, cases)
    pushed = cases[np.isin(cases.names, _CASES) & (compression(cases) > 0)]
    alone = BucklingFigures(column=columns, min_safety_factor=columns.min_safety_factor)
    if not rod.options.buckling:
        return BucklingReport(alone)
    if not len(pushed):
        return BucklingReport(replace(alone, modes={}), notes=(_ONLY_PULLED,))
    with rod.clock("buckling"):
        # A buckling load is a multiple of the load; contact is not.
        displacement = rod.equilibrium(pushed, pins=rod.prescribed).solution.displacement
        by_case = rod.buckling.modes(displacement, COUNT)
    of_case = {case.name: modes for case, modes in zip(pushed, by_case, strict=True)}
    every = [mode for modes in by_case for mode in modes]
    worst = min(of_case, key=lambda name: min((mode.factor for mode in of_case[name]), default=np.inf))
    whole = rod.mesh.mirrored
    factors = [mode.factor for mode in every]
    factors += [] if columns.min_safety_factor is None else [columns.min_safety_factor]
    with_modes = replace(
        alone,
        modes={
            name: tuple(
                BucklingModeFigures(factor=mode.factor, moves=moves(whole.mesh.points, _shape(whole, mode)))
                for mode in modes
            )
            for name, modes in of_case.items()
        },
        shapes_of=worst,
        min_safety_factor=without_bar(min(factors, default=None)),
    )
    shapes = {f"mode_{i}": _shape(whole, mode) for i, mode in enumerate(of_case[worst], start=1)}
    residual = max((mode.residual for mode in every), default=0.0)
    notes = () if rod.prescribed is rod.pins else (_NO_CONTACT,)
    return BucklingReport(with_modes, shapes, {"buckling": check("buckling", residual)}, notes)


def shank_material(rod: PreparedRod) -> Material:
    """Material of the shank at its least section."""
    return rod.materials[part_at(rod.mesh.whole, rod.shank[1].x)]


def columns(rod: PreparedRod) -> dict[Plane, ColumnLoads]:
    """Return the column formulas of the shank, of the material at its least section."""
    (stations, least), material = rod.shank, shank_material(rod)
    elastic = material.youngs_modulus, material.yield_strength
    return {plane: column(plane, stations, least, *elastic) for plane in Plane}


def column_figures(rod: PreparedRod, cases: Instants) -> ColumnFigures:
    """Return what the column formulas say of the load case that compresses the rod most."""
    worst = cases[int(compression(cases).argmax())]
    force = float(compression(worst))
    planes = {}
    for plane, formulas in columns(rod).items():
        factor = formulas.least / force if force else None
        planes[plane.value] = figures(PlaneFigures, formulas, safety_factor=factor)
    case = worst.name if force else None
    return ColumnFigures(force_N=force, case=case, least_area_mm2=rod.shank[1].area, planes=planes)


def compression(cases: Instants) -> Floats:
    """Return the larger force that compresses the rod, at either end, N; 0 where it is pulled."""
    return np.maximum(0.0, -np.minimum(cases.pin_axial, cases.crank_axial))


def _shape(whole: MirroredMesh, mode: BucklingMode) -> Floats:
    """Displacement (n_nodes, 3) of the whole rod, its largest 1 mm."""
    shape = whole.vector(mode.shape[Parity.SYMMETRIC], mode.shape.get(Parity.ANTISYMMETRIC))
    if mode.parity_z is Parity.ANTISYMMETRIC:
        shape = shape * whole.sign[:, 2:]
    return np.asarray(shape / np.linalg.norm(shape, axis=1).max())
