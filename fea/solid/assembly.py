"""The stiffness matrix: sparsity once, numbers in dense batches, the upper triangle only."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import sparse

from fea.material import Material, Materials
from fea.solid.elasticity import node_pair_blocks
from fea.solid.integration import gauss_blocks, stiffness_degree
from mesh.tetmesh import TetMesh

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


@dataclass(frozen=True)
class SymmetricMatrix:
    """A symmetric matrix held by its upper triangle.

    Attributes
    ----------
    upper
        CSR upper triangle with the diagonal, sorted indices.
    """

    upper: sparse.csr_array

    @property
    def size(self) -> int:
        """Number of rows."""
        return int(self.upper.shape[0])

    def diagonal(self) -> Floats:
        """Diagonal entries."""
        return np.asarray(self.upper.diagonal())

    def __matmul__(self, vectors: Floats) -> Floats:
        """Product with a vector (n,) or a block of vectors (n, k)."""
        diagonal = self.diagonal().reshape(-1, *([1] * (vectors.ndim - 1)))
        return np.asarray(self.upper @ vectors + self.upper.T @ vectors - diagonal * vectors)

    def norm(self) -> float:
        """Largest absolute row sum."""
        magnitude = SymmetricMatrix(abs(self.upper))
        return float((magnitude @ np.ones(self.size)).max())

    def constrained(self, fixed: npt.NDArray[np.bool_]) -> "SymmetricMatrix":
        """Replace rows and columns of `fixed` degrees of freedom by their diagonal; the sparsity stays."""
        rows = np.repeat(np.arange(self.size), np.diff(self.upper.indptr))
        upper = self.upper
        keep = ~(fixed[rows] | fixed[upper.indices]) | (rows == upper.indices)
        data = np.where(keep, upper.data, 0.0)
        return SymmetricMatrix(sparse.csr_array((data, upper.indices, upper.indptr), upper.shape))


@dataclass(frozen=True)
class Pattern:
    """Where each element's node pairs go in the upper triangle.

    Attributes
    ----------
    node_order
        (n_elements, n_nodes) local nodes sorted by global number, so that every local pair a ≤ b is
        a pair of the upper triangle.
    scatter
        CSR (n_blocks, n_elements·n_pairs) of ones: sums element blocks into matrix blocks.
    gather
        Place in the flattened 3×3 blocks of each scalar entry of the upper triangle.
    indices, indptr
        The scalar upper triangle.
    """

    node_order: Ints
    scatter: sparse.csr_array
    gather: npt.NDArray[np.int64]
    indices: npt.NDArray[np.int32]
    indptr: npt.NDArray[np.int32]


def local_pairs(n_nodes: int) -> tuple[Ints, Ints]:
    """Local node pairs a ≤ b."""
    a, b = np.triu_indices(n_nodes)
    return a, b


def pattern(tets: Ints, n_points: int) -> Pattern:
    """Work out the sparsity of the stiffness of a mesh with `n_points` nodes (every node in an element)."""
    node_order = np.argsort(tets, axis=1)
    ordered = np.take_along_axis(tets, node_order, axis=1)
    a, b = local_pairs(tets.shape[1])
    keys = (ordered[:, a] * n_points + ordered[:, b]).ravel()
    by_key = np.argsort(keys, kind="stable")  # runs that are sorted already make it three times as fast
    sorted_keys = keys[by_key]
    starts = np.flatnonzero(np.r_[True, sorted_keys[1:] != sorted_keys[:-1]])
    scatter = sparse.csr_array(
        (np.ones(keys.size), by_key, np.r_[starts, keys.size]), shape=(starts.size, keys.size)
    )
    rows, columns = np.divmod(sorted_keys[starts], n_points)
    return Pattern(node_order, scatter, *_scalar_upper(rows, columns, n_points))


def _scalar_upper(
    rows: Ints, columns: Ints, n_points: int
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Expand the upper triangle of 3×3 blocks to scalars: gather, indices, indptr."""
    first = np.r_[0, np.cumsum(np.bincount(rows, minlength=n_points))]
    places = np.arange(9 * rows.size).reshape(-1, 3, 3)
    every = sparse.bsr_array((places, columns, first), shape=(3 * n_points, 3 * n_points)).tocsr()
    row = np.repeat(np.arange(3 * n_points), np.diff(every.indptr))
    keep = every.indices >= row  # diagonal blocks bring what lies below the diagonal
    # Of the three rows of a block row, d = 0, 1, 2 entries fall away.
    fallen = np.r_[0, np.cumsum(np.tile([0, 1, 2], n_points))]
    indptr = (every.indptr - fallen).astype(np.int32)
    return every.data[keep], every.indices[keep].astype(np.int32), indptr


def stiffness(mesh: TetMesh, material: Material | Materials, layout: Pattern) -> SymmetricMatrix:
    """Assemble the stiffness matrix of `mesh`, degrees of freedom node-wise (u_x, u_y, u_z), N/mm."""
    pairs = local_pairs(mesh.tets.shape[1])
    values = np.empty((len(mesh.tets), pairs[0].size, 3, 3))
    for part, gauss in gauss_blocks(mesh, stiffness_degree(mesh.tets.shape[1])):
        order = layout.node_order[part][:, None, :, None]
        ordered = type(gauss)(np.take_along_axis(gauss.gradients, order, axis=2), gauss.volumes)
        values[part] = node_pair_blocks(ordered, material.of(part), pairs)
    summed = layout.scatter @ values.reshape(-1, 9)
    data = summed.ravel()[layout.gather]
    n_dofs = 3 * len(mesh.points)
    return SymmetricMatrix(sparse.csr_array((data, layout.indices, layout.indptr), shape=(n_dofs, n_dofs)))
