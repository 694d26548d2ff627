"""The consistent mass matrix."""

import numpy as np
import numpy.typing as npt
from scipy import sparse

from fea.solid.assembly import SymmetricMatrix
from fea.solid.element import tabulate
from fea.solid.integration import VOLUME_DEGREE, gauss_blocks
from mesh.tetmesh import TetMesh

Floats = npt.NDArray[np.float64]


def mass_matrix(mesh: TetMesh, density: float | Floats) -> SymmetricMatrix:
    """Assemble M_ab = ∫ρ N_a N_b dV I, degrees of freedom node-wise (u_x, u_y, u_z), t.

    Parameters
    ----------
    mesh
        The mesh.
    density
        Of every element, or (n_elements,) of each, t/mm³.
    """
    n_nodes, n_points = mesh.tets.shape[1], len(mesh.points)
    values = tabulate(n_nodes, VOLUME_DEGREE).values
    products = (values[:, :, None] * values[:, None, :]).reshape(len(values), -1)
    volumes = np.concatenate([block.volumes for _, block in gauss_blocks(mesh, VOLUME_DEGREE)])
    blocks = (volumes * np.reshape(density, (-1, 1))) @ products
    rows = np.repeat(mesh.tets, n_nodes, axis=1).ravel()
    columns = np.tile(mesh.tets, (1, n_nodes)).ravel()
    scalar = sparse.coo_array((blocks.ravel(), (rows, columns)), shape=(n_points, n_points)).tocsr()
    upper = sparse.triu(sparse.kron(scalar, sparse.eye_array(3)), format="csr")
    return SymmetricMatrix(sparse.csr_array(upper))
