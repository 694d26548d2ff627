"""The stiffness a stress lends to displacements across it."""

import numpy as np
import numpy.typing as npt
from scipy import sparse

from fea.material import Constants, Material, Materials
from fea.solid.element import tabulate
from fea.solid.integration import blocks, gauss_block
from mesh.tetmesh import TetMesh

Floats = npt.NDArray[np.float64]

# The stress of second-order elements is linear, and their gradients are.
_DEGREE = {4: 0, 10: 3}


def geometric_stiffness(
    mesh: TetMesh, material: Material | Materials, displacement: Floats
) -> sparse.csr_array:
    """Assemble g_ab = ∫ ∇N_a · σ ∇N_b dV, (n_nodes, n_nodes), N/mm: the same for u_x, u_y and u_z.

    Zienkiewicz & Taylor, The Finite Element Method for Solid and Structural Mechanics, on initial stress.
    Applied to the nodes' places it gives the forces that the stress balances.

    Parameters
    ----------
    mesh
        The mesh.
    material
        Of every element, or of each part.
    displacement
        (n_nodes, 3), mm, that the stress at the Gauss points comes from.
    """
    n_points, n_nodes = len(mesh.points), mesh.tets.shape[1]
    table = tabulate(n_nodes, _DEGREE[n_nodes])
    values = np.empty((len(mesh.tets), n_nodes, n_nodes))
    for part in blocks(len(mesh.tets)):
        gauss = gauss_block(mesh.points[mesh.tets[part]], table)
        stress = _stress(gauss.gradients, displacement[mesh.tets[part]], material.of(part))
        weighted = gauss.gradients @ (stress * gauss.volumes[:, :, None, None])
        values[part] = (weighted @ gauss.gradients.swapaxes(-1, -2)).sum(axis=1)
    rows = np.repeat(mesh.tets, n_nodes, axis=1).ravel()
    columns = np.tile(mesh.tets, (1, n_nodes)).ravel()
    return sparse.coo_array((values.ravel(), (rows, columns)), shape=(n_points, n_points)).tocsr()


def _stress(gradients: Floats, displacement: Floats, constants: Material | Constants) -> Floats:
    """Stress tensors (n_elements, n_points, 3, 3), MPa."""
    slope = displacement.swapaxes(-1, -2)[:, None] @ gradients
    lam, mu = (np.reshape(value, (-1, 1, 1, 1)) for value in (constants.lame_lambda, constants.shear_modulus))
    trace = np.trace(slope, axis1=-2, axis2=-1)[..., None, None]
    return np.asarray(lam * trace * np.eye(3) + mu * (slope + slope.swapaxes(-1, -2)))
