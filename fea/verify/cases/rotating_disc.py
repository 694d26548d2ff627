"""Rotating disc: the centrifugal body force.

The disc is thin but three-dimensional: the stress is that of plane stress plus ν (1 + ν)/(6 (1 − ν)) ρω² (c²
− 3z²), where c is half the thickness, which is exact away from the rim (the edge effect decays within a
thickness). The mean displacement of the rim is exactly that of plane stress (reciprocal theorem).
"""

import math

from fea.base.choices import Support
from fea.solid.inertia import inertia
from fea.solid.parity import Parity
from fea.solid.traction import traction_forces
from fea.solvers.static import Model
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, SolvedBody
from geometry.bodies import Prism, Side
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from loads.instants import in_motion
from mesh.generate import mesh_body
from mesh.tetmesh import TetMesh

RADIUS, HALF_THICKNESS, OMEGA = 100.0, 5.0, 1000.0
_NU = STEEL.poissons_ratio
_SQUARE = STEEL.density * OMEGA**2

CENTRE = Goal(
    "σxx at the centre, mid-plane",
    "MPa",
    _SQUARE * ((3 + _NU) / 8 * RADIUS**2 + _NU * (1 + _NU) / (6 * (1 - _NU)) * HALF_THICKNESS**2),
    0.1,
    "the solution is exact; the stress is the mean over the elements at a single node inside the body",
)
RIM = Goal(
    "mean radial displacement of the rim",
    "mm",
    _SQUARE * (1 - _NU) * RADIUS**3 / (4 * STEEL.youngs_modulus),
    0.01,
    "the solution is exact, and displacements converge one order faster than stress",
)


def meshed(size: float) -> TetMesh:
    """Mesh y ≥ 0 and z ≥ 0 with elements of `size`."""
    sides = (
        Side(Line((-RADIUS, 0.0), (0.0, 0.0)), Surface.SYMMETRY_Y),
        Side(Line((0.0, 0.0), (RADIUS, 0.0)), Surface.SYMMETRY_Y),
        Side(Arc((0.0, 0.0), RADIUS, 0.0, math.pi), Surface.OUTER),
    )
    return mesh_body(Prism(sides, (0.0, HALF_THICKNESS)), size)


def spun(mesh: TetMesh) -> SolvedBody:
    """Solve on a mesh."""
    spinning = inertia(mesh, STEEL.density).forces(in_motion((0.0, 0.0), OMEGA, 0.0))
    solution = Model(mesh, STEEL, Support.INERTIA_RELIEF).solve([spinning])
    u = solution.displacement[Parity.SYMMETRIC]
    return SolvedBody(mesh, STEEL, u, (Surface.FREE, Surface.OUTER))


def compute(size: float) -> Computed:
    """Solve with elements of `size`."""
    solved = spun(meshed(size))
    mesh, u = solved.mesh, solved.displacement
    outward = traction_forces(mesh, Surface.OUTER, lambda _, normals: normals)  # ∫ N_a n dA
    area = (outward * mesh.points).sum() / RADIUS
    found = {
        CENTRE.quantity: float(solved.stress[solved.node_at(0.0, 0.0, 0.0), 0]),
        # A translation along x, which depends on the restraints, does not contribute to ∫ u · n dA.
        RIM.quantity: float((outward * u[:, :, 0]).sum() / area),
    }
    return Computed(found, solved.dofs)


BENCHMARK = Benchmark(
    title="Rotating disc",
    source="Timoshenko & Goodier 1970, chapters 4 and 12",
    goals=(CENTRE, RIM),
    compute=compute,
    size=5.0,
)
