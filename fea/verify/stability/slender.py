"""A slender cantilever in bending: w = F L³/(3 E I) plus the shear deflection of Timoshenko."""

from dataclasses import replace

import numpy as np

from fea.solid.traction import traction_forces
from fea.verify.body import STEEL, held
from fea.verify.stability.lattice import lattice
from fea.verify.stability.row import ExtremeRow
from fea.verify.stability.solved import percent, solved
from geometry.arrays import Floats
from geometry.surfaces import Surface

SIDE = 2.0
SLENDERNESS = (10, 30, 100, 300, 1000)
# Length of an element, in multiples of the side.
ELEMENT = 2
# Error of beam theory: shear factor 5/6 for ν = 0, and the effect of the clamped end.
TOLERANCE_PERCENT = 1.0


def rows() -> list[ExtremeRow]:
    """Second-order elements, twice as long as the beam is thick."""
    soft = replace(STEEL, poissons_ratio=0.0)
    ends = {(2, 0): Surface.CLAMPED, (2, 1): Surface.LOADED}
    found = []
    for slenderness in SLENDERNESS:
        length = SIDE * slenderness
        size = np.array([SIDE, SIDE, length])
        mesh = lattice((1, 1, slenderness // ELEMENT), size.__mul__, ends)
        forces = traction_forces(mesh, Surface.LOADED, _shear)
        result = solved(mesh, soft, forces, held(mesh, {Surface.CLAMPED: (0, 1, 2)}))
        E, area, inertia = soft.youngs_modulus, SIDE**2, SIDE**4 / 12
        exact = length**3 / (3 * E * inertia) + length / (5 / 6 * area * soft.shear_modulus)
        end = np.unique(mesh.facets[Surface.LOADED])
        error = percent(float(result.displacement[end, 0].mean()), exact)
        found.append(result.row("slenderness, p2", "L/h", slenderness, error, TOLERANCE_PERCENT))
    return found


def _shear(places: Floats, _normals: Floats) -> Floats:
    """Return the traction of one newton along x on the end."""
    return np.broadcast_to(np.array([1.0, 0.0, 0.0]) / SIDE**2, places.shape)
