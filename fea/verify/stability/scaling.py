"""The same body in other units and with other moduli: the dimensionless result must not change."""

from dataclasses import replace

import numpy as np

from fea.solid.traction import traction_forces
from fea.verify.body import STEEL, held
from fea.verify.stability.row import ExtremeRow
from fea.verify.stability.solved import Solved, solved
from geometry.arrays import Floats
from geometry.bodies import Prism, polygon
from geometry.surfaces import Surface
from mesh.generate import mesh_body
from mesh.tetmesh import TetMesh

SCALES = (1e-3, 1e-1, 1e1, 1e3)
MODULI = (1.0, 1e3, 1.2e6)  # MPa: rubber, a polymer, diamond
TOLERANCE_PERCENT = 1e-8


def rows() -> list[ExtremeRow]:
    """Compare with a steel block in millimetres under the same load per E A."""
    corners = (
        ((0.0, 0.0), Surface.CLAMPED),
        ((10.0, 0.0), Surface.LOADED),
        ((10.0, 4.0), Surface.FREE),
        ((0.0, 4.0), Surface.FREE),
    )
    mesh = mesh_body(Prism(polygon(*corners), (0.0, 3.0), top=Surface.FREE), 2.0)
    reference = _solved(mesh, STEEL.youngs_modulus).displacement
    found = []
    for scale in SCALES:
        result = _solved(replace(mesh, points=scale * mesh.points), STEEL.youngs_modulus)
        found.append(
            _row("size of the body", "scale", scale, result, _off(result.displacement / scale, reference))
        )
    for modulus in MODULI:
        result = _solved(mesh, modulus)
        found.append(
            _row("stiffness of the body", "MPa", modulus, result, _off(result.displacement, reference))
        )
    return found


def _solved(mesh: TetMesh, modulus: float) -> Solved:
    pull = np.array([1e-3, 2e-3, -1e-3]) * modulus
    forces = traction_forces(mesh, Surface.LOADED, lambda places, _: np.broadcast_to(pull, places.shape))
    material = replace(STEEL, youngs_modulus=modulus)
    return solved(mesh, material, forces, held(mesh, {Surface.CLAMPED: (0, 1, 2)}))


def _row(case: str, parameter: str, value: float, result: Solved, off: float) -> ExtremeRow:
    return result.row(case, parameter, value, 100 * off, TOLERANCE_PERCENT)


def _off(shape: Floats, reference: Floats) -> float:
    return float(np.abs(shape - reference).max() / np.abs(reference).max())
