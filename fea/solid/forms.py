"""The weak forms of the problem, as they stand on paper.

u is the displacement, v its variation, x places (3, n_elements, n_points) and n unit outward normals, in
scikit-fem's conventions; mm, N, MPa, t, s, K. Most of what a computation runs are batched kernels of the same
integrals (`fea.solid.assembly` and its neighbours): the tests hold them to these, and
``assembly = "scikit-fem"`` runs these in their place.
"""

from collections.abc import Callable

import numpy as np
from skfem import BilinearForm, LinearForm
from skfem.helpers import ddot, div, dot, sym_grad

from fea.base.material import Material, Materials
from geometry.arrays import Floats

# From places (3, n_elements, n_points), mm, to a vector (3, …) or a number (…) at each of them.
Field = Callable[[Floats], Floats]


def elasticity(material: Material | Materials) -> BilinearForm:
    """∫ σ(u) : ε(v) dV = ∫ λ ∇·u ∇·v + 2 μ ε(u) : ε(v) dV by Hooke's law, N/mm."""
    lam, mu = _lame(material)
    return BilinearForm(lambda u, v, _: lam * div(u) * div(v) + 2 * mu * ddot(sym_grad(u), sym_grad(v)))


def traction(t: Callable[[Floats, Floats], Floats]) -> LinearForm:
    """∫ t · v dA, N, of a traction t(x, n), MPa, on a basis of facets."""
    return LinearForm(lambda v, w: dot(t(w.x, w.n), v))


def body_force(b: Field) -> LinearForm:
    """∫ b · v dV, N, of a force per volume b(x), N/mm³; that of inertia is −ρ a (D'Alembert)."""
    return LinearForm(lambda v, w: dot(b(w.x), v))


def mass(density: float | Floats) -> BilinearForm:
    """∫ ρ u · v dV, t, of a density, t/mm³: of every element, or (n_elements,) of each."""
    rho = _of_each(density)
    return BilinearForm(lambda u, v, _: rho * dot(u, v))


def moment(density: float | Floats, f: Field) -> LinearForm:
    """∫ ρ f v dV of a number f(x) on a basis of scalar functions: with f = 1 the mass at each node, t."""
    rho = _of_each(density)
    return LinearForm(lambda v, w: rho * f(w.x) * v)


def thermal_strain(material: Material | Materials, expansion: float, rise: Field) -> LinearForm:
    """∫ σ(α ΔT I) : ε(v) dV = ∫ (3 λ + 2 μ) α ΔT ∇·v dV, N, of a temperature rise ΔT(x), K."""
    lam, mu = _lame(material)
    return LinearForm(lambda v, w: (3 * lam + 2 * mu) * expansion * rise(w.x) * div(v))


def _lame(material: Material | Materials) -> tuple[Floats, Floats]:
    constants = material.of(slice(None))
    return _of_each(constants.lame_lambda), _of_each(constants.shear_modulus)


def _of_each(values: float | Floats) -> Floats:
    """Values of every element, or of each, in a shape that goes with (n_elements, n_points)."""
    return np.reshape(values, (-1, 1))
