"""Elements that grow a thousandfold away from a tiny cavity: Lamé's hollow sphere under internal pressure."""

import math

from fea.solid.traction import nodal_traction, traction_forces
from fea.verify.body import STEEL, SolvedBody, held
from fea.verify.stability.peaks import peak_of, peak_row
from fea.verify.stability.row import ExtremeRow
from fea.verify.stability.solved import solved
from geometry.bodies import Revolution, Side
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from mesh.generate import Fine, mesh_body
from mesh.tetmesh import TetMesh

OUTSIDE, SIZE, PRESSURE = 40.0, 10.0, 100.0
GRADINGS = (1.0, 10.0, 100.0, 1000.0)
# Number of the smallest elements along a quarter of the cavity.
PER_QUARTER = 6


def rows() -> list[ExtremeRow]:
    """Largest von Mises stress at the cavity, whose radius shrinks with its elements."""
    return [_row(grading) for grading in GRADINGS]


def sphere(grading: float) -> TetMesh:
    """Mesh an octant; the radius of the cavity is proportional to the smallest size."""
    quarter, inside = math.pi / 2, cavity(grading)
    sides = (
        Side(Line((inside, 0.0), (OUTSIDE, 0.0)), Surface.SYMMETRY_Z),
        Side(Arc((0.0, 0.0), OUTSIDE, 0.0, quarter), Surface.OUTER),
        Side(Line((0.0, OUTSIDE), (0.0, inside)), Surface.FREE),  # the axis
        Side(Arc((0.0, 0.0), inside, quarter, -quarter), Surface.INNER),
    )
    fine = {Surface.INNER: Fine(SIZE / grading, inside)} if grading > 1 else {}
    return mesh_body(Revolution(sides), SIZE, fine=fine)


def cavity(grading: float) -> float:
    """Radius of the cavity, mm."""
    return min(PER_QUARTER * SIZE / grading / (math.pi / 2), OUTSIDE / 2)


def _row(grading: float) -> ExtremeRow:
    mesh, inside = sphere(grading), cavity(grading)
    forces = traction_forces(mesh, Surface.INNER, lambda _, normals: -PRESSURE * normals)
    result = solved(mesh, STEEL, forces, held(mesh, {}))
    traction = {Surface.INNER: nodal_traction(mesh, Surface.INNER, lambda places: PRESSURE * places / inside)}
    known = (Surface.INNER, Surface.OUTER)
    body = SolvedBody(mesh, STEEL, result.displacement[:, :, None], known, traction)
    # Radial −p, tangential p (2 a³ + b³) / (2 (b³ − a³)): Timoshenko & Goodier 1970, §136.
    exact = 1.5 * PRESSURE * OUTSIDE**3 / (OUTSIDE**3 - inside**3)
    return peak_row(("mesh grading, p2", "ratio", grading), result, peak_of(body), exact)
