"""Lamé's thick cylinder under internal pressure in plane strain: hoop stress and displacement of the bore."""

import math

import numpy as np

from fea.solid.traction import nodal_traction, traction_forces
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, LoadedBody, furthest, held, nodes_of
from geometry.arrays import Floats
from geometry.bodies import Prism, Side
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from mesh.generate import Fine, mesh_body
from mesh.tetmesh import TetMesh

INSIDE, OUTSIDE, THICKNESS, PRESSURE = 10.0, 20.0, 3.0, 100.0
_A2, _B2 = INSIDE**2, OUTSIDE**2
_WIDENING = (
    (1 + STEEL.poissons_ratio)
    / STEEL.youngs_modulus
    * PRESSURE
    * INSIDE
    * ((1 - 2 * STEEL.poissons_ratio) * _A2 + _B2)
    / (_B2 - _A2)
)

HOOP = Goal(
    "hoop stress at the bore, worst node",
    "MPa",
    PRESSURE * (_B2 + _A2) / (_B2 - _A2),
    0.2,
    "the solution is exact; this is the error of the recovered stress at this size, at the worst node",
)
WIDENING = Goal(
    "radial displacement of the bore, worst node",
    "mm",
    _WIDENING,
    0.02,
    "the solution is exact, and displacements converge one order faster than stress",
)


def loaded(size: float, order: int = 2) -> LoadedBody:
    """A slice of a quarter, with elements of `size` at the outside and half of it at the bore."""
    quarter = math.pi / 2
    sides = (
        Side(Line((INSIDE, 0.0), (OUTSIDE, 0.0)), Surface.SYMMETRY_Y),
        Side(Arc((0.0, 0.0), OUTSIDE, 0.0, quarter), Surface.OUTER),
        Side(Line((0.0, OUTSIDE), (0.0, INSIDE)), Surface.SYMMETRY_X),
        Side(Arc((0.0, 0.0), INSIDE, quarter, -quarter), Surface.INNER),
    )
    body = Prism(sides, (0.0, THICKNESS), top=Surface.ROLLER)
    mesh = mesh_body(body, size, order=order, fine={Surface.INNER: Fine(size / 2)})
    forces = traction_forces(mesh, Surface.INNER, lambda _, normals: -PRESSURE * normals)
    radial = np.array([PRESSURE, PRESSURE, 0.0]) / INSIDE
    pressed = nodal_traction(mesh, Surface.INNER, lambda places: radial * places)
    known, fixed = (Surface.INNER, Surface.OUTER), held(mesh, {Surface.ROLLER: (2,)})
    return LoadedBody(mesh, STEEL, forces, fixed, known, {Surface.INNER: pressed})


def worst_hoop(mesh: TetMesh, stress: Floats) -> float:
    """Hoop stress at the bore that is furthest from the exact one, from nodal stress (n_nodes, 6)."""
    # At the mirror plane. On the opposite face, also a mirror plane of the problem, recovery uses one side
    # only.
    bore = nodes_of(mesh, Surface.INNER, Surface.SYMMETRY_Z)
    x, y, _ = mesh.points[bore].T / INSIDE
    xx, yy, _, xy, _, _ = stress[bore].T
    return furthest(xx * y**2 + yy * x**2 - 2 * xy * x * y, HOOP.target)


def compute(size: float) -> Computed:
    """Solve with elements of `size`."""
    solved = loaded(size).solved()
    mesh, u = solved.mesh, solved.displacement
    bore = nodes_of(mesh, Surface.INNER, Surface.SYMMETRY_Z)
    x, y, _ = mesh.points[bore].T / INSIDE
    widening = x * u[bore, 0, 0] + y * u[bore, 1, 0]
    found = {
        HOOP.quantity: worst_hoop(mesh, solved.stress),
        WIDENING.quantity: furthest(widening, WIDENING.target),
    }
    return Computed(found, solved.dofs)


BENCHMARK = Benchmark(
    title="Lamé: thick cylinder under internal pressure, plane strain",
    source="Lamé 1852; Timoshenko & Goodier 1970, article 28",
    goals=(HOOP, WIDENING),
    compute=compute,
    size=0.9,
)
