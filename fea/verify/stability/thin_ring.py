"""A ring with a wall down to 1 mm, bent by a pressure q cos 2θ in its bore.

The exact solution is that of Timoshenko & Goodier (1970), §43. The element size does not change, so that the
thinnest walls are one element thick or less.
"""

import math

import numpy as np

from fea.solid.traction import nodal_traction, traction_forces
from fea.verify.body import STEEL, SolvedBody, held
from fea.verify.stability.peaks import peak_of, peak_row
from fea.verify.stability.row import ExtremeRow
from fea.verify.stability.solved import solved
from geometry.arrays import Floats
from geometry.bodies import Prism, Side
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from mesh.generate import mesh_body

BORE, THICKNESS, SIZE, PRESSURE = 20.0, 6.0, 3.0, 1.0
WALLS = (20.0, 10.0, 5.0, 2.0, 1.0)


def rows() -> list[ExtremeRow]:
    """Largest von Mises stress for both orders, with its error bar."""
    return [_row(order, wall) for order in (1, 2) for wall in WALLS]


def _row(order: int, wall: float) -> ExtremeRow:
    quarter, outside = math.pi / 2, BORE + wall
    sides = (
        Side(Line((BORE, 0.0), (outside, 0.0)), Surface.SYMMETRY_Y),
        Side(Arc((0.0, 0.0), outside, 0.0, quarter), Surface.OUTER),
        Side(Line((0.0, outside), (0.0, BORE)), Surface.SYMMETRY_X),
        Side(Arc((0.0, 0.0), BORE, quarter, -quarter), Surface.INNER),
    )
    mesh = mesh_body(Prism(sides, (0.0, THICKNESS), top=Surface.ROLLER), SIZE, order=order)
    forces = traction_forces(mesh, Surface.INNER, lambda places, _: _traction(places))
    result = solved(mesh, STEEL, forces, held(mesh, {Surface.ROLLER: (2,)}))
    traction = {Surface.INNER: nodal_traction(mesh, Surface.INNER, _traction)}
    known = (Surface.INNER, Surface.OUTER)
    body = SolvedBody(mesh, STEEL, result.displacement[:, :, None], known, traction)
    return peak_row((f"wall of a ring, p{order}", "mm", wall), result, peak_of(body), exact_peak(wall))


def _traction(places: Floats) -> Floats:
    """Return the pressure's traction, outwards: q cos 2θ times the unit radius."""
    x, y, _ = places.T
    radius = np.hypot(x, y)
    share = PRESSURE * (x**2 - y**2) / radius**3
    return np.stack([share * x, share * y, 0 * x], axis=1)


def exact_peak(wall: float) -> float:
    """Largest von Mises stress in plane strain, from φ = (A r² + B r⁴ + C/r² + D) cos 2θ, MPa."""
    a, b = BORE, BORE + wall
    radial = np.array([[-2.0, 0.0, -6 / r**4, -4 / r**2] for r in (a, b)])
    shear = np.array([[2.0, 6 * r**2, -6 / r**4, -2 / r**2] for r in (a, b)])
    A, B, C, D = np.linalg.solve(np.vstack([radial, shear]), [-PRESSURE, 0.0, 0.0, 0.0])
    r, angle = np.meshgrid(np.linspace(a, b, 401), np.linspace(0, math.pi / 2, 181))
    along, across = np.cos(2 * angle), np.sin(2 * angle)
    s_r = -(2 * A + 6 * C / r**4 + 4 * D / r**2) * along
    s_t = (2 * A + 12 * B * r**2 + 6 * C / r**4) * along
    s_rt = (2 * A + 6 * B * r**2 - 6 * C / r**4 - 2 * D / r**2) * across
    s_z = STEEL.poissons_ratio * (s_r + s_t)
    square = ((s_r - s_t) ** 2 + (s_t - s_z) ** 2 + (s_z - s_r) ** 2) / 2 + 3 * s_rt**2
    return float(np.sqrt(square.max()))
