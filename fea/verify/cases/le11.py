"""NAFEMS LE11, cylinder, taper and sphere with a temperature field: σzz at the foot of the inner sphere."""

import math

import numpy as np

from fea.solid.traction import thermal_forces, thermal_modulus
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, LoadedBody, held
from geometry.arrays import Floats
from geometry.bodies import Revolution, Side
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from mesh.generate import Fine, mesh_body
from mesh.tetmesh import TetMesh

EXPANSION = 2.3e-4  # 1/K
METRE = 1000.0

GOAL = Goal(
    "σzz at A (1, 0, 0) m",
    "MPa",
    -105.0,
    1.0,
    "the target has three digits; finer meshes exceed it by 0.6 %",
)


def temperature(places: Floats) -> Floats:
    """T = r + z in kelvin, r and z in metres."""
    return np.asarray((np.hypot(places[:, 0], places[:, 1]) + places[:, 2]) / METRE)


def meridian() -> tuple[Side, ...]:
    """The section: cylinder at the bottom, taper at half height, sphere inside and outside."""
    s, outer = METRE * math.sin(math.pi / 4), 1.4 * METRE
    top, waist = s + 1.09 * METRE, s + 0.69 * METRE
    shoulder = (math.sqrt(outer**2 - s**2), s)
    eighth = math.pi / 4
    return (
        Side(Line((METRE, 0.0), (outer, 0.0)), Surface.ROLLER),
        Side(Arc((0.0, 0.0), outer, 0.0, math.asin(s / outer)), Surface.FREE),
        Side(Line(shoulder, (METRE, waist)), Surface.FREE),
        Side(Line((METRE, waist), (METRE, top)), Surface.FREE),
        Side(Line((METRE, top), (s, top)), Surface.ROLLER),
        Side(Line((s, top), (s, s)), Surface.FREE),
        Side(Arc((0.0, 0.0), METRE, eighth, -eighth), Surface.INNER),
    )


def meshed(size: float) -> TetMesh:
    """Mesh with elements of `size`, and of a quarter of it at the inner sphere."""
    return mesh_body(Revolution(meridian()), size, fine={Surface.INNER: Fine(size / 4)})


def loaded(mesh: TetMesh) -> LoadedBody:
    """Apply loads and boundary conditions."""
    forces = thermal_forces(mesh, STEEL, EXPANSION, temperature)
    # z = 0 is constrained but is not a mirror plane: the temperature would have a kink there.
    return LoadedBody(mesh, STEEL, forces, held(mesh, {Surface.ROLLER: (2,)}))


def compute(size: float) -> Computed:
    """Solve with elements of `size` (see `meshed`)."""
    solved = loaded(meshed(size)).solved()
    mesh = solved.mesh
    A = solved.node_at(METRE, 0.0, 0.0)
    beta = thermal_modulus(STEEL, EXPANSION)
    at_A = float(solved.stress[A, 2] - beta * temperature(mesh.points[A : A + 1])[0])
    return Computed({GOAL.quantity: at_A}, solved.dofs)


BENCHMARK = Benchmark(
    title="NAFEMS LE11: solid cylinder, taper and sphere with a temperature field",
    source="NAFEMS, The Standard NAFEMS Benchmarks, TNSB rev. 3 (1990), LE11",
    goals=(GOAL,),
    compute=compute,
    size=100.0,
)
