"""Goodier's spherical cavity in an infinite body under tension: stress at the equator and at the pole.

The model is an eighth of a ball around the cavity, with the exact tractions on its outside, so that the size
of the ball does not matter.
"""

import math

import numpy as np
import numpy.typing as npt

from fea.solid.element import stress_from_gradient
from fea.solid.traction import traction_forces
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, LoadedBody, furthest, held, nodes_of
from geometry.arrays import Floats
from geometry.bodies import Revolution, Side
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from mesh.generate import Fine, mesh_body
from mesh.tetmesh import TetMesh

Complexes = npt.NDArray[np.complex128]

RADIUS, OUTSIDE, TENSION = 1.0, 4.0, 100.0
PIECES = 8
_NU = STEEL.poissons_ratio

EQUATOR = Goal(
    "σxx at the equator, worst node",
    "MPa",
    TENSION * (27 - 15 * _NU) / (2 * (7 - 5 * _NU)),
    0.2,
    "the solution is exact; this is the error of the recovered stress at this size, at the worst node",
)
POLE = Goal(
    "σyy at the pole",
    "MPa",
    -TENSION * (3 + 15 * _NU) / (2 * (7 - 5 * _NU)),
    0.2,
    "the solution is exact; the stress at the pole is a third of that at the equator, so that the same error "
    "counts three times as much",
)


def exact_displacement(places: Complexes) -> Complexes:
    """Displacement (n, 3), mm, under tension along x (Goodier 1933), analytic in the places (n, 3)."""
    mu, nu, E = STEEL.shear_modulus, STEEL.poissons_ratio, STEEL.youngs_modulus
    b = TENSION / (8 * mu * (7 - 5 * nu))
    a, c = -(13 - 10 * nu) * b, 5 * (1 - 2 * nu) * b
    x, y, z = places.T / RADIUS
    s2 = y * y + z * z
    r = np.sqrt(x * x + s2)
    cos2 = (x * x - s2) / r**2
    radial = -a / r**2 - 3 * b / r**4 + ((5 - 4 * nu) / (1 - 2 * nu) * c / r**2 - 9 * b / r**4) * cos2
    # u_θ = −(2C/r² + 6B/r⁴) sin 2θ, divided by sin θ cos θ to stay analytic on the axis.
    around = -2 * (2 * c / r**2 + 6 * b / r**4)
    along = radial * x / r - around * s2 / r**2 * x / r
    across = radial / r + around * (x / r) ** 2 / r
    far = TENSION / E * np.stack([x, -nu * y, -nu * z], axis=1)
    return np.asarray(RADIUS * (far + np.stack([along, across * y, across * z], axis=1)))


def exact_stress(places: Floats) -> Floats:
    """Stress (n, 6), MPa, by complex steps (Squire & Trapp 1998)."""
    step = 1e-30
    columns = [exact_displacement(places + 1j * step * axis).imag / step for axis in np.eye(3)]
    return stress_from_gradient(np.stack(columns, axis=-1), STEEL)


def _traction(places: Floats, normals: Floats) -> Floats:
    xx, yy, zz, xy, yz, xz = exact_stress(places).T
    tensor = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=1).reshape(-1, 3, 3)
    return np.asarray((tensor @ normals[:, :, None])[:, :, 0])


def loaded(size: float, order: int = 2) -> LoadedBody:
    """The eighth of a ball, with elements of `size` at the cavity."""
    quarter = math.pi / 2
    sides = (
        Side(Line((RADIUS, 0.0), (OUTSIDE, 0.0)), Surface.SYMMETRY_Z),
        Side(Arc((0.0, 0.0), OUTSIDE, 0.0, quarter), Surface.OUTER),
        Side(Line((0.0, OUTSIDE), (0.0, RADIUS)), Surface.FREE),  # on the axis
        # In pieces, because element sizes depend on the distance to the edges of faces.
        *(
            Side(Arc((0.0, 0.0), RADIUS, quarter * (1 - k / PIECES), -quarter / PIECES), Surface.INNER)
            for k in range(PIECES)
        ),
    )
    cavity = Fine(size, quarter * RADIUS / PIECES / 2)
    fine = {Surface.INNER: cavity}
    mesh = mesh_body(Revolution(sides), 18 * size, order=order, fine=fine, growth=0.35)
    forces = traction_forces(mesh, Surface.OUTER, _traction)
    return LoadedBody(mesh, STEEL, forces, held(mesh, {}), (Surface.INNER,))


def worst_equator(mesh: TetMesh, stress: Floats) -> float:
    """The σxx at the equator that is furthest from the exact one, from nodal stress (n_nodes, 6)."""
    equator = nodes_of(mesh, Surface.INNER, Surface.SYMMETRY_X)
    return furthest(stress[equator, 0], EQUATOR.target)


def compute(size: float) -> Computed:
    """Solve with elements of `size` at the cavity."""
    solved = loaded(size).solved()
    found = {
        EQUATOR.quantity: worst_equator(solved.mesh, solved.stress),
        POLE.quantity: float(solved.stress[solved.node_at(RADIUS, 0.0, 0.0), 1]),
    }
    return Computed(found, solved.dofs)


BENCHMARK = Benchmark(
    title="Goodier: spherical cavity under remote tension",
    source="Goodier 1933, Trans. ASME 55, 39-44; Timoshenko & Goodier 1970, chapter 12",
    goals=(EQUATOR, POLE),
    compute=compute,
    size=0.04,
)
