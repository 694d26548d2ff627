"""Bodies of the benchmark cases: shapes, boundary conditions, solution, stress, contact with a pin."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, reduce
from itertools import pairwise

import numpy as np
from scipy import sparse

from fea.base.choices import Support
from fea.base.material import Material
from fea.contact.active_set import Contact
from fea.contact.interfaces import PinInBore
from fea.contact.problem import ContactProblem
from fea.solid.assembly import pattern, stiffness
from fea.solid.parity import Parity, Split
from fea.solid.recovery import Recovery
from fea.solvers.constrained import displacement
from fea.solvers.linear.choice import direct_solver
from fea.solvers.static import Model, unheld
from geometry.arrays import Floats, Ints, Mask
from geometry.bodies import Revolution, Side, polygon
from geometry.segments import Arc, Line
from geometry.surfaces import PLANE_AXIS, Surface
from mesh.tetmesh import TetMesh

# The material of the NAFEMS benchmarks and most others; only some cases use density and strength.
STEEL = Material(youngs_modulus=210e3, poissons_ratio=0.3, density=7.85e-9, yield_strength=400.0)


def rectangle(
    x: tuple[float, float], y: tuple[float, float], names: tuple[Surface, Surface, Surface, Surface]
) -> tuple[Side, ...]:
    """Sides of a rectangle: at the least y, the greatest x, the greatest y and the least x."""
    corners = ((x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1]))
    return polygon(*zip(corners, names, strict=True))


def quarter_ring(inner: float, outer: float) -> tuple[Side, ...]:
    """Sides of a quarter between two circles: on y = 0, outside, on x = 0, inside."""
    quarter = math.pi / 2
    return (
        Side(Line((inner, 0.0), (outer, 0.0)), Surface.SYMMETRY_Y),
        Side(Arc((0.0, 0.0), outer, 0.0, quarter), Surface.OUTER),
        Side(Line((0.0, outer), (0.0, inner)), Surface.SYMMETRY_X),
        Side(Arc((0.0, 0.0), inner, quarter, -quarter), Surface.INNER),
    )


def half_ring(inner: float, outer: float, *between: float) -> tuple[Side, ...]:
    """Sides of a half between two circles: on y = 0, inside, on y = 0, divided `between` them, outside."""
    ends = (inner, *between, outer)
    return (
        Side(Line((-outer, 0.0), (-inner, 0.0)), Surface.SYMMETRY_Y),
        Side(Arc((0.0, 0.0), inner, math.pi, -math.pi), Surface.INNER),
        *(Side(Line((a, 0.0), (b, 0.0)), Surface.SYMMETRY_Y) for a, b in pairwise(ends)),
        Side(Arc((0.0, 0.0), outer, 0.0, math.pi), Surface.OUTER),
    )


def eighth_ball(inner: float, outer: float, pieces: int = 1) -> Revolution:
    """An eighth between two spheres, whose faces inside are divided in so many `pieces`."""
    quarter = math.pi / 2
    inside = (Arc((0.0, 0.0), inner, quarter * (1 - k / pieces), -quarter / pieces) for k in range(pieces))
    return Revolution(
        (
            Side(Line((inner, 0.0), (outer, 0.0)), Surface.SYMMETRY_Z),
            Side(Arc((0.0, 0.0), outer, 0.0, quarter), Surface.OUTER),
            Side(Line((0.0, outer), (0.0, inner)), Surface.FREE),  # on the axis
            *(Side(arc, Surface.INNER) for arc in inside),
        )
    )


def uniform(*vector: float) -> Callable[..., Floats]:
    """Return the field (…, 3) of a vector at places (…, 3), whatever the normals there."""
    return lambda places, _normals=None: np.broadcast_to(vector, places.shape)


def pressure(size: float) -> Callable[[Floats, Floats], Floats]:
    """Return the traction of a pressure, MPa, at places with outward normals."""
    return lambda _, normals: -size * normals


def held(mesh: TetMesh, supports: Mapping[Surface, tuple[int, ...]]) -> Mask:
    """Degrees of freedom (n_nodes, 3) fixed by the mirror planes and, by axes, on other surfaces."""
    fixed = np.zeros((len(mesh.points), 3), dtype=bool)
    planes = {plane: (PLANE_AXIS[plane],) for plane in mesh.planes}
    for surface, axes in (planes | dict(supports)).items():
        for axis in axes:
            fixed[mesh.facets[surface].ravel(), axis] = True
    return fixed


def nodes_of(mesh: TetMesh, *surfaces: Surface) -> Ints:
    """Nodes that lie on every one of the surfaces."""
    return reduce(np.intersect1d, (mesh.facets[surface] for surface in surfaces), np.arange(len(mesh.points)))


def furthest(values: Floats, target: float) -> float:
    """The value that is furthest from the target."""
    return float(values[np.abs(values - target).argmax()])


def hoop_stress(points: Floats, stress: Floats) -> Floats:
    """Stress (n,) around the axis z at places (n, 3), from stress (n, 6)."""
    angle = np.arctan2(points[:, 1], points[:, 0])
    xx, yy, _, xy, _, _ = stress.T
    return np.asarray(xx * np.sin(angle) ** 2 + yy * np.cos(angle) ** 2 - xy * np.sin(2 * angle))


@dataclass(frozen=True)
class LoadedBody:
    """A body with its loads and constraints."""

    mesh: TetMesh
    material: Material
    #: forces, fixed: (n_nodes, 3) nodal forces, N, and constrained degrees of freedom
    forces: Floats
    fixed: Mask
    known: tuple[Surface, ...] = ()  #: surfaces of known traction
    traction: Mapping[Surface, Floats] | None = None  #: of the loaded surfaces, (n_nodes, 3, 1), MPa

    def solved(self) -> "SolvedBody":
        """Solve it."""
        u = displacement(self.mesh, self.material, self.forces, self.fixed)
        return SolvedBody(self.mesh, self.material, u, self.known, self.traction)


@dataclass(frozen=True)
class SolvedBody:
    """A body with its displacement."""

    mesh: TetMesh
    material: Material
    #: (n_nodes, 3, 1), mm, symmetric about the mirror planes, except about y = 0 if `parity` differs
    displacement: Floats
    known: tuple[Surface, ...] = ()  #: surfaces of known traction
    traction: Mapping[Surface, Floats] | None = None  #: of the loaded surfaces, (n_nodes, 3, 1), MPa
    parity: Parity = Parity.SYMMETRIC  #: about y = 0

    @property
    def dofs(self) -> int:
        """Degrees of freedom of the mesh."""
        return self.mesh.points.size

    @cached_property
    def stress(self) -> Floats:
        """Stress, recovered as in a run: (n_nodes, 6), MPa, components XX YY ZZ XY YZ XZ."""
        recovery = Recovery(self.mesh, self.mesh.planes, self.known)
        nodal = recovery.nodal_stress(self.displacement, self.material, self.parity, self.traction)
        return np.asarray(nodal[:, :, 0])

    def node_at(self, *place: float) -> int:
        """Node at a corner of the body."""
        away = np.linalg.norm(self.mesh.points - place, axis=1)
        nearest = int(away.argmin())
        # The point of a benchmark is a corner of its geometry, so that there is a node.
        assert away[nearest] < 1e-6 * np.ptp(self.mesh.points)  # noqa: S101
        return nearest


def relieved(mesh: TetMesh, load: Split, parity: Parity = Parity.SYMMETRIC) -> Floats:
    """Displacement (n_nodes, 3, 1) of a free steel body under a load that balances its inertia."""
    solution = Model(mesh, STEEL, Support.INERTIA_RELIEF).solve([load])
    return solution.displacement[parity]


class TouchedBody:
    """A body, symmetric about y = 0, with its constraints and the one pin that touches it.

    The constrained degrees of freedom `fixed` (n_nodes, 3) include those of the mirror planes.
    """

    def __init__(self, mesh: TetMesh, material: Material, fixed: Mask, pin: PinInBore) -> None:
        self.mesh, self._material, self._fixed, self._pin = mesh, material, fixed.ravel(), pin
        self._solver = direct_solver(slots=1)
        nothing = {Parity.SYMMETRIC: np.zeros((mesh.points.size, 0))}
        self.problem = ContactProblem(self, mesh, [pin], nothing, both_sides=False)

    def compliance(self, _parity: Parity, forces: sparse.csc_array) -> Floats:
        """Work (k, k) of symmetric forces (3 n_nodes, k) on what they cause."""
        K = stiffness(self.mesh, self._material, pattern(self.mesh.tets, len(self.mesh.points)))
        return self._solver.condense(0, K.constrained(self._fixed), unheld(forces, self._fixed))

    def touched(self, clearance: float, force: float) -> Contact:
        """Pressures (n,) at the vertices under a force along x on the whole body, N."""
        gap = self.problem.initial + (clearance - self._pin.clearance) * self._weights
        return self.problem.system.solve(gap, np.array([force]))

    @cached_property
    def _weights(self) -> Floats:
        return self.problem.unfolding.moments({Parity.SYMMETRIC: self._pin.multipliers.weights})

    def stress(self, pressure: Floats) -> Floats:
        """Nodal stress (n_nodes, 6) under pressures (n,), MPa."""
        n_nodes = len(self.mesh.points)
        forces = np.where(self._fixed, 0.0, self.problem.forces @ pressure)
        u = self._solver.solve(0, forces[:, None]).reshape(n_nodes, 3, 1)
        pressed = self.problem.traction(pressure[:, None])
        return np.asarray(self._recovery.nodal_stress(u, self._material, Parity.SYMMETRIC, pressed)[:, :, 0])

    @cached_property
    def _recovery(self) -> Recovery:
        return Recovery(self.mesh, self.mesh.planes, (self._pin.multipliers.surface,))


def contact_end(place: Floats, p: Floats) -> float:
    """Where the pressure (n,) at places (n,) ends: near it, its square is linear."""
    places = np.unique(np.round(place, 9))
    mean = np.array([p[np.abs(place - at) < 1e-8].mean() for at in places])
    last = np.flatnonzero(mean > 0)[-4:-1]
    return float(np.polyfit(mean[last] ** 2, places[last], 1)[1])
