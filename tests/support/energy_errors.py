"""True errors in the energy norm, and how the estimate compares (its effectivity)."""

from functools import cache

import numpy as np

from fea.analysis.pipeline import prepare, solve_speed
from fea.base.material import Material
from fea.solid.element import gauss_block, tabulate
from fea.solid.error_estimate import ErrorEstimator
from fea.solid.recovery import ElementStress, Recovery, reference_nodes
from fea.study.flags import Flags
from fea.study.study import load_study
from fea.verify.body import STEEL
from fea.verify.cases.elasticity import manufactured_gradient, manufactured_solution
from geometry.bodies import block
from mesh.generate import mesh_body
from mesh.tetmesh import TetMesh, refined


def energy(stress, volumes, material: Material) -> float:
    """∫ σ : C⁻¹ σ of stress (n_elements, n_places, 6)."""
    trace = stress[..., :3].sum(axis=-1)
    square = (stress[..., :3] ** 2).sum(axis=-1) + 2 * (stress[..., 3:] ** 2).sum(axis=-1)
    E, nu = material.youngs_modulus, material.poissons_ratio
    return float((volumes * ((1 + nu) * square - nu * trace**2) / E).sum())


def effectivity(mesh: TetMesh, u, stress, exact, material: Material) -> float:
    """Estimated over true error in the energy norm."""
    table = tabulate(mesh.tets.shape[1], 4)
    places = (table.values @ mesh.points[mesh.tets]).reshape(-1, 3)
    raw = ElementStress(mesh, table.values @ reference_nodes(mesh.tets.shape[1]))(u, material)[..., 0]
    volumes = gauss_block(mesh.points[mesh.tets], table).volumes
    true = energy(raw - exact(places).reshape(raw.shape), volumes, material)
    return np.sqrt(ErrorEstimator(mesh, (material,))(u, [stress]).energy.sum() / true)


def manufactured_effectivity(size: float, order: int) -> float:
    """Of a sum of plane waves on a cube of side 1."""
    mesh = refined(mesh_body(block(1.0, 1.0, 1.0), size, order=order))
    u = manufactured_solution(mesh)[:, :, None]
    stress = Recovery(mesh).nodal_stress(u, STEEL)

    def exact(places):
        slope = manufactured_gradient(places)
        strain = (slope + slope.transpose(0, 2, 1)) / 2
        lam, mu = STEEL.lame_lambda, STEEL.shear_modulus
        tensor = 2 * mu * strain + lam * np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        return tensor.reshape(-1, 9)[:, [0, 4, 8, 1, 5, 2]]

    return effectivity(mesh, u, stress, exact, STEEL)


@cache
def rod(size: float):
    """Mesh, material and tension of the rod, whose load is the same on every mesh."""
    study = Flags(size=size, pressure="cosine-180").applied(load_study())
    analysis = prepare(study)
    (case,) = (case for case in solve_speed(analysis, 6000.0).cases.values() if case.load.name == "tension")
    return analysis.mesh.whole, analysis.materials[0], case


def strain_energy(size: float) -> float:
    """∫ σ : C⁻¹ σ of the finite-element stress of the whole rod."""
    mesh, material, case = rod(size)
    table = tabulate(10, 2)
    volumes = gauss_block(mesh.points[mesh.tets], table).volumes
    return energy(ElementStress(mesh)(case.displacement[:, :, None], material)[..., 0], volumes, material)


def rod_effectivity(size: float, finer: float) -> tuple[float, float]:
    """Least and largest effectivity at one size, as far as a finer mesh tells.

    Galerkin: the error's energy is what the solution's lacks, here of the finer mesh's with its own error.
    """
    missing = (rod(finer)[2].error.energy_percent / 100) ** 2
    lacking = 1 - strain_energy(size) / strain_energy(finer)
    estimated = rod(size)[2].error.energy_percent / 100
    return estimated / np.sqrt(lacking + missing), estimated / np.sqrt(lacking)
