"""Thermal strain as a right-hand side.

With the thermal strain α ΔT I the stress is σ = C : ε − β ΔT I, β = (3λ + 2μ) α. So C : ε, the stress of
the total strain, is that of an isothermal body under additional forces ∫ β ΔT ∇N_a dV, which are a body
force −β ∇T and a traction β ΔT n (Duhamel 1837; Boley & Weiner 1960, chapter 3). It is recovered
with that traction, and β ΔT I is subtracted at the nodes.
"""

from collections.abc import Callable

import numpy as np

from fea.material import Material
from fea.solid.element import tabulate
from fea.solid.integration import VOLUME_DEGREE, gauss_blocks
from fea.solid.traction import scattered
from geometry.arrays import Floats
from mesh.tetmesh import TetMesh


def thermal_modulus(material: Material, expansion: float) -> float:
    """Return β = (3λ + 2μ) α, MPa/K, for an expansion coefficient α in 1/K."""
    return (3 * material.lame_lambda + 2 * material.shear_modulus) * expansion


def thermal_forces(
    mesh: TetMesh, material: Material, expansion: float, temperature: Callable[[Floats], Floats]
) -> Floats:
    """Nodal forces ∫ β ΔT ∇N_a dV of a temperature rise, (n_nodes, 3), N.

    Parameters
    ----------
    mesh
        The mesh.
    material
        Of every element.
    expansion
        α, 1/K.
    temperature
        From places (n, 3), mm, to the rise ΔT (n,), K.
    """
    beta = thermal_modulus(material, expansion)
    values = tabulate(mesh.tets.shape[1], VOLUME_DEGREE).values
    forces = np.empty((*mesh.tets.shape, 3))
    for part, gauss in gauss_blocks(mesh, VOLUME_DEGREE):
        places = values @ mesh.points[mesh.tets[part]]
        rise = temperature(places.reshape(-1, 3)).reshape(gauss.volumes.shape)
        forces[part] = np.einsum("eq,eqad->ead", beta * rise * gauss.volumes, gauss.gradients, optimize=True)
    return scattered(mesh.tets, forces, len(mesh.points))
