"""Solve K u = f on a body that is held on average only: mean motions of surfaces vanish."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.linalg import qr

from fea.choices import SolverName
from fea.solid.assembly import SymmetricMatrix
from fea.solid.errors import UnderconstrainedError
from fea.solid.parity import Parity
from fea.solid.pins import Held, has_parity, mean_motions, motions
from fea.solid.supports import plane_conditions
from fea.solvers.solvers import Factor, factorise
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Constrained:
    """The body of one parity about each mirror plane, C u = 0.

    With the rigid motions R that the planes leave, u = K_c⁻¹(f − Cᵀμ) + R q, where K_c holds a few degrees
    of freedom that stop R, Rᵀ(f − Cᵀμ) = 0 and C u = 0 (Farhat & Roux 1991).

    Attributes
    ----------
    factor
        Of K_c.
    fixed
        (n,) degrees of freedom that the mirror planes or K_c hold.
    rigid
        R (n, n_rigid).
    rows
        C (n_rows, n).
    answers
        K_c⁻¹Cᵀ (n, n_rows).
    inverse
        Of the small system for μ and q.
    """

    factor: Factor
    fixed: Mask
    rigid: Floats
    rows: Floats
    answers: Floats
    inverse: Floats

    def solve(self, forces: Floats) -> Floats:
        """Displacement (n,) under forces (n,); what they lack in balance, the constraints give."""
        u = _solved(self.factor, self.fixed, forces[:, None])[:, 0]
        found = self.inverse @ np.concatenate([self.rows @ u, self.rigid.T @ forces])
        n_rows = len(self.rows)
        return np.asarray(u - self.answers @ found[:n_rows] + self.rigid @ found[n_rows:])


def constrained(
    mesh: TetMesh,
    K: SymmetricMatrix,
    held: tuple[Held, ...],
    parities: tuple[Parity, Parity],
    choice: SolverName,
) -> Constrained:
    """Factorise the body held by its surfaces for fields of given parities about y = 0 and z = 0.

    Raises
    ------
    UnderconstrainedError
        The surfaces leave a rigid motion.
    SingularMatrixError
        The factorisation broke down.
    """
    planes = plane_conditions(mesh, *parities).ravel()
    own = _own(mesh, parities)
    rigid = motions(mesh.points, mesh.points[:, 0].mean())[own].reshape(len(own), -1).T
    rows = [
        mean_motions(mesh, end.surface, end.center)[motion].ravel()
        for end in held
        for motion in end.motions
        if motion in own
    ]
    C = np.stack(rows) if rows else np.zeros((0, len(planes)))
    if np.linalg.matrix_rank(C @ rigid) < rigid.shape[1]:
        raise UnderconstrainedError("the ends that are held leave the body free to move")
    fixed = planes | _stopping(np.where(planes[:, None], 0.0, rigid))
    factor = factorise(K.constrained(fixed), choice)
    answers = _solved(factor, fixed, C.T)
    small = np.block([[C @ answers, -C @ rigid], [rigid.T @ C.T, np.zeros((rigid.shape[1],) * 2)]])
    return Constrained(factor, fixed, rigid, C, answers, np.linalg.inv(small))


def _own(mesh: TetMesh, parities: tuple[Parity, Parity]) -> list[int]:
    """Rigid motions of the parities, on the planes the mesh is cut at."""
    y = parities[0] if Surface.SYMMETRY_Y in mesh.facets else None
    z = parities[1] if Surface.SYMMETRY_Z in mesh.facets else None
    return [motion for motion in range(6) if has_parity(motion, y, z)]


def _stopping(rigid: Floats) -> Mask:
    """As many degrees of freedom as there are rigid motions, far enough apart to stop them all."""
    scaled = rigid / np.abs(rigid).max(axis=0, initial=1e-300)
    _, _, order = qr(scaled.T, mode="economic", pivoting=True)
    stopped = np.zeros(len(rigid), dtype=bool)
    stopped[order[: rigid.shape[1]]] = True
    return stopped


def _solved(factor: Factor, fixed: Mask, forces: Floats) -> Floats:
    if not forces.shape[1]:
        return forces
    u = factor.solve(np.where(fixed[:, None], 0.0, forces))
    u[fixed] = 0.0
    return u
