"""The isotropic operator on Gauss points: stiffness and stress."""

import numpy as np

from fea.material import Constants, Material
from fea.solid.integration import GaussBlock
from geometry.arrays import Floats, Ints

# Components of a symmetric tensor in VTK's order: XX YY ZZ XY YZ XZ.
COMPONENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def node_pair_blocks(gauss: GaussBlock, material: Material | Constants, pairs: tuple[Ints, Ints]) -> Floats:
    """3×3 stiffness blocks of the node pairs (a, b) of each element.

    K_ab = ∫ λ ∇N_a ⊗ ∇N_b + μ ∇N_b ⊗ ∇N_a + μ (∇N_a · ∇N_b) I dV; every product ∇N_a ⊗ ∇N_b of an
    element comes from one matrix product over its Gauss points.

    Parameters
    ----------
    gauss
        Gradients and volumes of the elements.
    material
        Gives λ and μ.
    pairs
        Local node numbers a and b, each (n_pairs,).

    Returns
    -------
    ndarray
        (n_elements, n_pairs, 3, 3), N/mm.
    """
    n_elements, n_points, n_nodes, _ = gauss.gradients.shape
    flat = gauss.gradients.reshape(n_elements, n_points, 3 * n_nodes)
    weighted = flat * gauss.volumes[:, :, None]
    products = (weighted.transpose(0, 2, 1) @ flat).reshape(n_elements, n_nodes, 3, n_nodes, 3)
    outer = products.transpose(0, 1, 3, 2, 4)[:, pairs[0], pairs[1]]
    lam, mu = (np.reshape(value, (-1, 1, 1, 1)) for value in (material.lame_lambda, material.shear_modulus))
    stiffness = lam * outer + mu * outer.swapaxes(-1, -2)
    trace = mu[..., 0, 0] * (outer[..., 0, 0] + outer[..., 1, 1] + outer[..., 2, 2])
    for i in range(3):
        stiffness[..., i, i] += trace
    return stiffness


def stress_from_gradient(gradient: Floats, material: Material) -> Floats:
    """Stress λ tr ε I + 2 μ ε, (…, 6) in the order of `COMPONENTS`, of gradients ∂u_i/∂x_j (…, 3, 3)."""
    lam, mu = material.lame_lambda, material.shear_modulus
    pressure = lam * (gradient[..., 0, 0] + gradient[..., 1, 1] + gradient[..., 2, 2])
    stress = np.stack([mu * (gradient[..., i, j] + gradient[..., j, i]) for i, j in COMPONENTS], axis=-1)
    stress[..., :3] += pressure[..., None]
    return stress
