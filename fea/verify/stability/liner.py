"""A liner in an eye, from far softer to far stiffer than it: Lamé's compound cylinder in plane strain."""

import math
from dataclasses import replace

import numpy as np

from fea.base.material import Materials
from fea.solid.traction import traction_forces
from fea.verify.body import STEEL, held
from fea.verify.stability.lattice import lattice
from fea.verify.stability.row import ExtremeRow
from fea.verify.stability.solved import percent, solved
from geometry.arrays import Floats
from geometry.surfaces import Surface

BORE, INTERFACE, OUTSIDE, THICKNESS, PRESSURE = 10.0, 12.0, 20.0, 2.0, 100.0
CONTRASTS = (1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9)
RADIAL = (2, 4)  # elements through the liner, through the eye
# For the radial displacement on this mesh.
TOLERANCE_PERCENT = 0.1
_ENDS = {
    (0, 0): Surface.INNER,
    (0, 1): Surface.OUTER,
    (1, 0): Surface.SYMMETRY_Y,
    (1, 1): Surface.SYMMETRY_X,
    (2, 0): Surface.SYMMETRY_Z,
    (2, 1): Surface.ROLLER,
}


def rows() -> list[ExtremeRow]:
    """The worse error of the radial displacements of bore and interface."""
    mesh = lattice((sum(RADIAL), 8, 1), _placed, _ENDS)
    radius = np.hypot(mesh.points[:, 0], mesh.points[:, 1])
    liner = (radius[mesh.tets[:, :4]].mean(axis=1) < INTERFACE).astype(np.int64)
    forces = traction_forces(mesh, Surface.INNER, lambda _, normals: -PRESSURE * normals)
    fixed = held(mesh, {Surface.ROLLER: (2,)})
    found = []
    for contrast in CONTRASTS:
        other = replace(STEEL, youngs_modulus=contrast * STEEL.youngs_modulus)
        result = solved(mesh, Materials((STEEL, other), liner), forces, fixed)
        outward = (result.displacement[:, :2] * mesh.points[:, :2]).sum(axis=1) / radius
        error = max(
            percent(value, exact)
            for place, exact in zip((BORE, INTERFACE), exact_displacement(contrast), strict=True)
            for value in outward[np.abs(radius - place) < 1e-6]
        )
        found.append(result.row("liner in an eye, p2", "E₂/E₁", contrast, error, TOLERANCE_PERCENT))
    return found


def _placed(unit: Floats) -> Floats:
    share = RADIAL[0] / sum(RADIAL)
    r = np.interp(unit[:, 0], [0, share, 1], [BORE, INTERFACE, OUTSIDE])
    angle = unit[:, 1] * math.pi / 2
    return np.stack([r * np.cos(angle), r * np.sin(angle), THICKNESS * unit[:, 2]], axis=1)


def exact_displacement(contrast: float) -> tuple[float, float]:
    """Radial displacement at bore and interface, u = A r + B/r in each ring, mm.

    The interface pressure is computed first, from the radial displacements that it and the pressure in the
    bore cause in each ring; this avoids differences of large numbers at any contrast.
    """
    E, nu = STEEL.youngs_modulus, STEEL.poissons_ratio

    def widened(modulus: float, ring: tuple[float, float], pressures: tuple[float, float], r: float) -> float:
        (a, b), (inside, outside) = ring, pressures
        mean = (inside * a**2 - outside * b**2) / (b**2 - a**2)
        swing = (inside - outside) * a**2 * b**2 / (b**2 - a**2)
        return (1 + nu) / modulus * ((1 - 2 * nu) * mean * r + swing / r)

    liner, eye, soft = (BORE, INTERFACE), (INTERFACE, OUTSIDE), contrast * E
    free = widened(soft, liner, (PRESSURE, 0.0), INTERFACE)
    yielding = widened(E, eye, (1.0, 0.0), INTERFACE) - widened(soft, liner, (0.0, 1.0), INTERFACE)
    between = free / yielding
    return (
        widened(soft, liner, (PRESSURE, between), BORE),
        widened(E, eye, (between, 0.0), INTERFACE),
    )
