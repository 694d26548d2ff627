"""Solve K u = f on a body whose only constraints are that mean motions of surfaces are zero."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr

from fea.base.material import Material
from fea.solid.assembly import pattern, stiffness
from fea.solid.bore_motion import ConstrainedSurface, mean_motions, motions_with
from fea.solid.errors import UnderconstrainedError
from fea.solid.parity import Parity
from fea.solid.supports import components, plane_conditions, require_restrained, rigid_motions
from fea.solvers.direct import factorise
from fea.solvers.linear_solver import Operator
from geometry.arrays import Floats, Mask
from mesh.tetmesh import TetMesh


@dataclass(frozen=True)
class Constrained:
    """The body of one parity about each mirror plane, C u = 0.

    With the rigid motions R that the planes leave, u = K_c⁻¹(f − Cᵀμ) + R q, where K_c holds a few degrees
    of freedom that stop R, Rᵀ(f − Cᵀμ) = 0 and C u = 0 (Farhat & Roux 1991).
    """

    inverse: Operator  #: K_c⁻¹ times (n, k) forces that are zero at the fixed degrees of freedom of K_c
    fixed: Mask  #: (n,) degrees of freedom that the mirror planes or K_c hold
    rigid: Floats  #: R (n, n_rigid)
    rows: Floats  #: C (n_rows, n)
    answers: Floats  #: K_c⁻¹Cᵀ (n, n_rows)
    small: Floats  #: inverse of the matrix that gives μ and q

    def solve(self, forces: Floats) -> Floats:
        """Displacements (n, k) under forces (n, k); the constraints react forces that are not balanced."""
        u = _solved(self.inverse, self.fixed, forces)
        unknowns = self.small @ np.concatenate([self.rows @ u, self.rigid.T @ forces])
        n_rows = len(self.rows)
        return np.asarray(u - self.answers @ unknowns[:n_rows] + self.rigid @ unknowns[n_rows:])


def constrained(
    mesh: TetMesh,
    surfaces: tuple[ConstrainedSurface, ...],
    parities: tuple[Parity, Parity],
    fixed: Mask,
    inverse: Operator,
) -> Constrained:
    """Constrain the mean motions of surfaces of a body, for given parities about y = 0 and z = 0.

    `fixed` (n,) are the degrees of freedom of the planes, and one per rigid motion (`stopping`), with which
    `inverse` is K_c⁻¹. Raises `UnderconstrainedError`: the surfaces leave a rigid motion free.
    """
    rigid, free = _rigid(mesh, parities), motions_with(mesh, *parities)
    held = [(end, motion) for end in surfaces for motion in end.motions if motion in free]
    rows = [mean_motions(mesh, end.surface, end.center)[motion].ravel() for end, motion in held]
    C = np.stack(rows) if rows else np.zeros((0, mesh.points.size))
    if np.linalg.matrix_rank(C @ rigid) < rigid.shape[1]:
        raise UnderconstrainedError(
            "the constraints at the two ends leave a rigid motion of the body free. Constrain more motions"
        )
    answers = _solved(inverse, fixed, C.T)
    small = np.block([[C @ answers, -C @ rigid], [rigid.T @ C.T, np.zeros((rigid.shape[1],) * 2)]])
    return Constrained(inverse, fixed, rigid, C, answers, np.linalg.inv(small))


def stopping(mesh: TetMesh, parities: tuple[Parity, Parity]) -> Mask:
    """Degrees of freedom (n,) that the mirror planes fix, and one more for each free rigid motion of a piece.

    The cell is of one piece or of several that are not connected; the parities are about y = 0 and z = 0.
    """
    planes = plane_conditions(mesh, *parities).ravel()
    # On an interface, restraints at the same place on both sides would stop the forces between them.
    touching = [mesh.facets[side].ravel() for sides in mesh.interfaces for side in sides]
    held = planes | np.repeat(np.isin(np.arange(len(mesh.points)), np.concatenate([*touching, []])), 3)
    rigid, piece = np.where(held[:, None], 0.0, _rigid(mesh, parities)), np.repeat(components(mesh), 3)
    for number in range(int(piece.max()) + 1):
        of_piece = np.where((piece == number)[:, None], rigid, 0.0)
        # Pivoting chooses degrees of freedom that are far apart.
        scaled = of_piece / np.abs(of_piece).max(axis=0, initial=1e-300)
        _, _, order = qr(scaled.T, mode="economic", pivoting=True)
        planes[order[: rigid.shape[1]]] = True
    return planes


def _rigid(mesh: TetMesh, parities: tuple[Parity, Parity]) -> Floats:
    """Rigid motions (n, n_rigid) that have the parities."""
    motions = rigid_motions(mesh.points, mesh.points.mean(axis=0) * [1.0, 0.0, 0.0])
    return motions[motions_with(mesh, *parities)].reshape(-1, mesh.points.size).T


def _solved(inverse: Operator, fixed: Mask, forces: Floats) -> Floats:
    if not forces.shape[1]:
        return forces
    u = inverse(np.where(fixed[:, None], 0.0, forces))
    u[fixed] = 0.0
    return u


def displacement(
    mesh: TetMesh, material: Material, forces: Floats, fixed: Mask, moved: Floats | None = None
) -> Floats:
    """Solve K u = f (n_nodes, 3, 1), mm, for forces (n_nodes, 3), N, with some displacements prescribed.

    Where `fixed` (n_nodes, 3), the displacement is that of `moved` (n_nodes, 3), mm; zero by default. Raises
    `UnderconstrainedError`: the supports leave a rigid motion free; `SingularMatrixError`: the factorisation
    broke down.
    """
    require_restrained(mesh, fixed)
    K = stiffness(mesh, material, pattern(mesh.tets, len(mesh.points)))
    held = fixed.ravel()
    u = np.zeros(held.size) if moved is None else np.where(held, moved.ravel(), 0.0)
    right = np.where(held, 0.0, forces.ravel() - K @ u)
    u += np.where(held, 0.0, factorise(K.constrained(held))(right[:, None])[:, 0])
    return np.asarray(u.reshape(-1, 3, 1))
