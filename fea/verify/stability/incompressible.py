"""Lamé's cylinder from ν = 0.3 to 0.499999: displacement elements lock, or leave garbage as mean stress."""

import math
from dataclasses import replace

import numpy as np

from fea.checks import LIMITS
from fea.solid.traction import nodal_traction, traction_forces
from fea.verify.body import STEEL, SolvedBody, held
from fea.verify.stability.row import ExtremeRow
from fea.verify.stability.solved import solved
from geometry.bodies.shape import Prism, Side
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from mesh.body import mesh_body

INSIDE, OUTSIDE, THICKNESS, PRESSURE = 10.0, 20.0, 3.0, 100.0
RATIOS = (0.3, 0.4, 0.45, 0.49, 0.495, 0.499, 0.4999, 0.499999)
# Of the mean stress anywhere, relative to the bore's hoop stress, on these coarse meshes.
TOLERANCE_PERCENT = {1: 15.0, 2: 10.0}
_SIZE = {1: 1.5, 2: 2.0}


def rows() -> list[ExtremeRow]:
    """Worst mean stress of all nodes, for both orders; marked beyond the limits of `fea.checks`."""
    return [row for order in (1, 2) for row in _rows(order)]


def _rows(order: int) -> list[ExtremeRow]:
    quarter = math.pi / 2
    sides = (
        Side(Line((INSIDE, 0.0), (OUTSIDE, 0.0)), Surface.SYMMETRY_Y),
        Side(Arc((0.0, 0.0), OUTSIDE, 0.0, quarter), Surface.OUTER),
        Side(Line((0.0, OUTSIDE), (0.0, INSIDE)), Surface.SYMMETRY_X),
        Side(Arc((0.0, 0.0), INSIDE, quarter, -quarter), Surface.INNER),
    )
    mesh = mesh_body(Prism(sides, (0.0, THICKNESS), top=Surface.ROLLER), _SIZE[order], order=order)
    forces = traction_forces(mesh, Surface.INNER, lambda _, normals: -PRESSURE * normals)
    radial = np.array([PRESSURE, PRESSURE, 0.0]) / INSIDE
    pressed = {Surface.INNER: nodal_traction(mesh, Surface.INNER, lambda places: radial * places)}
    fixed = held(mesh, {Surface.ROLLER: (2,)})
    widths = OUTSIDE**2 - INSIDE**2
    hoop = PRESSURE * (OUTSIDE**2 + INSIDE**2) / widths
    limit = LIMITS[f"poissons_ratio_p{order}"]
    found = []
    for ratio in RATIOS:
        material = replace(STEEL, poissons_ratio=ratio)
        result = solved(mesh, material, forces, fixed)
        body = SolvedBody(
            mesh, material, result.displacement[:, :, None], (Surface.INNER, Surface.OUTER), pressed
        )
        mean = body.stress[:, :3].mean(axis=1)
        exact = PRESSURE * INSIDE**2 / widths * 2 * (1 + ratio) / 3
        error = 100 * float(np.abs(mean - exact).max()) / hoop
        found.append(
            result.row(
                f"near-incompressible, p{order}",
                "ν",
                ratio,
                error,
                TOLERANCE_PERCENT[order],
                marked=ratio > limit,
            )
        )
    return found
