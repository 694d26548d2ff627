"""What is found at one speed: results of the load cases, checks and notes."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from fea.analysis.cycle.superposition import CycleResult
from fea.analysis.defect_figures import DefectFigures
from fea.analysis.fields import Equilibrium
from fea.analysis.film import FilmResult
from fea.analysis.flowing_rod import FollowedFlow
from fea.analysis.fretting import FrettingResult
from fea.analysis.overload_figures import OverloadFigures
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.summary_figures import PlasticFigures
from fea.base.checks import LIMITS, Check, check
from fea.base.note import SINGULAR, Note, omission, remark, warning
from fea.judge.case_result import CaseResult
from fea.judge.fatigue import check_notes
from fea.rod.loading import SpeedLoads
from fea.rod.meshed_rod import MeshedRod
from fea.solid.inertia import SectionBalance, imbalance
from fea.solid.parity import Parity
from fea.solvers.static import StaticSolution
from geometry.arrays import Floats


def speed_checks(rod: PreparedRod, solved: Equilibrium, cases: Sequence[CaseResult]) -> dict[str, Check]:
    """Hold mesh, loads, solution and results against the limits of `fea.base.checks`, by name."""
    residuals = list(solved.solution.residuals.values())
    values = _of_mesh(rod) | {
        "finite": float(sum(not case.finite for case in cases)),
        # Equivalent strain: von Mises stress over 3 μ.
        "small_strain": max(
            float(np.nanmax(stress)) / (3 * material.shear_modulus)
            for case in cases
            for stress, material in zip(case.part_von_mises, rod.materials, strict=True)
        ),
        "small_displacement": max(case.max_displacement for case in cases) / rod.mesh.bores.rod_length,
        "section_balance": _section_balance(rod.mid_sections, cases),
        "backward_error": max(item.backward_error for item in residuals),
        "energy_balance": max(item.energy for item in residuals),
        "imbalance": max(item.imbalance for item in residuals),
    }
    if solved.solution.condition:
        values["condition"] = max(solved.solution.condition.values())
    values["bore_pressure_scale"] = max(abs(response.scale - 1) for response in solved.responses)
    if not rod.clamped:  # a clamp takes up forces, so that they need not balance
        values |= _balance(rod.mesh, solved)
    for name in sorted({name for response in solved.responses for name in response.checks}):
        values[name] = max(response.checks[name] for response in solved.responses)
    return {name: check(name, value) for name, value in values.items()}


def _of_mesh(rod: PreparedRod) -> dict[str, float]:
    mesh, quality = rod.mesh, rod.mesh.meshing.quality
    order, soft = mesh.cell.order, rod.structure.soft
    values = {
        "inverted_elements": float(quality.least_scaled_jacobian <= 0),
        "flattest_element": 1 / max(quality.least_shape, 1e-300),
        "mesh_mass_p1" if order == 1 else "mesh_mass": mesh.mass_error(rod.mass.mass, rod.materials),
    }
    displacement_only = [m.poissons_ratio for n, m in enumerate(rod.materials) if n not in soft]
    if displacement_only:
        values[f"poissons_ratio_p{order}"] = max(displacement_only)
    return values


def _section_balance(sections: Iterable[SectionBalance], cases: Sequence[CaseResult]) -> float:
    """Largest error over the cases in the first section that passes, or the least of all.

    A section may lead through a hole, where the error of the mesh is largest; wrong loads are wrong in all.
    """
    least, loaded = np.inf, [case for case in cases if case.load.largest_force > 0]
    for section in sections:
        least = min(least, max(section.error(case.load, case.stress) for case in loaded))
        if check("section_balance", least).passed:
            break
    return least


def _balance(mesh: MeshedRod, solved: Equilibrium) -> dict[str, float]:
    responses, points = solved.responses, mesh.cell.points
    largest = max(response.largest for response in responses)
    sums = np.array([imbalance(points, response.forces, mesh.symmetry.copies) for response in responses])
    force, moment = sums.max(axis=0)
    tilts = [response.tilt for response in responses if response.tilt is not None]
    return {
        "force_balance": float(force / largest),
        "moment_balance": float(moment / (largest * mesh.bores.rod_length)),
        "reactions": max(item.reaction for item in solved.solution.residuals.values()) / largest,
        **({"tilt": max(tilts)} if tilts else {}),
    }


@dataclass(frozen=True, kw_only=True)
class SpeedResult:
    """Everything found at one speed."""

    rpm: float | None  #: none where forces are given instead of an engine
    loads: SpeedLoads  #: the load cases, with their notes
    cases: Mapping[str, CaseResult]  #: one result per load case, by its name
    checks: Mapping[str, Check]  #: by name
    notes: tuple[Note, ...]  #: what a reader must know beside the figures, and what was not computed
    cycle: CycleResult | None = None  #: the whole crank cycle, where it was asked for
    fretting: FrettingResult | None = None  #: what rubs over it, where that was asked for
    plastic: PlasticFigures | None = None  #: what yielding leads to, where something yields
    overload: OverloadFigures | None = None  #: what the single overload of the study leaves, if any
    #: ``plastic`` and ``overload``, as they were followed
    flows: Mapping[str, FollowedFlow] = field(default_factory=dict)
    defect: DefectFigures | None = None  #: over the cycle, where hardness is known or a flaw is given
    largest_defect: Floats | None = None  #: (n_nodes,) µm, that does not grow; −1: not judged
    films: tuple[FilmResult, ...] = ()  #: of the big end and of the small end, where they were asked for

    @property
    def trusted(self) -> bool:
        """Whether every check passed."""
        return all(item.passed for item in self.checks.values())

    @property
    def film(self) -> FilmResult | None:
        """The film of the big end, where films were asked for."""
        return self.films[0] if self.films else None


def speed_notes(
    rod: PreparedRod, loads: SpeedLoads, solution: StaticSolution, checks: Mapping[str, Check]
) -> tuple[Note, ...]:
    """Return what a reader must know beside the figures, and what was left out."""
    return (
        *rod.mesh.omissions,
        *_omissions(rod, solution),
        *check_notes(checks),
        *rod.study.unusual_notes(rod.mesh.bores.lengths),
        *loads.notes,
        *rod.mesh.notes,
        *_model_notes(rod),
        *rod.notes,
    )


def _omissions(rod: PreparedRod, solution: StaticSolution) -> Iterator[Note]:
    if Parity.ANTISYMMETRIC not in solution.displacement and rod.mesh.cut_y:
        yield omission("antisymmetric part about y = 0", "every load is symmetric about y = 0")
    if not rod.structure.soft and rod.mesh.cell.order > 1:
        why = f"not needed, as ν is at most {LIMITS['poissons_ratio_p2']} everywhere"
        yield omission("pressure unknowns", why)


def _model_notes(rod: PreparedRod) -> Iterator[Note]:
    for number in rod.structure.soft:
        nu = rod.materials[number].poissons_ratio
        text = f"solved with mixed displacement–pressure elements, as ν = {nu:g}"
        yield remark(text, list(rod.mesh.parts)[number])
    if rims := [f"{rim.name} ({rim.radius:.2g} mm)" for rim in rod.fields.errors.rims]:
        yield warning(f"the figures leave out the places near the {', '.join(rims)}", SINGULAR)
