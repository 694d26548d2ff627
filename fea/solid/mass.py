"""The consistent mass matrix."""

import numpy as np

from fea.solid.assembly import SymmetricMatrix, local_pairs, pattern
from fea.solid.element import tabulate
from fea.solid.integration import VOLUME_DEGREE, gauss_blocks
from geometry.arrays import Floats
from mesh.tetmesh import TetMesh


def mass_matrix(mesh: TetMesh, density: float | Floats) -> SymmetricMatrix:
    """Assemble M_ab = ∫ρ N_a N_b dV I, degrees of freedom node-wise (u_x, u_y, u_z), t.

    Parameters
    ----------
    mesh
        The mesh.
    density
        Of every element, or (n_elements,) of each, t/mm³.
    """
    n_nodes = mesh.tets.shape[1]
    layout = pattern(mesh.tets, len(mesh.points))
    values = tabulate(n_nodes, VOLUME_DEGREE).values
    products = (values[:, :, None] * values[:, None, :]).reshape(len(values), -1)
    volumes = np.concatenate([block.volumes for _, block in gauss_blocks(mesh, VOLUME_DEGREE)])
    masses = (volumes * np.reshape(density, (-1, 1))) @ products
    masses = masses.reshape(-1, n_nodes, n_nodes)
    first, second = local_pairs(n_nodes)
    element = np.arange(len(masses))[:, None]
    ordered = masses[element, layout.node_order[:, first], layout.node_order[:, second]]
    return layout.matrix(ordered[..., None, None] * np.eye(3))
