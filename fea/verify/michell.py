"""Rings in plane stress under waves of pressure, by Michell's stress function.

It is (A rⁿ + B rⁿ⁺² + C r⁻ⁿ + D r²⁻ⁿ) cos nφ, n ≥ 2 (Michell 1899; Timoshenko & Goodier 1970, article 43;
Barber 2010, table 9.1).
"""

import numpy as np

from fea.base.material import Material
from geometry.arrays import Floats


def stresses(r: Floats | float, n: int) -> tuple[Floats, Floats, Floats]:
    """σ_r and σ_φ over cos nφ, and τ over sin nφ, each (…, 4) for A, B, C and D at radii (…,)."""
    powers = np.stack([np.power(r, float(power)) for power in (n - 2, n, -n - 2, -n)], axis=-1)
    radial = np.array([-n * (n - 1), -(n + 1) * (n - 2), -n * (n + 1), -(n + 2) * (n - 1)])
    around = np.array([n * (n - 1), (n + 1) * (n + 2), n * (n + 1), (n - 1) * (n - 2)])
    shear = np.array([n * (n - 1), n * (n + 1), -n * (n + 1), -n * (n - 1)])
    return radial * powers, around * powers, shear * powers


def displacement(material: Material, r: float, n: int) -> Floats:
    """u_r over cos nφ, (4,) for A, B, C and D, mm per MPa."""
    kappa = (3 - material.poissons_ratio) / (1 + material.poissons_ratio)
    powers: Floats = np.power(r, np.array([n - 1.0, n + 1, -n - 1, 1 - n]))
    return np.array([-n, kappa - n - 1, n, kappa + n - 1]) * powers / (2 * material.shear_modulus)


def pressed(inner: float, outer: float, n: int) -> Floats:
    """A, B, C and D of a ring under a pressure cos nφ of 1 MPa inside, free outside."""
    radial, _, shear = stresses(np.array([inner, outer]), n)
    return np.linalg.solve(np.concatenate([radial, shear]), [-1.0, 0.0, 0.0, 0.0])
