"""NAFEMS LE1, elliptic membrane: σyy at the end of the inner ellipse's major axis.

The membrane is in plane stress. It is solved as one layer in plane strain: with prescribed tractions on the
whole boundary and no resultant on the hole, the in-plane stress is the same (Michell 1899).
"""

from fea.solid.traction import traction_forces
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, LoadedBody, held
from fea.verify.ellipse import INNER_AXES, elliptic_outline
from geometry.bodies import Prism
from geometry.surfaces import Surface
from mesh.generate import Fine, mesh_body
from mesh.tetmesh import TetMesh

PRESSURE = 10.0  # outward on the outer ellipse, MPa
THICKNESS = 50.0

GOAL = Goal(
    "σyy at (2, 0) m",
    "MPa",
    92.7,
    0.3,
    "the target has three digits (0.05 %), and a converged value is within 0.1 % of it; the rest is allowed "
    "for the mesh",
)


def meshed(size: float) -> TetMesh:
    """Mesh with elements of `size`, and of a quarter of it at the inner ellipse."""
    body = Prism(elliptic_outline(), (0.0, THICKNESS), top=Surface.ROLLER)
    return mesh_body(body, size, fine={Surface.INNER: Fine(size / 4)})


def loaded(mesh: TetMesh) -> LoadedBody:
    """Apply loads and boundary conditions."""
    forces = traction_forces(mesh, Surface.OUTER, lambda _, normals: PRESSURE * normals)
    return LoadedBody(mesh, STEEL, forces, held(mesh, {Surface.ROLLER: (2,)}), (Surface.INNER,))


def compute(size: float) -> Computed:
    """Solve with elements of `size` (see `meshed`)."""
    solved = loaded(meshed(size)).solved()
    D = solved.node_at(INNER_AXES[0], 0.0, 0.0)
    return Computed({GOAL.quantity: float(solved.stress[D, 1])}, solved.dofs)


BENCHMARK = Benchmark(
    title="NAFEMS LE1: elliptic membrane",
    source="NAFEMS, The Standard NAFEMS Benchmarks, TNSB rev. 3 (1990), LE1",
    goals=(GOAL,),
    compute=compute,
    size=200.0,
)
