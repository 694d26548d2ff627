"""The surface of a rod, numbered so that a page can rebuild its nodes from the corners of its facets.

Facets follow a space-filling curve; a vertex gets its number when the first facet mentions it, and the nodes
between two vertices follow in the order in which their edges appear. Every node then has two earlier ones
beside it, its parents, from which its values can be predicted (`fea.output.report.coding`).
"""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Ints
from mesh.tetmesh import FACET_EDGES, TetMesh, boundary_facets

# Beyond this number of surface nodes the nodes between vertices are left out, which makes a file a quarter as
# large.
MOST_NODES = 60_000
_MORTON_BITS = 10


@dataclass(frozen=True)
class NumberedSurface:
    """The surface in the order of a report."""

    nodes: Ints  #: (n,) node of the mesh of each node of the surface: vertices first
    facets: Ints  #: (n_facets, 3) vertices as numbers of `nodes`, outward orientation
    parents: Ints  #: (n, 2) two earlier nodes beside each; −1 where there is none
    middles: Ints | None = (
        None  #: (n_facets, 3) nodes between these, as numbers of `nodes`, where it has them
    )

    @classmethod
    def of(cls, mesh: TetMesh, most: int = MOST_NODES) -> "NumberedSurface":
        """Number the surface of a mesh; `most` nodes between vertices are kept."""
        facets = boundary_facets(mesh.tets)
        # Order (n,) of places along a space-filling curve (Morton 1966).
        points = mesh.points[facets[:, :3]].mean(axis=1)
        low, extent = points.min(axis=0), float(np.ptp(points, axis=0).max())
        cells = ((points - low) / (extent or 1.0) * (2**_MORTON_BITS - 1)).astype(np.int64)
        keys = np.zeros(len(points), np.int64)
        for bit in range(_MORTON_BITS):
            for axis in range(3):
                keys |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
        facets = facets[np.argsort(keys, kind="stable")]
        quadratic = facets.shape[1] == 6 and len(np.unique(facets)) <= most
        vertices, corners = _by_appearance(facets[:, :3])
        parents = _vertex_parents(corners, len(vertices))
        if not quadratic:
            return cls(vertices, corners, parents)
        middles, _ = _by_appearance(facets[:, 3:])
        number = np.zeros(int(facets.max()) + 1, np.int64)
        number[middles] = np.arange(len(middles))
        ends = np.empty((len(middles), 2), np.int64)
        ends[number[facets[:, 3:].ravel()]] = corners[:, FACET_EDGES].reshape(-1, 2)
        nodes, parents = np.concatenate([vertices, middles]), np.concatenate([parents, ends])
        return cls(nodes, corners, parents, len(vertices) + number[facets[:, 3:]])

    @property
    def order(self) -> int:
        """2 where nodes between vertices follow the vertices, otherwise 1."""
        return 1 if self.middles is None else 2

    def rows(self, row: Ints) -> tuple[Ints, Ints]:
        """Number rows of a table that several nodes may share, in the order in which nodes mention them.

        From the row (n,) of each node follow the old numbers (n_rows,) in the new order, and the parents
        (n_rows, 2) in the new numbers.
        """
        order, first, renumbered = _appearance(row)
        above = self.parents[first]
        parents = np.where(above >= 0, renumbered[above], -1)
        row = np.arange(len(order))[:, None]
        return order, np.where(parents >= row, row - 1, parents)


def _appearance(values: Ints) -> tuple[Ints, Ints, Ints]:
    """Distinct values in the order of appearance, where each appears first, and all by their new numbers."""
    found, first, inverse = np.unique(values, return_index=True, return_inverse=True)
    order = np.argsort(first)
    return found[order], first[order], np.argsort(order)[inverse.ravel()]


def _by_appearance(table: Ints) -> tuple[Ints, Ints]:
    order, _, renumbered = _appearance(table.ravel())
    return order, renumbered.reshape(table.shape)


def _vertex_parents(corners: Ints, count: int) -> Ints:
    """The vertices with smaller numbers in the facet that mentions a vertex first; else the one before."""
    _, first = np.unique(corners.ravel(), return_index=True)
    facet, row = corners[first // 3], np.arange(count)
    earlier = np.sort(np.where(facet < row[:, None], facet, -1), axis=1)[:, ::-1]
    one = np.where(earlier[:, 0] >= 0, earlier[:, 0], row - 1)
    other = np.where(earlier[:, 1] >= 0, earlier[:, 1], one)
    return np.stack([one, other], axis=1)
