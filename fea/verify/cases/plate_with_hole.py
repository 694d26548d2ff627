"""Plate of finite width with a hole, in tension: the stress at the edge of the hole.

The chart is for plane stress. The plate is solved in plane strain: with prescribed tractions on the whole
boundary and no resultant on the hole, the in-plane stress is the same (Michell 1899), without the effect of a
free face, near which a plate of finite thickness differs from the chart.
"""

import math

from fea.solid.traction import traction_forces
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, LoadedBody, held
from geometry.bodies import Prism, Side, polygon
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from mesh.generate import Fine, mesh_body
from mesh.tetmesh import TetMesh

RADIUS, THICKNESS, TENSION = 5.0, 1.0, 100.0
HALF_WIDTH = 10 * RADIUS
HALF_LENGTH = 2 * HALF_WIDTH
_X = 1 - RADIUS / HALF_WIDTH
NET_FACTOR = 2 + 0.284 * _X - 0.6 * _X**2 + 1.32 * _X**3

PEAK = Goal(
    "peak stress / gross stress",
    "1",
    NET_FACTOR / _X,
    0.5,
    "the polynomial of the chart is fitted to Howland's figures (1930), which have three digits",
)


def meshed(size: float) -> TetMesh:
    """Mesh a quarter with elements of `size` at the hole and ten times that far away."""
    quarter = math.pi / 2
    sides = (
        *polygon(
            ((RADIUS, 0.0), Surface.SYMMETRY_Y),
            ((HALF_LENGTH, 0.0), Surface.LOADED),
            ((HALF_LENGTH, HALF_WIDTH), Surface.FREE),
            ((0.0, HALF_WIDTH), Surface.SYMMETRY_X),
        )[:3],
        Side(Line((0.0, HALF_WIDTH), (0.0, RADIUS)), Surface.SYMMETRY_X),
        Side(Arc((0.0, 0.0), RADIUS, quarter, -quarter), Surface.INNER),
    )
    body = Prism(sides, (0.0, THICKNESS), top=Surface.ROLLER)
    return mesh_body(body, 10 * size, fine={Surface.INNER: Fine(size)})


def loaded(mesh: TetMesh) -> LoadedBody:
    """Apply loads and boundary conditions."""
    forces = traction_forces(mesh, Surface.LOADED, lambda _, normals: TENSION * normals)
    known = (Surface.INNER, Surface.FREE)
    return LoadedBody(mesh, STEEL, forces, held(mesh, {Surface.ROLLER: (2,)}), known)


def compute(size: float) -> Computed:
    """Solve with elements of `size` (see `meshed`)."""
    solved = loaded(meshed(size)).solved()
    beside = solved.node_at(0.0, RADIUS, 0.0)
    return Computed({PEAK.quantity: float(solved.stress[beside, 0]) / TENSION}, solved.dofs)


BENCHMARK = Benchmark(
    title="Plate of finite width with a hole, d/W = 0.1, in tension",
    source="Pilkey, Peterson's Stress Concentration Factors (1997), chart 4.1",
    goals=(PEAK,),
    compute=compute,
    size=0.6,
)
