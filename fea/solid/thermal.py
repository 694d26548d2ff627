"""Thermal strain as a right-hand side.

With the thermal strain α ΔT I the stress is σ = C : ε − β ΔT I, β = (3λ + 2μ) α. So C : ε, the stress of
the total strain, is that of an isothermal body under additional forces ∫ β ΔT ∇N_a dV, which are a body
force −β ∇T and a traction β ΔT n (Duhamel 1837; Boley & Weiner 1960, chapter 3). It is recovered
with that traction, and β ΔT I is subtracted at the nodes.
"""

from collections.abc import Callable

from fea.material import Material
from fea.solid import forms
from fea.solid.integration import VOLUME_DEGREE
from fea.solid.scikit_fem import by_point, volume_forces
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
    form = forms.thermal_strain(material, expansion, by_point(temperature))
    return volume_forces(mesh, form, VOLUME_DEGREE)
