"""Bodies of the benchmark cases: shapes, boundary conditions, solution, stress."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, reduce
from itertools import pairwise

import numpy as np

from fea.base.choices import Support
from fea.base.material import Material
from fea.solid.parity import Parity, ParityPair
from fea.solid.recovery import Recovery
from fea.solvers.static import Model, displacement
from geometry.arrays import Floats, Ints, Mask
from geometry.bodies import Revolution, Side, polygon
from geometry.segments import Arc, Line
from geometry.surfaces import PLANE_AXIS, Surface
from mesh.tetmesh import EDGES, TetMesh

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


def straightened(points: Floats, tets: Ints) -> Floats:
    """Return places (n_nodes, 3) with the middle nodes of elements (n, 4 or 10) on straight edges."""
    points = points.copy()
    for middle, (a, b) in enumerate(EDGES[: tets.shape[1] - 4], start=4):
        points[tets[:, middle]] = points[tets[:, [a, b]]].mean(axis=1)
    return points


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
        return self.with_displacement(displacement(self.mesh, self.material, self.forces, self.fixed))

    def with_displacement(self, u: Floats) -> "SolvedBody":
        """Return the body with a displacement (n_nodes, 3, 1), mm."""
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


def relieved(mesh: TetMesh, load: ParityPair, parity: Parity = Parity.SYMMETRIC) -> Floats:
    """Displacement (n_nodes, 3, 1) of a free steel body under a load that balances its inertia."""
    solution = Model(mesh, STEEL, Support.INERTIA_RELIEF).solve([load])
    return solution.displacement[parity]
