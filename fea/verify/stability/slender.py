"""A slender beam, clamped and bent: w = F L³/(3 E I) with Timoshenko's shear, in both element orders."""

from dataclasses import replace

import numpy as np

from fea.solid.traction import traction_forces
from fea.verify.body import STEEL, held
from fea.verify.stability.row import ExtremeRow
from fea.verify.stability.solved import percent, solved
from geometry.bodies.shape import Prism, polygon
from geometry.surfaces import Surface
from mesh.body import mesh_body
from mesh.tetmesh import Floats

SIDE = 2.0
SLENDERNESS = (10.0, 100.0, 300.0, 1000.0)
# Of beam theory: shear factor 5/6 for ν = 0, and the clamped end.
TOLERANCE_PERCENT = 1.0


def rows() -> list[ExtremeRow]:
    """Second-order elements, half again as long as the beam is thick."""
    soft = replace(STEEL, poissons_ratio=0.0)
    corners = (
        ((0.0, 0.0), Surface.FREE),
        ((SIDE, 0.0), Surface.FREE),
        ((SIDE, SIDE), Surface.FREE),
        ((0.0, SIDE), Surface.FREE),
    )
    found = []
    for slenderness in SLENDERNESS:
        length = SIDE * slenderness
        mesh = mesh_body(Prism(polygon(*corners), (0.0, length), Surface.CLAMPED, Surface.LOADED), 1.5 * SIDE)
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
