"""The checks of one solved speed."""

from collections.abc import Iterable, Sequence

import numpy as np

from fea.assess.case_result import CaseResult
from fea.checks import Check, check
from fea.choices import Element
from fea.material import Material
from fea.rod.case_forces import CaseForces, imbalance
from fea.rod.discretise import Discretised
from fea.solvers.static import Solution
from fea.stress.section_balance import SectionBalance


def run_checks(
    mesh: Discretised,
    materials: tuple[Material, ...],
    forces: Sequence[CaseForces],
    solution: Solution,
    cases: Sequence[CaseResult],
    *,
    mass: float,
    sections: Iterable[SectionBalance],
    displacement_only: Sequence[int],
    held: bool,
) -> dict[str, Check]:
    """Hold mesh, loads and solution against the limits of `fea.checks`, by name.

    Parameters
    ----------
    mesh
        Of the rod.
    materials
        One a part.
    forces, solution, cases
        What was applied, what came out of the solver, and the figures drawn from it.
    mass
        Of the rod as meshed, t.
    sections
        Across the shank. Only where the first fails the others are asked: it may lead through a hole, where
        the error of the mesh is largest, and loads that are wrong are wrong in all.
    displacement_only
        Numbers of the parts without a pressure of their own.
    held
        Whether a clamp takes up forces, so that they need not balance.
    """
    residuals = list(solution.residuals.values())
    first_order = mesh.cell.order == 1
    values = {
        "finite": float(sum(not case.finite for case in cases)),
        "inverted_elements": float(mesh.quality.least_scaled_jacobian <= 0),
        "flattest_element": 1 / max(mesh.quality.least_shape, 1e-300),
        "mesh_mass_p1" if first_order else "mesh_mass": mesh.mass_error(mass, materials),
        "small_strain": max(_strain(case, materials) for case in cases),
        "small_displacement": max(case.displacement_size for case in cases) / mesh.bores.rod_length,
        "bore_pressure_scale": max(abs(case.scale - 1) for case in forces),
        "backward_error": max(item.backward_error for item in residuals),
        "energy_balance": max(item.energy for item in residuals),
        "imbalance": max(item.imbalance for item in residuals),
        "section_balance": _section_balance(sections, cases),
    }
    if solution.condition:
        values["condition"] = max(solution.condition.values())
    if displacement_only:
        element = Element.P1 if first_order else Element.P2
        values[f"poissons_ratio_{element}"] = max(
            materials[part].poissons_ratio for part in displacement_only
        )
    if not held:
        largest = max(case.largest for case in forces)
        values |= _balance(mesh, forces, largest)
        tilts = [case.tilt for case in forces if case.tilt is not None]
        if tilts:
            values["tilt"] = max(tilts)
        values["reactions"] = max(item.reaction for item in residuals) / largest
    return {name: check(name, value) for name, value in values.items()}


def _section_balance(sections: Iterable[SectionBalance], cases: Sequence[CaseResult]) -> float:
    """Largest error over the cases in the first section that passes, or the least of all."""
    least = np.inf
    for section in sections:
        least = min(least, max(section.error(case.case, case.stress) for case in cases))
        if check("section_balance", least).passed:
            break
    return least


def _strain(case: CaseResult, materials: Sequence[Material]) -> float:
    """Largest equivalent strain of any part, von Mises stress over 3 μ."""
    parts = zip(case.part_von_mises, materials, strict=True)
    return max(float(np.nanmax(stress)) / (3 * material.shear_modulus) for stress, material in parts)


def _balance(mesh: Discretised, forces: Sequence[CaseForces], largest: float) -> dict[str, float]:
    sums = np.array([imbalance(mesh.cell.points, case.forces, mesh.symmetry.copies) for case in forces])
    force, moment = sums.max(axis=0)
    return {
        "force_balance": float(force / largest),
        "moment_balance": float(moment / (largest * mesh.bores.rod_length)),
    }
