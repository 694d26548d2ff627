"""What acts between separate bodies, as unknowns on the cell: in bores, between mating faces, along bolts.

Pressures on a surface are linear over each facet and belong to its vertices, while the displacement is
quadratic. The moments of the linear functions are all positive, those of the quadratic ones are not: a
uniform pressure on a facet of six nodes has no nodal force at its vertices, so that contact conditions at
single nodes of quadratic elements go wrong (Hüeber & Wohlmuth 2005; Wriggers 2006, section 9.3).

Mating faces have matching facets, so that the pressures at the vertices of one side act on both, and their
moments are those of the gap between the sides. Friction acts along two tangents of the face. Bolts are in
`fea.contact.bolts`.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse

from fea.contact.elastic_pin import Deflection, Pin
from fea.solid.assembly import tabulate
from fea.solid.bore import facet_areas
from fea.solid.parity import Parity
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import Surface
from mesh.tetmesh import FACET_EDGES, FACET_TURN, TetMesh

# Harmonics of an elastic pin's deflection, at least and at most: facets follow none that are finer.
FEWEST, HARMONICS = 16, 64
# Enough for linear times quadratic functions on a curved facet, and for the harmonics of an elastic pin.
_DEGREE = 12
_Z = np.array([0.0, 0.0, 1.0])

# From places (…, 3) on the surface to unit directions (…, 3) into the body, in which a pressure pushes.
Direction = Callable[[Floats], Floats]


@dataclass(frozen=True)
class Multipliers:
    """Pressures on one surface of a cell, linear over its facets."""

    surface: Surface
    facets: Ints  #: (n_facets, n_facet_nodes) nodes of the cell
    nodes: Ints  #: (n,) their vertices in ascending order: the nodes of the cell that the pressures belong to
    corners: Ints  #: (n_facets, 3) vertices of each facet, as positions in `nodes`
    places: Floats  #: (n_facets, n_points, 3) quadrature points, mm
    areas: Floats  #: (n_facets, n_points) weight times area, mm²
    direction: Direction  #: in which a pressure pushes
    on_y: Mask  #: (n,) which of the vertices lie on the mirror plane y = 0 that the cell is cut at

    @classmethod
    def of(cls, mesh: TetMesh, surface: Surface, direction: Direction) -> "Multipliers":
        """Set up the pressures on a surface of a cell."""
        facets = mesh.facets[surface]
        nodes, corners = np.unique(facets[:, :3], return_inverse=True)
        table = tabulate(facets.shape[1], _DEGREE)
        at = mesh.points[facets]
        return cls(
            surface=surface,
            facets=facets,
            nodes=nodes,
            corners=corners.reshape(-1, 3),
            places=table.values @ at,
            areas=facet_areas(at, table.gradients) * table.weights,
            direction=direction,
            on_y=np.isin(nodes, mesh.facets.get(Surface.SYMMETRY_Y, ())),
        )

    @property
    def size(self) -> int:
        """Number of pressures on the cell."""
        return len(self.nodes)

    @cached_property
    def directions(self) -> Floats:
        """Direction at the quadrature points, (n_facets, n_points, 3)."""
        return self.direction(self.places)

    @cached_property
    def averaging(self) -> sparse.csr_array:
        """Matrix (n, n_facets n_points) that gives ∫ φ f dA with the function φ of each vertex."""
        linear = tabulate(3, _DEGREE).values
        local = self.areas[:, :, None] * linear
        points = np.arange(self.areas.size).reshape(*self.areas.shape, 1)
        rows, columns = np.broadcast_arrays(self.corners[:, None], points)
        shape = (self.size, self.areas.size)
        return sparse.csr_array((local.ravel(), (rows.ravel(), columns.ravel())), shape=shape)

    def moments(self, field: Floats) -> Floats:
        """∫ φ f dA (n, …) of a field f at the quadrature points, (n_facets, n_points, …)."""
        flat = self.averaging @ field.reshape(self.areas.size, -1)
        return np.asarray(flat.reshape(self.size, *field.shape[2:]))

    @cached_property
    def weights(self) -> Floats:
        """∫ φ dA of each vertex (n,), mm²."""
        return self.moments(np.ones_like(self.areas))

    def forces(self, n_nodes: int) -> sparse.csr_array:
        """Nodal forces (3 n_nodes, n) of a pressure of 1 MPa at each vertex, N."""
        linear, values = (tabulate(count, _DEGREE).values for count in (3, self.facets.shape[1]))
        local = np.einsum("fq,qc,qa,fqd->fcad", self.areas, linear, values, self.directions, optimize=True)
        rows = 3 * self.facets[:, None, :, None] + np.arange(3)
        columns = np.broadcast_to(self.corners[:, :, None, None], local.shape)
        rows = np.broadcast_to(rows, local.shape)
        shape = (3 * n_nodes, self.size)
        return sparse.csr_array((local.ravel(), (rows.ravel(), columns.ravel())), shape=shape)

    @cached_property
    def _nodes(self) -> tuple[Ints, Ints]:
        """Nodes (m,) of the facets, and the place of each facet's nodes among them."""
        nodes, local = np.unique(self.facets, return_inverse=True)
        return nodes, local.reshape(self.facets.shape)

    def at_nodes(self, pressure: Floats) -> tuple[Ints, Floats]:
        """Nodes (m,) of the facets, and the values (m, k) there of pressures (n, k)."""
        nodes, local = self._nodes
        nodal = np.zeros((len(nodes), pressure.shape[1]))
        nodal[local[:, :3]] = pressure[self.corners]
        for middle, ends in zip(local[:, 3:].T, FACET_EDGES, strict=False):
            nodal[middle] = nodal[local[:, ends]].mean(axis=1)
        return nodes, nodal


class ContactInterface(ABC):
    """Unknowns of one kind on the cell: stresses on a surface, and against it on one that mates with it."""

    opposite: tuple[Surface, Ints] | None = None

    @property
    @abstractmethod
    def kinds(self) -> tuple[tuple[Multipliers, Ints], ...]:
        """Stresses on the surface, pressures first, each with the vertices (m,) that have it."""

    @property
    def pressing(self) -> Multipliers:
        """The pressures on the surface."""
        return self.kinds[0][0]

    @property
    def size(self) -> int:
        """Number of unknowns on the cell."""
        return sum(len(vertices) for _, vertices in self.kinds)

    @property
    def on_y(self) -> Mask:
        """Which unknowns (size,) are at places on y = 0."""
        return np.concatenate([kind.on_y[vertices] for kind, vertices in self.kinds])

    @property
    def across(self) -> Mask:
        """Which unknowns (size,) reverse under reflection about y = 0 where they lie on it."""
        return np.zeros(self.size, dtype=bool)

    @property
    def nodes(self) -> Ints:
        """Node (size,) of the cell at which each unknown acts; −1 where it acts at many."""
        return np.concatenate([kind.nodes[vertices] for kind, vertices in self.kinds])

    def sides(self, kind: Multipliers) -> list[tuple[Multipliers, float]]:
        """The surface and the one opposite with a stress on them, and its sign there."""
        if self.opposite is None:
            return [(kind, 1.0)]
        surface, facets = self.opposite
        return [(kind, 1.0), (replace(kind, surface=surface, facets=facets), -1.0)]

    def forces(self, n_nodes: int) -> sparse.csr_array:
        """Nodal forces (3 n_nodes, size) of a unit of each unknown, N."""
        columns = []
        for kind, vertices in self.kinds:
            first, *others = (sign * side.forces(n_nodes) for side, sign in self.sides(kind))
            columns.append(sum(others, first)[:, vertices])
        return sparse.csr_array(sparse.hstack(columns))

    def initial(self) -> Floats:
        """Moments (size,) of the gap as made."""
        return np.zeros(self.size)

    def flexibility(self, parity: Parity) -> Floats | float:  # noqa: ARG002
        """Moments (size, size) of what a unit of each moves beside the body; 0 for nothing."""
        return 0.0

    def traction(self, values: Floats, points: Floats) -> dict[Surface, Floats]:
        """Traction (n_nodes, 3, k) on each surface of unknowns (size, k), MPa."""
        ends = np.cumsum([len(vertices) for _, vertices in self.kinds])
        tractions = {}
        for side, sign in self.sides(self.pressing):
            tractions[side.surface] = traction = np.zeros((len(points), 3, values.shape[1]))
            for (kind, vertices), stress in zip(self.kinds, np.split(values, ends[:-1]), strict=True):
                every = np.zeros((kind.size, values.shape[1]))
                every[vertices] = stress
                nodes, nodal = side.at_nodes(every)
                traction[nodes] += sign * nodal[:, None] * kind.direction(points[nodes])[..., None]
        return tractions

    def pressure(self, values: Floats, n_nodes: int) -> dict[Surface, Floats]:
        """Pressure (n_nodes,) on each surface of unknowns (size,), MPa; 0 beside the surface."""
        pressures = {}
        for side, _ in self.sides(self.pressing):
            nodes, nodal = side.at_nodes(values[: side.size, None])
            pressures[side.surface] = np.zeros(n_nodes)
            pressures[side.surface][nodes] = nodal[:, 0]
        return pressures


@dataclass(frozen=True)
class PinInBore(ContactInterface):
    """A pin in a bore whose axis is parallel to z."""

    multipliers: Multipliers  #: the pressures on the bore
    center: tuple[float, float]  #: (x, z) of the middle of the bore and of the pin, mm
    clearance: float  #: radius of the bore minus that of the pin, mm; negative for a press fit
    pin: Pin | None  #: None for a rigid one
    #: cut_y, cut_z: whether the cell represents its mirror images about y = 0, z = 0
    cut_y: bool
    cut_z: bool
    #: Length and radial depth of the relief at either end of the bore, mm: it widens like a parabola
    relief: tuple[float, float] | None = None
    as_drawn: bool = False  #: whether the bore widens by itself, as its mesh shows
    #: Highest one of an elastic pin's deflection; by default what the facets can follow
    harmonics: int | None = None

    @property
    def kinds(self) -> tuple[tuple[Multipliers, Ints], ...]:
        """Pressures alone, at all vertices."""
        return ((self.multipliers, np.arange(self.multipliers.size)),)

    def flexibility(self, parity: Parity) -> Floats | float:
        """Moments (size, size) of the deflection of an elastic pin under unit pressures."""
        return 0.0 if self.deflection is None else self.deflection.compliance[parity]

    def initial(self) -> Floats:
        """Moments (n,) of the gap around the centred pin, as both are made."""
        gap = np.full_like(self.multipliers.areas, self.clearance)
        if self.relief is not None:
            length, depth = self.relief
            off = np.abs(self.multipliers.places[..., 2] - self.center[1])
            gap += depth * np.maximum(0.0, 1 - (off.max() - off) / length) ** 2
        if self.as_drawn:
            x, y, _ = np.moveaxis(self.multipliers.places, -1, 0)
            radius = np.hypot(x - self.center[0], y)
            gap += radius - radius.min()
        return self.multipliers.moments(gap)

    def harmonic(self, order: int, field: Floats) -> dict[Parity, Floats]:
        """Moments (n, k) of cos nφ and of sin nφ times fields (n_facets n_points, k)."""
        waves = {Parity.SYMMETRIC: np.cos, Parity.ANTISYMMETRIC: np.sin}
        average, turned = self.multipliers.averaging, order * self._angle
        return {parity: average @ (wave(turned)[:, None] * field) for parity, wave in waves.items()}

    def resolved(self) -> int:
        """Number of equilateral facets around the bore: its facets follow no higher harmonics."""
        side = np.sqrt(4 / np.sqrt(3) * self.multipliers.areas.sum(axis=1).mean())
        x, y, _ = self.multipliers.places.reshape(-1, 3).T
        radius = float(np.hypot(x - self.center[0], y).mean())
        return int(np.clip(2 * np.pi * radius / side, FEWEST, HARMONICS))

    @cached_property
    def _angle(self) -> Floats:
        x, y, _ = self.multipliers.places.reshape(-1, 3).T
        return np.asarray(np.arctan2(y, x - self.center[0]))

    def shifted(self) -> tuple[Floats, Floats]:
        """Moments (n,) of the radial part of a unit shift of the pin along x, and along y."""
        waves = self.harmonic(1, np.ones((len(self._angle), 1)))
        return waves[Parity.SYMMETRIC][:, 0], waves[Parity.ANTISYMMETRIC][:, 0]

    def tilted(self) -> tuple[Floats, Floats]:
        """Moments (n,) of the radial part of a unit turn of the rod about x, and about y."""
        waves = self.harmonic(1, self.multipliers.places[..., 2].reshape(-1, 1))
        return -waves[Parity.ANTISYMMETRIC][:, 0], waves[Parity.SYMMETRIC][:, 0]

    @cached_property
    def deflection(self) -> Deflection | None:
        """How the pin gives way, on the cell; None for a rigid one."""
        if self.pin is None:
            return None
        harmonics = self.harmonics or self.resolved()
        z = self.multipliers.places[..., 2].ravel() - self.center[1]
        return Deflection.of(self.pin, harmonics, z, self.harmonic, cut_y=self.cut_y, cut_z=self.cut_z)


@dataclass(frozen=True)
class MatingFaces(ContactInterface):
    """The two sides of an interface on the cell: pressures, then, with friction, shear stresses.

    Positive, they push the first side along their direction and the second side against it.
    """

    name: str  #: of the interface
    #: Pressures on the first side, then shear stresses along z and along the tangent square to it, which
    #: reverses under reflection about y = 0; each with the vertices (m,) that have it
    stresses: tuple[tuple[Multipliers, Ints], ...]
    #: The surface of the second side, and (n_facets, n_facet_nodes) its facets in the order of the first
    opposite: tuple[Surface, Ints]
    #: By how much the parts overlap before they are put together, normal to the face, mm
    interference: float = 0.0

    @classmethod
    def of(
        cls,
        mesh: TetMesh,
        sides: tuple[Surface, Surface],
        direction: Direction,
        *,
        interference: float = 0.0,
        friction: bool = True,
    ) -> "MatingFaces":
        """Set up an interface between two surfaces of a cell, as `mesh.tetmesh.separated` leaves them.

        A pressure pushes the first side in the `direction`, which is square to z.
        """
        first, second = sides
        pressing, facets = Multipliers.of(mesh, first, direction), mesh.facets[second]
        every = np.arange(pressing.size)
        frictional = every if friction else every[:0]
        # The shear stress along z of a field that is symmetric about z = 0 vanishes there.
        free = ~np.isin(pressing.nodes, mesh.facets.get(Surface.SYMMETRY_Z, ()))
        kinds = (
            (pressing, every),
            (replace(pressing, direction=uniform(_Z)), frictional[free[frictional]]),
            (replace(pressing, direction=lambda places: np.cross(_Z, direction(places))), frictional),
        )
        return cls(str(first), kinds, (second, facets[:, FACET_TURN[facets.shape[1]]]), interference)

    @property
    def kinds(self) -> tuple[tuple[Multipliers, Ints], ...]:
        """Pressures and shear stresses."""
        return self.stresses

    @property
    def across(self) -> Mask:
        """Which unknowns (size,) reverse under reflection about y = 0 where they lie on it."""
        return np.arange(self.size) >= self.size - len(self.kinds[-1][1])

    @property
    def tangential(self) -> tuple[Ints, Ints]:
        """Per vertex (m,) the numbers of its shear stresses among the unknowns; −1 where it has none."""
        numbers, start = np.full((2, self.pressing.size), -1), self.pressing.size
        for number, (_, vertices) in zip(numbers, self.kinds[1:], strict=True):
            number[vertices] = start + np.arange(len(vertices))
            start += len(vertices)
        return numbers[0], numbers[1]

    @property
    def mates(self) -> Ints:
        """Nodes (n,) of the second side, opposite to those of the pressures."""
        mates = np.empty(self.pressing.size, dtype=np.int64)
        mates[self.pressing.corners] = self.opposite[1][:, :3]
        return mates

    def initial(self) -> Floats:
        """Moments (size,) of the gap between the parts as made."""
        return np.pad(-self.interference * self.pressing.weights, (0, self.size - self.pressing.size))


def uniform(vector: Floats) -> Direction:
    """Return the same direction everywhere."""
    return lambda places: np.broadcast_to(vector, places.shape)


def radial(center_x: float) -> Direction:
    """Exact radius from the axis of a bore that is parallel to z and passes through (`center_x`, 0)."""

    def direction(places: Floats) -> Floats:
        away = places * [1.0, 1.0, 0.0] - [center_x, 0.0, 0.0]
        return np.asarray(away / np.linalg.norm(away, axis=-1, keepdims=True))

    return direction
