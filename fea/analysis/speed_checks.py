"""The checks of one solved speed."""

from collections.abc import Iterable, Sequence

import numpy as np

from fea.analysis.prepare import PreparedRod
from fea.analysis.solve import Equilibrium
from fea.assess.case_result import CaseResult
from fea.checks import Check, check
from fea.material import Material
from fea.rod.case_forces import CaseForces, imbalance
from fea.rod.meshed_rod import MeshedRod
from fea.stress.section_balance import SectionBalance


def speed_checks(rod: PreparedRod, found: Equilibrium, cases: Sequence[CaseResult]) -> dict[str, Check]:
    """Hold mesh, loads and solution against the limits of `fea.checks`, by name.

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
