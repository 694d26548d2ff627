"""A beam in pure bending on coarser and coarser meshes: first-order elements are far too stiff.

σ_zz = M x / I is the exact solution everywhere, and second-order elements contain it.
"""

import numpy as np

from fea.base.choices import CONVERGED_PERCENT
from fea.solid.traction import nodal_traction, traction_forces
from fea.verify.body import STEEL, SolvedBody, held
from fea.verify.stability.peaks import noticed, peak_of
from fea.verify.stability.row import ExtremeRow
from fea.verify.stability.solved import Solved, percent, solved
from geometry.arrays import Floats
from geometry.bodies import Prism, polygon
from geometry.surfaces import Surface
from mesh.generate import mesh_body
from mesh.tetmesh import TetMesh

DEPTH, WIDTH, LENGTH, STRESS = 4.0, 6.0, 20.0, 100.0
LAYERS = (4.0, 2.0, 1.0, 0.5)


def rows() -> list[ExtremeRow]:
    """The worse error of largest von Mises stress and compliance, for both orders."""
    return [_row(order, count) for order in (1, 2) for count in LAYERS]


def _row(order: int, layers: float) -> ExtremeRow:
    mesh = beam(DEPTH / layers, order)
    result = bent(mesh)
    peak = peak_of(stressed(mesh, result))
    work = float((_forces(mesh) * result.displacement).sum())
    # ∫ σ²/E dV over the quarter.
    exact = STRESS**2 / STEEL.youngs_modulus * DEPTH / 3 * WIDTH / 2 * LENGTH / 2
    error = max(percent(peak.value, STRESS), percent(work, exact))
    return result.row(
        f"bending, p{order}", "layers", layers, error, CONVERGED_PERCENT, noticed_by=noticed(peak)
    )


def beam(size: float, order: int) -> TetMesh:
    """Mesh a quarter: cut at mid length and along the plane of bending."""
    half, side = DEPTH / 2, WIDTH / 2
    corners = (
        ((-half, 0.0), Surface.SYMMETRY_Y),
        ((half, 0.0), Surface.FREE),
        ((half, side), Surface.FREE),
        ((-half, side), Surface.FREE),
    )
    return mesh_body(Prism(polygon(*corners), (0.0, LENGTH / 2), top=Surface.LOADED), size, order=order)


def bent(mesh: TetMesh) -> Solved:
    """Solve under the traction of the exact solution on the end."""
    fixed = held(mesh, {})
    both = np.flatnonzero(fixed[:, 1] & fixed[:, 2])
    fixed[both[np.abs(mesh.points[both, 0]).argmin()], 0] = True
    return solved(mesh, STEEL, _forces(mesh), fixed)


def stressed(mesh: TetMesh, result: Solved) -> SolvedBody:
    """Return the solution in the form needed for stress recovery."""
    traction = {Surface.LOADED: nodal_traction(mesh, Surface.LOADED, _traction)}
    known = (Surface.LOADED, Surface.FREE)
    return SolvedBody(mesh, STEEL, result.displacement[:, :, None], known, traction)


def _forces(mesh: TetMesh) -> Floats:
    return traction_forces(mesh, Surface.LOADED, lambda places, _: _traction(places))


def _traction(places: Floats) -> Floats:
    return np.stack([0 * places[:, 0], 0 * places[:, 0], STRESS * places[:, 0] / (DEPTH / 2)], axis=1)
