"""NAFEMS LE10, thick elliptic plate under pressure: σyy at the end of the inner major axis, on top."""

import numpy as np

from fea.solid.traction import nodal_traction, traction_forces
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, LoadedBody, held
from fea.verify.ellipse import INNER_AXES, elliptic_outline
from geometry.bodies import Prism
from geometry.surfaces import Surface
from mesh.generate import Fine, mesh_body
from mesh.tetmesh import TetMesh

PRESSURE = 1.0  # on the top, MPa
HALF = 300.0  # of the thickness

GOAL = Goal(
    "σyy at (2, 0) m, top",
    "MPa",
    -5.38,
    0.3,
    "the target has three digits (0.1 %); the rest is allowed for the mesh",
)


def meshed(size: float) -> TetMesh:
    """Mesh with elements of `size`, and of 0.4 of it at the inner ellipse."""
    body = Prism(elliptic_outline(), (-HALF, 0.0, HALF), bottom=Surface.FREE, top=Surface.LOADED)
    return mesh_body(body, size, fine={Surface.INNER: Fine(size / 2.5)})


def loaded(mesh: TetMesh) -> LoadedBody:
    """Apply loads and boundary conditions."""
    forces = traction_forces(mesh, Surface.LOADED, lambda _, normals: -PRESSURE * normals)
    fixed = held(mesh, {Surface.OUTER: (0, 1)})
    outer = np.unique(mesh.facets[Surface.OUTER])
    fixed[outer[np.abs(mesh.points[outer, 2]) < 1e-6 * HALF], 2] = True  # its edge at mid-thickness
    down = np.array([0.0, 0.0, -PRESSURE])
    pressed = nodal_traction(mesh, Surface.LOADED, lambda places: np.broadcast_to(down, places.shape))
    known = (Surface.INNER, Surface.FREE, Surface.LOADED)
    return LoadedBody(mesh, STEEL, forces, fixed, known, {Surface.LOADED: pressed})


def compute(size: float) -> Computed:
    """Solve with elements of `size` (see `meshed`)."""
    solved = loaded(meshed(size)).solved()
    D = solved.node_at(INNER_AXES[0], 0.0, HALF)
    return Computed({GOAL.quantity: float(solved.stress[D, 1])}, solved.dofs)


BENCHMARK = Benchmark(
    title="NAFEMS LE10: thick plate under pressure",
    source="NAFEMS, The Standard NAFEMS Benchmarks, TNSB rev. 3 (1990), LE10",
    goals=(GOAL,),
    compute=compute,
    size=100.0,
)
