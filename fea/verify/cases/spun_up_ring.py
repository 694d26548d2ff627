"""Ring accelerated by a torque at its bore: the body force of an angular acceleration.

The shear stress |σ_rθ| = ρα (b⁴ − r⁴)/4r² follows from equilibrium alone, for any thickness; with
σ_rθ = μ r (u_θ/r)′ the bore rotates by ρα (b² − a²)²/(8 μ a²) relative to the rim. The field is antisymmetric
about y = 0.
"""

import math

import numpy as np

from fea.base.choices import Support
from fea.solid.inertia import inertia
from fea.solid.parity import Parity, Split
from fea.solid.traction import nodal_traction, traction_forces
from fea.solvers.static import Model
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, SolvedBody
from geometry.arrays import Floats
from geometry.bodies import Prism, Side
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from loads.instants import in_motion
from mesh.generate import Fine, mesh_body
from mesh.tetmesh import TetMesh

INSIDE, MIDDLE, OUTSIDE, HALF_THICKNESS, ALPHA = 20.0, 30.0, 50.0, 3.0, 1e6


def shear(r: float) -> float:
    """|σ_rθ| at a radius, MPa."""
    return STEEL.density * ALPHA * (OUTSIDE**4 - r**4) / (4 * r**2)


SHEAR = Goal(
    f"σxy at ({MIDDLE:g}, 0)",
    "MPa",
    -shear(MIDDLE),
    0.3,
    "the solution is exact; the stress is the mean over the elements at a single node inside the body",
)
TWIST = Goal(
    "rotation of the bore relative to the rim",
    "rad",
    STEEL.density * ALPHA * (OUTSIDE**2 - INSIDE**2) ** 2 / (8 * STEEL.shear_modulus * INSIDE**2),
    0.01,
    "the solution is exact, and displacements converge one order faster than stress",
)


def compute(size: float) -> Computed:
    """Solve y ≥ 0 and z ≥ 0 with elements of `size`, half of it at the bore."""
    sides = (
        Side(Line((-OUTSIDE, 0.0), (-INSIDE, 0.0)), Surface.SYMMETRY_Y),
        Side(Arc((0.0, 0.0), INSIDE, math.pi, -math.pi), Surface.INNER),
        Side(Line((INSIDE, 0.0), (MIDDLE, 0.0)), Surface.SYMMETRY_Y),
        Side(Line((MIDDLE, 0.0), (OUTSIDE, 0.0)), Surface.SYMMETRY_Y),
        Side(Arc((0.0, 0.0), OUTSIDE, 0.0, math.pi), Surface.OUTER),
    )
    mesh = mesh_body(Prism(sides, (0.0, HALF_THICKNESS)), size, fine={Surface.INNER: Fine(size / 2)})
    moving = inertia(mesh, STEEL.density).forces(in_motion((0.0, 0.0), 0.0, ALPHA))
    driven = shear(INSIDE) * _around(mesh, Surface.INNER)
    load = Split(moving.symmetric, moving.part(Parity.ANTISYMMETRIC) + driven)
    solution = Model(mesh, STEEL, Support.INERTIA_RELIEF).solve([load])
    u = solution.displacement[Parity.ANTISYMMETRIC]
    traction = {Surface.INNER: nodal_traction(mesh, Surface.INNER, lambda p: shear(INSIDE) * _tangents(p))}
    known = (Surface.FREE, Surface.INNER, Surface.OUTER)
    solved = SolvedBody(mesh, STEEL, u, known, traction, Parity.ANTISYMMETRIC)
    found = {
        SHEAR.quantity: float(solved.stress[solved.node_at(MIDDLE, 0.0, 0.0), 3]),
        TWIST.quantity: _turn(mesh, Surface.INNER, INSIDE, u) - _turn(mesh, Surface.OUTER, OUTSIDE, u),
    }
    return Computed(found, solved.dofs)


def _tangents(places: Floats) -> Floats:
    x, y, _ = places.T
    return np.asarray(np.stack([-y, x, 0 * x], axis=1) / np.hypot(x, y)[:, None])


def _around(mesh: TetMesh, surface: Surface) -> Floats:
    """∫ N_a e_θ dA (n_nodes, 3)."""
    return traction_forces(mesh, surface, lambda places, _: _tangents(places))


def _turn(mesh: TetMesh, surface: Surface, radius: float, u: Floats) -> float:
    """Mean rotation of a surface, rad."""
    area = 2 * math.pi * radius * HALF_THICKNESS / 2
    return float((_around(mesh, surface) * u[:, :, 0]).sum() / area / radius)


BENCHMARK = Benchmark(
    title="Ring accelerated by a torque at its bore",
    source="closed form: equilibrium of the shear stress in rings, Timoshenko & Goodier 1970, article 27",
    goals=(SHEAR, TWIST),
    compute=compute,
    size=3.0,
)
