"""A prepared rod at one speed: solve its load cases, judge the stresses, check everything."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fea.base.checks import LIMITS, Check, check
from fea.base.choices import Element
from fea.base.material import Material
from fea.base.note import Note, omission, warning
from fea.judge.case_result import CaseResult, case_result
from fea.judge.fatigue import check_notes
from fea.judge.plausible import unit_notes
from fea.pins.case_forces import CaseForces, imbalance
from fea.rod.loading import EngineLoading, SpeedLoads
from fea.rod.meshed_rod import MeshedRod
from fea.run.cycle.superposition import CycleResult
from fea.run.prepare import PreparedRod
from fea.run.solve import Equilibrium
from fea.solid.parity import Parity
from fea.solvers.static import Solution
from fea.stress.section_balance import SectionBalance
from loads.cases import assembled
from loads.instants import joined


def speed_checks(rod: PreparedRod, found: Equilibrium, cases: Sequence[CaseResult]) -> dict[str, Check]:
    """Hold mesh, loads and solution against the limits of `fea.base.checks`, by name.

    Parameters
    ----------
    rod
        The meshed rod.
    found
        What was applied, and what came out of the solver.
    cases
        The figures drawn from it.
    """
    mesh, forces, residuals = rod.mesh, found.forces, list(found.solution.residuals.values())
    quality = mesh.meshing.quality
    values = {
        "finite": float(sum(not case.finite for case in cases)),
        "inverted_elements": float(quality.least_scaled_jacobian <= 0),
        "flattest_element": 1 / max(quality.least_shape, 1e-300),
        "mesh_mass_p1" if mesh.cell.order == 1 else "mesh_mass": mesh.mass_error(
            rod.mass.mass, rod.materials
        ),
        "small_strain": max(_strain(case, rod.materials) for case in cases),
        "small_displacement": max(case.max_displacement for case in cases) / mesh.bores.rod_length,
        "bore_pressure_scale": max(abs(case.scale - 1) for case in forces),
        "backward_error": max(item.backward_error for item in residuals),
        "energy_balance": max(item.energy for item in residuals),
        "imbalance": max(item.imbalance for item in residuals),
        "section_balance": _section_balance(rod.mid_sections, cases),
    }
    if found.solution.condition:
        values["condition"] = max(found.solution.condition.values())
    displacement_only = [n for n in range(len(rod.materials)) if n not in rod.soft]
    if displacement_only:
        values[f"poissons_ratio_{rod.element}"] = max(
            rod.materials[part].poissons_ratio for part in displacement_only
        )
    if not rod.clamped:  # a clamp takes up forces, so that they need not balance
        largest = max(case.largest for case in forces)
        values |= _balance(mesh, forces, largest)
        tilts = [case.tilt for case in forces if case.tilt is not None]
        if tilts:
            values["tilt"] = max(tilts)
        values["reactions"] = max(item.reaction for item in residuals) / largest
    for name in sorted({name for case in forces for name in case.checks}):
        values[name] = max(case.checks[name] for case in forces)
    return {name: check(name, value) for name, value in values.items()}


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


def _strain(case: CaseResult, materials: Sequence[Material]) -> float:
    """Largest equivalent strain of any part, von Mises stress over 3 μ."""
    parts = zip(case.part_von_mises, materials, strict=True)
    return max(float(np.nanmax(stress)) / (3 * material.shear_modulus) for stress, material in parts)


def _balance(mesh: MeshedRod, forces: Sequence[CaseForces], largest: float) -> dict[str, float]:
    sums = np.array([imbalance(mesh.cell.points, case.forces, mesh.symmetry.copies) for case in forces])
    force, moment = sums.max(axis=0)
    return {
        "force_balance": float(force / largest),
        "moment_balance": float(moment / (largest * mesh.bores.rod_length)),
    }


@dataclass(frozen=True, kw_only=True)
class SpeedResult:
    """Everything found at one speed.

    Attributes
    ----------
    rpm
        None where forces are given instead of an engine.
    loads
        The load cases, with their notes.
    cases
        One result per load case, by its name.
    checks
        By name.
    notes
        What a reader must know beside the figures, and what was not computed.
    cycle
        The whole crank cycle, where it was asked for.
    """

    rpm: float | None
    loads: SpeedLoads
    cases: Mapping[str, CaseResult]
    checks: Mapping[str, Check]
    notes: tuple[Note, ...]
    cycle: CycleResult | None = None

    @property
    def trusted(self) -> bool:
        """Whether every check passed."""
        return all(item.passed for item in self.checks.values())


def solve_speed(rod: PreparedRod, rpm: float | None) -> SpeedResult:
    """Solve, judge and check the load cases of one speed.

    Parameters
    ----------
    rod
        Ready to be solved.
    rpm
        The speed; None for given forces.

    Raises
    ------
    InvalidValue
        Nothing loads the rod.
    UnderconstrainedError, SingularMatrixError
        See `Model.solve`.
    """
    with rod.clock("loads"):
        loads = rod.loading.at(rod.mass, rpm)
    if rod.putting is not None:
        loads = replace(loads, cases=joined([loads.cases, assembled()]))
    found = rod.pins.equilibrium(loads.cases)
    with rod.clock("stress"):
        cases = judge(rod, found)
    checks = speed_checks(rod, found, tuple(cases.values()))
    engine = rod.loading.engine if isinstance(rod.loading, EngineLoading) else None
    notes = (
        *rod.mesh.omissions,
        *_solution_omissions(rod, found.solution),
        *check_notes(checks),
        *unit_notes(rod.materials, engine),
        *loads.notes,
        *rod.mesh.notes,
        *_pressure_notes(rod),
        *_rim_notes(rod),
        *rod.notes,
    )
    return SpeedResult(
        rpm=rpm,
        loads=loads,
        cases=cases,
        checks=checks,
        notes=notes,
    )


def with_cycle(rod: PreparedRod, static: SpeedResult) -> SpeedResult:
    """Work out the whole crank cycle at a speed whose load cases are solved."""
    analysis, cycle = rod.cycle, rod.crank_cycle(static.rpm or 0.0)
    with rod.clock("cycle"):
        history = analysis.at(cycle, tuple(static.cases.values()))
    checks, notes = {**static.checks, **history.checks()}, (*static.notes, *history.notes())
    return replace(static, checks=checks, notes=notes, cycle=history)


def judge(rod: PreparedRod, found: Equilibrium) -> dict[str, CaseResult]:
    """Recover the stresses of load cases in equilibrium and judge them, by the name of the case."""
    return {
        case.name: case_result(
            case,
            rod.mesh.whole,
            fields,
            stresses,
            materials=rod.materials,
            made=rod.made,
            sharp=rod.sharp_places,
        )
        for case, (fields, stresses) in zip(found.cases, rod.fields(found), strict=True)
    }


def _solution_omissions(rod: PreparedRod, solution: Solution) -> tuple[Note, ...]:
    """What the loads and the materials spare."""
    spared = []
    if Parity.ANTISYMMETRIC not in solution.displacement and rod.mesh.cut_y:
        spared.append(omission("antisymmetric part about y = 0", "every load is symmetric about y = 0"))
    if not rod.soft and rod.element is Element.P2:
        why = f"ν is at most {LIMITS['poissons_ratio_p2']} everywhere"
        spared.append(omission("pressure unknowns", why))
    return tuple(spared)


def _rim_notes(rod: PreparedRod) -> list[Note]:
    """Where the stress of parts that touch is left out."""
    places = [f"{rim.name} ({rim.radius:.2g} mm)" for rim in rod.fields.errors.rims]
    text = f"the figures leave out the places near the {', '.join(places)}"
    return [warning(text, "stress")] if places else []


def _pressure_notes(rod: PreparedRod) -> list[Note]:
    names = list(rod.mesh.parts)
    return [
        warning(
            f"solved with mixed displacement–pressure elements, as ν = {rod.materials[n].poissons_ratio:g}",
            names[n],
        )
        for n in rod.soft
    ]
