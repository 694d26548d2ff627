"""True errors in the energy norm by Galerkin's orthogonality on nested meshes."""

from dataclasses import dataclass, replace

import numpy as np

from fea.solid.element import shape_functions
from fea.solid.error_estimate import ErrorEstimator
from fea.solid.recovery import reference_nodes
from fea.verify.body import SolvedBody
from fea.verify.cases import dynamics, nafems
from geometry.surfaces import Surface
from mesh.tetmesh import EDGES, TetMesh, raised, refined, split


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
PROBLEMS = {
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
    meshed, solved, start = PROBLEMS[name]
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
