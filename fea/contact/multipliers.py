"""Contact pressures on a surface as multipliers at the vertices of its facets.

The pressure is linear over each facet, the displacement quadratic. The moments of the linear functions are
all positive, those of the quadratic ones are not: a uniform pressure on a facet of six nodes has no nodal
force at its vertices, so that contact conditions at single nodes of quadratic elements go wrong (Hüeber &
Wohlmuth 2005; Wriggers 2006, section 9.3).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from fea.solid.bore import facet_areas
from fea.solid.element import tabulate
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import Surface
from mesh.tetmesh import FACET_EDGES, TetMesh

# Enough for linear times quadratic functions on a curved facet, and for the harmonics of an elastic pin.
_DEGREE = 12

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

    def on_mesh(self, pressure: Floats, n_nodes: int) -> Floats:
        """Values (n_nodes,) of pressures (n,) at all nodes; 0 beside the facets."""
        nodes, values = self.at_nodes(pressure[:, None])
        field = np.zeros(n_nodes)
        field[nodes] = values[:, 0]
        return field


def uniform(vector: Floats) -> Direction:
    """Return the same direction everywhere."""
    return lambda places: np.broadcast_to(vector, places.shape)


def radial(center_x: float) -> Direction:
    """Exact radius from the axis of a bore that is parallel to z and passes through (`center_x`, 0)."""

    def direction(places: Floats) -> Floats:
        away = places * [1.0, 1.0, 0.0] - [center_x, 0.0, 0.0]
        return np.asarray(away / np.linalg.norm(away, axis=-1, keepdims=True))

    return direction
