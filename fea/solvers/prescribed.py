"""Displacements with arbitrary supports, including prescribed non-zero displacements."""

import numpy as np

from fea.material import Material
from fea.solid.assembly import pattern, stiffness
from fea.solid.supports import require_restrained
from fea.solvers.linear.choice import factorise
from geometry.arrays import Floats, Mask
from mesh.tetmesh import TetMesh


def displacement(
    mesh: TetMesh,
    material: Material,
    forces: Floats,
    fixed: Mask,
    moved: Floats | None = None,
) -> Floats:
    """Solve K u = f with some displacements prescribed.

    Parameters
    ----------
    mesh
        The mesh.
    material
        Of every element.
    forces
        (n_nodes, 3), N.
    fixed
        (n_nodes, 3) whether a displacement is given.
    moved
        (n_nodes, 3) the given displacements, mm; zero by default. Other entries are ignored.

    Returns
    -------
    ndarray
        (n_nodes, 3, 1), mm.

    Raises
    ------
    UnderconstrainedError
        The supports leave a rigid motion free.
    SingularMatrixError
        The factorisation broke down.
    """
    require_restrained(mesh, fixed)
    K = stiffness(mesh, material, pattern(mesh.tets, len(mesh.points)))
    held = fixed.ravel()
    u = np.zeros(held.size) if moved is None else np.where(held, moved.ravel(), 0.0)
    right = np.where(held, 0.0, forces.ravel() - K @ u)
    u += np.where(held, 0.0, factorise(K.constrained(held)).solve(right[:, None])[:, 0])
    return np.asarray(u.reshape(-1, 3, 1))
