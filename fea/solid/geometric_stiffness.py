"""The geometric stiffness: the effect of an existing stress on the stiffness against displacements."""

import numpy as np
from scipy import sparse

from fea.base.material import Constants, Material, Materials
from fea.solid.element import gauss_blocks
from geometry.arrays import Floats
from mesh.tetmesh import TetMesh

# In second-order elements both the stress and the shape-function gradients are linear.
_DEGREE = {4: 0, 10: 3}


class GeometricStiffness:
    """g_ab = ∫ ∇N_a · σ ∇N_b dV of stress fields on one mesh, N/mm: the same for u_x, u_y and u_z.

    Zienkiewicz & Taylor, The Finite Element Method for Solid and Structural Mechanics, on initial stress.
    Applied to the coordinates of the nodes it gives the forces in equilibrium with the stress.

    Parameters
    ----------
    mesh
        The mesh.
    material
        Of every element, or of each part.
    """

    def __init__(self, mesh: TetMesh, material: Material | Materials) -> None:
        self._mesh, self._material = mesh, material
        n_points, n_nodes = len(mesh.points), mesh.tets.shape[1]
        keys = (mesh.tets[:, :, None] * n_points + mesh.tets[:, None, :]).reshape(-1, n_nodes**2).ravel()
        self._order = np.argsort(keys, kind="stable")
        ordered = keys[self._order]
        self._starts = np.flatnonzero(np.r_[True, ordered[1:] != ordered[:-1]])
        rows, self._columns = np.divmod(ordered[self._starts], n_points)
        self._indptr = np.r_[0, np.cumsum(np.bincount(rows, minlength=n_points))]

    def __call__(self, displacement: Floats) -> list[sparse.csr_array]:
        """Assemble (n_nodes, n_nodes) for each displacement of (n_nodes, 3, k), mm."""
        count, n_nodes = displacement.shape[2], self._mesh.tets.shape[1]
        values = np.empty((len(self._mesh.tets), n_nodes, n_nodes, count))
        flat = displacement.reshape(len(displacement), -1)
        for part, gauss in gauss_blocks(self._mesh, _DEGREE[n_nodes]):
            n, n_gauss = gauss.volumes.shape
            gradients = gauss.gradients.swapaxes(1, 2).reshape(n, n_nodes, -1)  # (node, Gauss point × x)
            slope = gradients.swapaxes(1, 2) @ flat[self._mesh.tets[part]]
            stress = _stress(slope.reshape(n, n_gauss, 3, 3, count), self._material.of(part))
            stress *= gauss.volumes[:, :, None, None, None]
            for number in range(count):
                pushed = gauss.gradients @ np.ascontiguousarray(stress[..., number])
                values[part, ..., number] = gradients @ pushed.swapaxes(2, 3).reshape(n, -1, n_nodes)
        return [self._matrix(values[..., number]) for number in range(count)]

    def _matrix(self, values: Floats) -> sparse.csr_array:
        data = np.add.reduceat(values.ravel()[self._order], self._starts)
        return sparse.csr_array((data, self._columns, self._indptr), shape=(len(self._mesh.points),) * 2)


def _stress(slope: Floats, constants: Material | Constants) -> Floats:
    """Stress tensors (n_elements, n_points, 3, 3, k), MPa, of ∂u_j/∂x_i."""
    lam, mu = (
        np.reshape(value, (-1, 1, 1, 1, 1)) for value in (constants.lame_lambda, constants.shear_modulus)
    )
    trace = np.einsum("npiik->npk", slope)[:, :, None, None]
    return np.asarray(lam * trace * np.eye(3)[..., None] + mu * (slope + slope.swapaxes(2, 3)))
