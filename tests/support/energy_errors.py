"""True errors in the energy norm, and how the estimate compares (its effectivity).

They are those of exact solutions, or follow from Galerkin's orthogonality on nested meshes.
"""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from fea.analysis.pipeline import prepare, solve_speed
from fea.base.material import Material
from fea.solid.assembly import gauss_block, reference_nodes, shape_functions, tabulate
from fea.solid.error_estimate import ErrorEstimator
from fea.solid.recovery import ElementStress, Recovery
from fea.study.flags import Flags
from fea.study.study import load_study
from fea.verify.body import STEEL, SolvedBody
from fea.verify.cases import dynamics, nafems
from fea.verify.cases.elasticity import manufactured_gradient, manufactured_solution
from geometry.bodies import block
from geometry.surfaces import Surface
from mesh.generate import mesh_body
from mesh.tetmesh import EDGES, TetMesh, raised, refined, split


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


def nested(mesh: TetMesh) -> TetMesh:
    """Make eight elements of each, on the very geometry of the mesh, so that its displacements remain some.

    `refined` puts new nodes amid straight edges; here they lie where the element they come from has them.
    """
    if mesh.order == 1:
        return refined(mesh)
    fine = raised(split(mesh))
    local = np.empty_like(fine.tets[:, :4])
    parents = mesh.tets[np.arange(len(fine.tets)) // 8]
    for place in range(4):
        local[:, place] = (parents == fine.tets[:, place, None]).argmax(axis=1)
    reference = reference_nodes(10)
    points = fine.points.copy()
    for number, (a, b) in enumerate(EDGES):
        amid = (reference[local[:, a]] + reference[local[:, b]]) / 2
        values, _ = shape_functions(10, amid.T)
        points[fine.tets[:, 4 + number]] = np.einsum("en,enk->ek", values, mesh.points[parents])
    return TetMesh(points, fine.tets, fine.facets)


def _held_all_over(mesh: TetMesh) -> SolvedBody:
    """LE10 with its outer face held in z as well."""
    body = nafems.le10_body(mesh)
    fixed = body.fixed.copy()
    fixed[np.unique(mesh.facets[Surface.OUTER]), 2] = True
    return replace(body, fixed=fixed).solved()


# Mesh and solution of each problem, and the element size to start from, mm.
NESTED = {
    "NAFEMS LE1": (nafems.le1_mesh, lambda mesh: nafems.le1_body(mesh).solved(), 500.0),
    "NAFEMS LE10": (nafems.le10_mesh, lambda mesh: nafems.le10_body(mesh).solved(), 500.0),
    "NAFEMS LE10, held all over": (nafems.le10_mesh, _held_all_over, 500.0),
    "NAFEMS LE11": (nafems.le11_mesh, lambda mesh: nafems.le11_body(mesh).solved(), 400.0),
    "Cook": (nafems.cook_mesh, lambda mesh: nafems.cook_body(mesh).solved(), 12.0),
    "plate with a hole": (nafems.plate_mesh, lambda m: nafems.plate_body(m).solved(), 3.0),
    "rotating disc": (dynamics.disc_mesh, dynamics.spun_disc, 20.0),
}


@dataclass(frozen=True)
class Nest:
    """Energies of a problem on nested meshes.

    Attributes
    ----------
    dofs
        Of each mesh.
    energy
        Square of the energy norm of each solution, N·mm.
    estimated
        Of its estimated error.
    """

    dofs: tuple[int, ...]
    energy: np.ndarray
    estimated: np.ndarray

    @property
    def rate(self) -> float:
        """Exponent of the element size in the energy norm of the error, of the last three meshes."""
        first, second = np.diff(self.energy[-3:])
        return float(np.log2(first / second) / 2)

    @property
    def limit(self) -> float:
        """The energy extrapolated (Richardson, with the rate found)."""
        first, second = np.diff(self.energy[-3:])
        return float(self.energy[-1] + second / (first / second - 1))

    def effectivity(self) -> np.ndarray:
        """Estimated over true error on each mesh: the energy of the error is what the solution's lacks."""
        return np.sqrt(self.estimated / (self.limit - self.energy))


def nest(name: str, order: int = 2, levels: int = 3, size: float | None = None) -> Nest:
    """Solve a problem on a mesh and on what `nested` makes of it."""
    meshed, solved, start = NESTED[name]
    mesh = meshed(start if size is None else size)
    if order == 1:
        mesh = split(mesh)
    found = []
    for level in range(levels):
        mesh = nested(mesh) if level else mesh
        body: SolvedBody = solved(mesh)
        estimate = ErrorEstimator(mesh, (body.material,))(body.displacement, [body.stress[:, :, None]])
        found.append((body.dofs, estimate.solution.sum(), estimate.energy.sum()))
    dofs, energy, estimated = zip(*found, strict=True)
    return Nest(dofs, np.array(energy), np.array(estimated))
