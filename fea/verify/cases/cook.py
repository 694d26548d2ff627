"""Cook's membrane in plane strain, compressible and nearly incompressible: deflection of its corner."""

from dataclasses import replace

import numpy as np

from fea.solid.traction import traction_forces
from fea.solvers.constrained import displacement
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, LoadedBody, SolvedBody, held
from geometry.arrays import Floats
from geometry.bodies import Prism, polygon
from geometry.surfaces import Surface
from mesh.generate import Fine, mesh_body
from mesh.tetmesh import TetMesh

THICKNESS = 0.6
COMPRESSIBLE = replace(STEEL, youngs_modulus=70.0, poissons_ratio=1 / 3)
NEARLY_NOT = replace(STEEL, youngs_modulus=240.565, poissons_ratio=0.4999)

CORNER = Goal(
    "u_y of the upper corner",
    "mm",
    32.30,
    0.2,
    "the published value (32.27) and the extrapolated one differ by 0.1 %, and singular corners slow down "
    "convergence",
)
INCOMPRESSIBLE = Goal(
    "u_y of the upper corner, ν = 0.4999",
    "mm",
    8.076,
    0.5,
    "displacements of second-order elements do not lock, but converge more slowly than for ν = 1/3",
)
SHEAR = 6.25  # on the right edge, MPa: a force of 100 N/mm over its 16 mm
_CASES = ((CORNER, COMPRESSIBLE), (INCOMPRESSIBLE, NEARLY_NOT))


def meshed(size: float, order: int = 2) -> TetMesh:
    """Mesh with elements of `size`, and of a tenth of it at the clamped and at the loaded edge."""
    corners = (
        ((0.0, 0.0), Surface.FREE),
        ((48.0, 44.0), Surface.LOADED),
        ((48.0, 60.0), Surface.FREE),
        ((0.0, 44.0), Surface.CLAMPED),
    )
    body = Prism(polygon(*corners), (0.0, THICKNESS), top=Surface.ROLLER)
    # The corners of both edges are singular, and the displacement is taken at a corner of the loaded edge.
    fine = Fine(size / 10)
    return mesh_body(body, size, order=order, fine={Surface.CLAMPED: fine, Surface.LOADED: fine})


def membrane(mesh: TetMesh) -> LoadedBody:
    """Apply loads and boundary conditions."""
    up = np.array([0.0, SHEAR, 0.0])
    forces = traction_forces(mesh, Surface.LOADED, lambda places, _: np.broadcast_to(up, places.shape))
    fixed = held(mesh, {Surface.ROLLER: (2,), Surface.CLAMPED: (0, 1)})
    return LoadedBody(mesh, COMPRESSIBLE, forces, fixed)


def rise(mesh: TetMesh, u: Floats) -> float:
    """Deflection of the upper corner, mm, from displacements (n_nodes, 3)."""
    return float(u[SolvedBody(mesh, COMPRESSIBLE, u[:, :, None]).node_at(48.0, 60.0, 0.0), 1])


def compute(size: float) -> Computed:
    """Solve both on one mesh."""
    body = membrane(meshed(size))
    found = {}
    for goal, material in _CASES:
        u = displacement(body.mesh, material, body.forces, body.fixed)
        found[goal.quantity] = rise(body.mesh, u[:, :, 0])
    return Computed(found, body.mesh.points.size)


BENCHMARK = Benchmark(
    title="Cook's membrane, plane strain",
    source="Cook 1974, J. Struct. Div. ASCE 100, 1851-1863; the value is extrapolated from finer meshes",
    goals=(CORNER, INCOMPRESSIBLE),
    compute=compute,
    size=3.0,
)
