"""Closed forms of a ring pressed into another one, in plane stress, without friction."""

from dataclasses import dataclass

import numpy as np

from fea.base.material import Material
from geometry.arrays import Floats


@dataclass(frozen=True)
class Fit:
    """Two rings.

    Attributes
    ----------
    radii
        Of the bore, the fit and the outside, mm.
    materials
        Of the inner and of the outer ring.
    interference
        Of the radii, mm.
    """

    radii: tuple[float, float, float]
    materials: tuple[Material, Material]
    interference: float

    def pressure(self, interference: float) -> float:
        """Pressure of an interference (Lamé 1852), MPa."""
        (a, b, c), (inner, outer) = self.radii, self.materials
        around = (c * c + b * b) / (c * c - b * b) + outer.poissons_ratio
        within = (b * b + a * a) / (b * b - a * a) - inner.poissons_ratio
        return interference / (b / outer.youngs_modulus * around + b / inner.youngs_modulus * within)


def michell_share(fit: Fit) -> float:
    """Amplitude of the pressure of the fit over q, under a pressure q cos 2φ in the bore.

    The stress functions r⁴, r², 1 and r⁻² times cos 2φ of both rings are solved for stresses that are given
    inside and outside, and for pressures and radial displacements that agree at the fit, without shear.
    """
    a, b, c = fit.radii
    rows, side = np.zeros((8, 8)), np.zeros(8)
    inner, outer = slice(0, 4), slice(4, 8)
    for row, (ring, place) in enumerate(((inner, a), (inner, b), (outer, b), (outer, c))):
        rows[row, ring] = _stress(place)[1]
    rows[4, inner], side[4] = _stress(a)[0], -1.0
    rows[5, outer] = _stress(c)[0]
    rows[6, inner], rows[6, outer] = _stress(b)[0], -_stress(b)[0]
    rows[7, inner], rows[7, outer] = _moved(fit.materials[0], b), -_moved(fit.materials[1], b)
    # The functions differ by powers of the radius.
    scale = np.abs(rows).max(axis=0)
    found = np.linalg.solve(rows / scale, side) / scale
    return float(abs(_stress(b)[0] @ found[inner]))


def _stress(r: float) -> tuple[Floats, Floats]:
    """σ_r over cos 2φ and τ over sin 2φ of r⁴, r², 1 and r⁻² (Timoshenko & Goodier 1970, article 43)."""
    radial = np.array([0.0, -2.0, -4 * r**-2, -6 * r**-4])
    return radial, np.array([6 * r * r, 2.0, -2 * r**-2, -6 * r**-4])


def _moved(material: Material, r: float) -> Floats:
    """u_r over cos 2φ of the same (Barber 2010, table 9.1, plane stress), mm per MPa."""
    kappa = (3 - material.poissons_ratio) / (1 + material.poissons_ratio)
    return np.array([(kappa - 3) * r**3, -2 * r, (kappa + 1) / r, 2 * r**-3]) / (2 * material.shear_modulus)
