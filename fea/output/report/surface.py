"""The surface of a rod and its values as compact numbers for a page.

Facets follow a space-filling curve; a vertex gets its number when the first facet mentions it, and the nodes
between two vertices follow in the order in which their edges appear, so that a page can rebuild all nodes
from the corners of the facets. Every node then has two earlier ones beside it, its parents, from which its
values are predicted.

A value is low + step·q with q of 16 bits. Stored of q is its difference, modulo 2¹⁶, from the mean of its two
parents, as an unsigned number whose lowest bit is the sign, first the low bytes of all, then the high ones:
neighbours differ little, so that most high bytes are zero. All is deflated, and written in base64.
"""

import base64
import zlib
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from fea.output.json_file import JsonObject
from geometry.arrays import Floats, Ints
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


LEVELS = 2**16 - 2
# Stands for a value that there is none of.
HOLE = 2**16 - 1
# More effort than this makes a file a hundredth smaller, and writing it twice as long.
_EFFORT = 5
# Columns that are coded together.
_TOGETHER = 64


@dataclass
class Packer:
    """Collects arrays; `entries` says how each is read."""

    coarser: int = 1  #: how many times larger the steps are of what needs less than all `LEVELS`
    #: In the order of the arrays: ``name``, ``kind`` and ``count``, and for values ``columns``, ``low`` and
    #: ``step``
    entries: list[JsonObject] = field(default_factory=list)
    _pieces: list[bytes] = field(default_factory=list)

    def values(
        self, name: str, values: Floats, parents: Ints, *, levels: int = LEVELS, enough: Floats | None = None
    ) -> None:
        """Add values (n,) or (n, k), NaN where there is none, in so many steps from the least to the largest.

        The columns share their step; those that coarser ones are `enough` for (k,) have a multiple of it,
        which packs better. `parents` is (n, 2), or (0, 2) for values that do not hang together.
        """
        table = values.reshape(len(values), -1)
        known = table[np.isfinite(table)]
        low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
        levels = LEVELS if levels >= LEVELS else max(levels // self.coarser, 1)
        step = (high - low) / levels
        scaled = np.rint((np.where(np.isfinite(table), table, low) - low) / (step or 1.0)).astype(np.int32)
        if enough is not None:
            grain = 1 << np.log2(np.clip(enough / (step or 1.0), 1, levels / 8)).astype(np.int32)
            scaled = np.minimum((scaled + grain // 2) // grain * grain, levels // grain * grain)
        scaled[~np.isfinite(table)] = HOLE
        self._add({"name": name, "kind": "values", "low": low, "step": step}, scaled, parents)

    def steps(self, name: str, values: Floats, parents: Ints, step: float) -> None:
        """Add values (n, k) of either sign as multiples of a step, at most 2¹⁵ of it."""
        step *= self.coarser
        scaled = np.rint(values.reshape(len(values), -1) / step).astype(np.int32) + 2**15
        self._add({"name": name, "kind": "steps", "step": step}, scaled, parents)

    def integers(self, name: str, values: Ints) -> None:
        """Add non-negative numbers (n,) below 2³²: low bytes first."""
        flat = values.ravel().astype(np.uint32)
        self.entries.append({"name": name, "kind": "integers", "count": len(flat)})
        self._pieces.append(np.ascontiguousarray(flat.view(np.uint8).reshape(-1, 4).T).tobytes())

    def text(self) -> str:
        """Everything as text."""
        return base64.b64encode(zlib.compress(b"".join(self._pieces), _EFFORT)).decode()

    def _add(self, entry: JsonObject, scaled: npt.NDArray[np.int32], parents: Ints) -> None:
        count, columns = scaled.shape
        self.entries.append(entry | {"count": count, "columns": columns})
        for start in range(0, columns, _TOGETHER):
            own = np.ascontiguousarray(scaled[:, start : start + _TOGETHER].T)
            # Modulo 2¹⁶, with the sign in the lowest bit; of each row the low bytes, then the high ones.
            wrapped = (own - _predicted(own, parents)).astype(np.int16).astype(np.int32)
            zigzag = ((wrapped << 1) ^ (wrapped >> 31)).astype("<u2")
            bytes_ = zigzag.view(np.uint8).reshape(*zigzag.shape, 2)
            self._pieces.append(np.ascontiguousarray(np.moveaxis(bytes_, 2, 1)).tobytes())


def corner_steps(facets: Ints) -> Ints:
    """Corners (n, 3) as the distance below the next number that has not been used: 0 is a new vertex."""
    flat = facets.ravel()
    highest = np.maximum.accumulate(np.concatenate([[-1], flat[:-1]]))
    return np.asarray(highest + 1 - flat)


def _predicted(rows: npt.NDArray[np.int32], parents: Ints) -> npt.NDArray[np.int32]:
    if not len(parents):
        return np.zeros_like(rows)
    first, second = (rows[:, parent] for parent in np.maximum(parents, 0).T)
    return np.where(parents[:, 0] >= 0, (first + second) >> 1, 0).astype(np.int32)
