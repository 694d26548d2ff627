"""The stiffness matrix: sparsity once, numbers in dense batches, the upper triangle only.

scikit-fem assembles the same matrix in twenty times the time (5300 elements of second order, one thread);
shape functions and quadrature of the reference elements are its own.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
import numpy.typing as npt
from scipy import sparse
from skfem import ElementTetP1, ElementTetP2, ElementTriP1, ElementTriP2
from skfem.quadrature import get_quadrature

from fea.base.material import Constants, Material, Materials
from geometry.arrays import Floats, Ints
from mesh.tetmesh import EDGES, TetMesh

_ELEMENTS = {4: ElementTetP1, 10: ElementTetP2, 3: ElementTriP1, 6: ElementTriP2}


@dataclass(frozen=True)
class Tabulation:
    """Shape functions of a reference simplex at quadrature points.

    The nodes are numbered as in `mesh.tetmesh.TetMesh`: scikit-fem, like VTK, orders the edges of a
    tetrahedron (0,1), (1,2), (0,2), (0,3), (1,3), (2,3).
    """

    weights: Floats  #: (n_points,) quadrature weights on the reference simplex
    values: Floats  #: (n_points, n_nodes) shape functions
    gradients: Floats  #: (n_points, n_nodes, dim) derivatives with respect to reference coordinates


def shape_functions(n_nodes: int, points: Floats) -> tuple[Floats, Floats]:
    """Shape functions (n, n_nodes) and derivatives (n, n_nodes, dim) at `points` (dim, n) of the simplex."""
    element = _ELEMENTS[n_nodes]()
    tables = [element.lbasis(points, node) for node in range(n_nodes)]
    values = np.stack([np.broadcast_to(value, points.shape[1]) for value, _ in tables], axis=1)
    gradients = np.stack([np.broadcast_to(np.asarray(slope), points.shape).T for _, slope in tables], axis=1)
    return values.astype(float), gradients.astype(float)


@cache
def tabulate(n_nodes: int, degree: int) -> Tabulation:
    """Tabulate the simplex with `n_nodes` nodes for a rule exact to polynomial `degree`."""
    points, weights = get_quadrature(_ELEMENTS[n_nodes].refdom, degree)
    return Tabulation(weights, *shape_functions(n_nodes, points))


# Elements per block, so that the working set of the stiffness kernel fits into the second-level cache.
BLOCK = 512
# Exact for every integrand of loads and mass properties on straight-sided P2 elements.
VOLUME_DEGREE = 5


def stiffness_degree(n_nodes: int) -> int:
    """Polynomial degree of grad N : grad N on a straight-sided element."""
    return 0 if n_nodes == 4 else 2


_VERTICES = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


def reference_nodes(n_nodes: int) -> Floats:
    """Places (n_nodes, 3) of the nodes of the reference tetrahedron."""
    if n_nodes == len(_VERTICES):
        return _VERTICES
    return np.vstack([_VERTICES, [(_VERTICES[a] + _VERTICES[b]) / 2 for a, b in EDGES]])


def gauss_places(n_nodes: int) -> Floats:
    """Places (n_places, 3) of the stiffness's Gauss points in the reference tetrahedron."""
    values = tabulate(n_nodes, stiffness_degree(n_nodes)).values
    return np.asarray(values @ reference_nodes(n_nodes))


def mean_at_nodes(mesh: TetMesh, values: Floats) -> Floats:
    """Values (n_nodes, k) from those at the Gauss points (n_elements, n_points, k) of second-order elements.

    They are extrapolated linearly, and the mean over the elements at a node.
    """
    n_local = mesh.tets.shape[1]
    known, wanted = (shape_functions(4, places(n_local).T)[0] for places in (gauss_places, reference_nodes))
    at_nodes = wanted @ np.linalg.inv(known) @ values
    sums = np.zeros((len(mesh.points), values.shape[-1]))
    np.add.at(sums, mesh.tets, at_nodes)
    return np.asarray(sums / np.bincount(mesh.tets.ravel())[:, None])


def blocks(n_elements: int, size: int = BLOCK) -> Iterator[slice]:
    """Split 0…`n_elements` into consecutive slices."""
    for start in range(0, n_elements, size):
        yield slice(start, min(start + size, n_elements))


@dataclass(frozen=True)
class GaussBlock:
    """Physical quantities at the Gauss points of a block of elements."""

    gradients: Floats  #: (n_elements, n_points, n_nodes, 3) shape-function gradients, 1/mm
    volumes: Floats  #: (n_elements, n_points) quadrature weight times Jacobian determinant, mm³


def inverse_and_determinant(jacobian: Floats) -> tuple[Floats, Floats]:
    """Inverse and determinant of (…, 3, 3) matrices by cofactors: LAPACK takes four to six times as long."""
    rows = jacobian[..., 0, :], jacobian[..., 1, :], jacobian[..., 2, :]
    inverse = np.empty_like(jacobian)
    for column in range(3):
        a, b = rows[(column + 1) % 3], rows[(column + 2) % 3]
        inverse[..., 0, column] = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
        inverse[..., 1, column] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
        inverse[..., 2, column] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    determinant = (rows[0] * inverse[..., :, 0]).sum(axis=-1)
    inverse /= determinant[..., None, None]
    return inverse, determinant


def jacobians(corners: Floats, gradients: Floats) -> Floats:
    """Jacobians ∂x_i/∂ξ_j (n, n_points, 3, dim) of elements with nodes `corners` (n, n_nodes, 3)."""
    n_points, n_nodes, dim = gradients.shape
    flat = gradients.transpose(1, 0, 2).reshape(n_nodes, n_points * dim)
    product = corners.transpose(0, 2, 1) @ flat
    return product.reshape(-1, 3, n_points, dim).transpose(0, 2, 1, 3)


def gauss_block(corners: Floats, table: Tabulation) -> GaussBlock:
    """Gradients and volumes of elements with nodes at `corners` (n, n_nodes, 3)."""
    inverse, determinant = inverse_and_determinant(jacobians(corners, table.gradients))
    return GaussBlock(table.gradients @ inverse, determinant * table.weights)


def gauss_blocks(mesh: TetMesh, degree: int) -> Iterator[tuple[slice, GaussBlock]]:
    """Iterate over the mesh block by block, with a quadrature rule exact to `degree`."""
    table = tabulate(mesh.tets.shape[1], degree)
    for part in blocks(len(mesh.tets)):
        yield part, gauss_block(mesh.points[mesh.tets[part]], table)


def volume_points(mesh: TetMesh) -> tuple[Floats, Floats]:
    """Places (n_elements, n_points, 3) and volumes (n_elements, n_points) for mass and body forces."""
    table = tabulate(mesh.tets.shape[1], VOLUME_DEGREE)
    corners = mesh.points[mesh.tets]
    volumes = np.concatenate([block.volumes for _, block in gauss_blocks(mesh, VOLUME_DEGREE)])
    return table.values @ corners, volumes


# Components of a symmetric tensor in VTK's order: XX YY ZZ XY YZ XZ.
COMPONENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def node_pair_blocks(gauss: GaussBlock, material: Material | Constants, pairs: tuple[Ints, Ints]) -> Floats:
    """3×3 stiffness blocks (n_elements, n_pairs, 3, 3), N/mm, of local node pairs (a, b), each (n_pairs,).

    K_ab = ∫ λ ∇N_a ⊗ ∇N_b + μ ∇N_b ⊗ ∇N_a + μ (∇N_a · ∇N_b) I dV; every product ∇N_a ⊗ ∇N_b of an element
    comes from one matrix product over its Gauss points.
    """
    n_elements, n_points, n_nodes, _ = gauss.gradients.shape
    flat = gauss.gradients.reshape(n_elements, n_points, 3 * n_nodes)
    weighted = flat * gauss.volumes[:, :, None]
    products = (weighted.transpose(0, 2, 1) @ flat).reshape(n_elements, n_nodes, 3, n_nodes, 3)
    outer = products.transpose(0, 1, 3, 2, 4)[:, pairs[0], pairs[1]]
    lam, mu = (np.reshape(value, (-1, 1, 1, 1)) for value in (material.lame_lambda, material.shear_modulus))
    stiffness = lam * outer + mu * outer.swapaxes(-1, -2)
    trace = mu[..., 0, 0] * (outer[..., 0, 0] + outer[..., 1, 1] + outer[..., 2, 2])
    for i in range(3):
        stiffness[..., i, i] += trace
    return stiffness


def stress_from_gradient(gradient: Floats, material: Material) -> Floats:
    """Stress λ tr ε I + 2 μ ε, (…, 6) in the order of `COMPONENTS`, of gradients ∂u_i/∂x_j (…, 3, 3)."""
    lam, mu = material.lame_lambda, material.shear_modulus
    pressure = lam * (gradient[..., 0, 0] + gradient[..., 1, 1] + gradient[..., 2, 2])
    stress = np.stack([mu * (gradient[..., i, j] + gradient[..., j, i]) for i, j in COMPONENTS], axis=-1)
    stress[..., :3] += pressure[..., None]
    return stress


def linear_interpolation(tets: Ints, n_points: int) -> tuple[Ints, sparse.csr_array]:
    """Vertex nodes of second-order elements, and weights (n_points, n_vertices) of linear functions."""
    vertices = np.unique(tets[:, :4])
    number = np.zeros(n_points, dtype=np.int64)
    number[vertices] = np.arange(len(vertices))
    middles, first = np.unique(tets[:, 4:], return_index=True)
    ends = number[tets[:, EDGES].reshape(-1, 2)[first]]
    rows = np.concatenate([vertices, np.repeat(middles, 2)])
    columns = np.concatenate([number[vertices], ends.ravel()])
    weights = np.concatenate([np.ones(len(vertices)), np.full(ends.size, 0.5)])
    shape = (n_points, len(vertices))
    return vertices, sparse.csr_array(sparse.coo_array((weights, (rows, columns)), shape=shape))


@dataclass(frozen=True)
class SymmetricMatrix:
    """A symmetric matrix of 3×3 node blocks, held by its upper triangle."""

    #: BSR of 3×3 blocks with sorted 32-bit indices: the blocks of node pairs a ≤ b. Every diagonal block is
    #: present and stored completely.
    upper: sparse.bsr_array

    @classmethod
    def of_full(cls, matrix: sparse.csr_array) -> "SymmetricMatrix":
        """Take the upper triangle of a symmetric matrix, three rows a node."""
        full = sparse.bsr_array(matrix, blocksize=(3, 3))
        full.sort_indices()
        n_nodes = len(full.indptr) - 1
        row = np.repeat(np.arange(n_nodes), np.diff(full.indptr))
        kept = full.indices >= row
        indptr = np.r_[0, np.cumsum(np.bincount(row[kept], minlength=n_nodes))].astype(np.int32)
        indices = full.indices[kept].astype(np.int32)
        return cls(sparse.bsr_array((full.data[kept], indices, indptr), shape=full.shape))

    @property
    def size(self) -> int:
        """Number of rows."""
        return int(self.upper.shape[0])

    @cached_property
    def _rows(self) -> Ints:
        return np.repeat(np.arange(self.size // 3), np.diff(self.upper.indptr))

    @cached_property
    def _scalar(self) -> sparse.csr_array:
        # Products are several times faster than with 3×3 blocks.
        return sparse.csr_array(self.upper)

    @cached_property
    def _diagonal_blocks(self) -> Floats:
        """Return (n_nodes, 3, 3): the first block of every row."""
        return np.asarray(self.upper.data[self.upper.indptr[:-1]])

    def diagonal(self) -> Floats:
        """Diagonal entries."""
        return np.asarray(np.einsum("nii->ni", self._diagonal_blocks)).reshape(-1)

    def full(self) -> sparse.csr_array:
        """Both triangles."""
        strictly = self.upper.data.copy()
        strictly[self.upper.indptr[:-1]] = 0.0
        above = sparse.bsr_array((strictly, self.upper.indices, self.upper.indptr), shape=self.upper.shape)
        return sparse.csr_array(self.upper + above.T)

    def __matmul__(self, vectors: Floats) -> Floats:
        """Product with a vector (n,) or a block of vectors (n, k)."""
        both = self._scalar @ vectors + self._scalar.T @ vectors
        twice = self._diagonal_blocks @ vectors.reshape(len(self._diagonal_blocks), 3, -1)
        return np.asarray(both - twice.reshape(vectors.shape))

    @cached_property
    def row_sums(self) -> Floats:
        """Sums (n,) of the magnitudes in each row."""
        upper = self._scalar
        magnitude = sparse.csr_array((np.abs(upper.data), upper.indices, upper.indptr), shape=upper.shape)
        ones = np.ones(self.size)
        twice = np.abs(self._diagonal_blocks).sum(axis=2).reshape(-1)
        return np.asarray(magnitude @ ones + magnitude.T @ ones - twice)

    def norm(self) -> float:
        """Largest absolute row sum."""
        return float(self.row_sums.max())

    def constrained(self, fixed: npt.NDArray[np.bool_]) -> "SymmetricMatrix":
        """Replace rows and columns of `fixed` degrees of freedom by their diagonal; the sparsity stays."""
        held = fixed.reshape(-1, 3)
        free, cut = ~held, np.asarray(held.any(axis=1))
        indptr, indices = self.upper.indptr, self.upper.indices
        touched = np.flatnonzero(cut[self._rows] | cut[indices])
        data = self.upper.data.copy()
        data[touched] *= free[self._rows[touched]][:, :, None] & free[indices[touched]][:, None, :]
        node, axis = np.nonzero(held)
        data[indptr[node], axis, axis] = self.diagonal()[fixed]
        return SymmetricMatrix(sparse.bsr_array((data, indices, indptr), shape=self.upper.shape))

    def scalar_upper(self) -> sparse.csr_array:
        """Return the upper triangle entry by entry, for solvers that do not support blocks."""
        scalar, above = self._scalar, np.ones(self._scalar.nnz, dtype=bool)
        second, third = scalar.indptr[1:-1:3], scalar.indptr[2:-1:3]
        above[np.concatenate([second, third, third + 1])] = False  # of the diagonal blocks, which come first
        indptr = scalar.indptr - np.append(0, np.cumsum(np.tile([0, 1, 2], len(second))))
        entries = scalar.data[above], scalar.indices[above], indptr.astype(np.int32)
        return sparse.csr_array(entries, shape=scalar.shape)


@dataclass(frozen=True)
class Pattern:
    """Positions of each element's node pairs in the upper triangle of 3×3 blocks."""

    #: (n_elements, n_nodes) local nodes by global number: local pairs a ≤ b are of the upper triangle
    node_order: Ints
    #: CSR (n_blocks, n_elements·n_pairs) of ones: sums element blocks into matrix blocks
    scatter: sparse.csr_array
    #: indices, indptr: the blocks' columns, and where each block row starts
    indices: npt.NDArray[np.int32]
    indptr: npt.NDArray[np.int32]

    def matrix(self, values: Floats) -> SymmetricMatrix:
        """Sum element blocks (n_elements, n_pairs, 3, 3) of the local pairs into a matrix."""
        summed = (self.scatter @ values.reshape(-1, 9)).reshape(-1, 3, 3)
        size = 3 * (len(self.indptr) - 1)
        return SymmetricMatrix(sparse.bsr_array((summed, self.indices, self.indptr), shape=(size, size)))


def pattern(tets: Ints, n_points: int) -> Pattern:
    """Compute the sparsity of the stiffness of a mesh with `n_points` nodes (every node in an element)."""
    node_order = np.argsort(tets, axis=1)
    ordered = np.take_along_axis(tets, node_order, axis=1)
    a, b = np.triu_indices(tets.shape[1])
    return Pattern(node_order, *_scatter((ordered[:, a] * n_points + ordered[:, b]).ravel(), n_points))


def _scatter(
    keys: Ints, n_points: int
) -> tuple[sparse.csr_array, npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Matrix that sums entries with equal keys, row · n_points + column; columns and row starts of sums."""
    by_key = np.argsort(keys, kind="stable")  # three times as fast, because the keys contain sorted runs
    sorted_keys = keys[by_key]
    starts = np.flatnonzero(np.r_[True, sorted_keys[1:] != sorted_keys[:-1]])
    sums = np.ones(keys.size), by_key, np.r_[starts, keys.size]
    scatter = sparse.csr_array(sums, shape=(starts.size, keys.size))
    rows, columns = np.divmod(sorted_keys[starts], n_points)
    indptr = np.r_[0, np.cumsum(np.bincount(rows, minlength=n_points))]
    return scatter, columns.astype(np.int32), indptr.astype(np.int32)


def stiffness(
    mesh: TetMesh, material: Material | Materials, layout: Pattern, nodal: Floats | None = None
) -> SymmetricMatrix:
    """Assemble the stiffness matrix of `mesh`, degrees of freedom node-wise (u_x, u_y, u_z), N/mm.

    The functions are those of the elements, or have the values `nodal` (n_nodes, n_functions) at their nodes.
    """
    pairs = np.triu_indices(layout.node_order.shape[1])
    values = np.empty((len(mesh.tets), pairs[0].size, 3, 3))
    for part, gauss in gauss_blocks(mesh, stiffness_degree(mesh.tets.shape[1])):
        gradients = gauss.gradients if nodal is None else nodal.T @ gauss.gradients
        order = layout.node_order[part][:, None, :, None]
        ordered = type(gauss)(np.take_along_axis(gradients, order, axis=2), gauss.volumes)
        values[part] = node_pair_blocks(ordered, material.of(part), pairs)
    return layout.matrix(values)


def element_stiffness(mesh: TetMesh, material: Material | Materials) -> Floats:
    """Integrate the stiffness of each element, (n_elements, 3 n_nodes, 3 n_nodes) node-wise, N/mm."""
    n_nodes = mesh.tets.shape[1]
    first, second = np.indices((n_nodes, n_nodes)).reshape(2, -1)
    values = np.empty((len(mesh.tets), n_nodes, 3, n_nodes, 3))
    for part, gauss in gauss_blocks(mesh, stiffness_degree(n_nodes)):
        blocks = node_pair_blocks(gauss, material.of(part), (first, second))
        values[part] = blocks.reshape(-1, n_nodes, n_nodes, 3, 3).swapaxes(2, 3)
    return values.reshape(len(values), 3 * n_nodes, 3 * n_nodes)


def linear_stiffness(mesh: TetMesh, material: Material | Materials) -> SymmetricMatrix:
    """Assemble the stiffness of the linear functions on the curved cells of a second-order mesh.

    The quadratic functions contain the linear ones, so this is the quadratic stiffness matrix restricted to
    them (Galerkin). The nodes are the vertices, in the order of their numbers.
    """
    vertices, corners = np.unique(mesh.tets[:, :4], return_inverse=True)
    layout = pattern(corners.reshape(-1, 4), len(vertices))
    ends = np.zeros((mesh.tets.shape[1], 4))
    ends[np.arange(4), np.arange(4)] = 1.0
    ends[np.arange(4, 10)[:, None], EDGES] = 0.5
    return stiffness(mesh, material, layout, ends)


# In second-order elements both the stress and the shape-function gradients are linear.
_DEGREE = {4: 0, 10: 3}


class GeometricStiffness:
    """g_ab = ∫ ∇N_a · σ ∇N_b dV of stress fields on one mesh, N/mm: the same for u_x, u_y and u_z.

    Zienkiewicz & Taylor, The Finite Element Method for Solid and Structural Mechanics, on initial stress.
    Applied to the coordinates of the nodes it gives the forces in equilibrium with the stress.
    """

    def __init__(self, mesh: TetMesh, material: Material | Materials) -> None:
        self._mesh, self._material = mesh, material
        n_points, n_nodes = len(mesh.points), mesh.tets.shape[1]
        keys = (mesh.tets[:, :, None] * n_points + mesh.tets[:, None, :]).reshape(-1, n_nodes**2).ravel()
        self._sum, *self._layout = _scatter(keys, n_points)

    def __call__(self, displacement: Floats) -> list[sparse.csr_array]:
        """Assemble (n_nodes, n_nodes) for each displacement of (n_nodes, 3, k), mm."""
        count, n_nodes = displacement.shape[2], self._mesh.tets.shape[1]
        values = np.empty((len(self._mesh.tets), n_nodes, n_nodes, count))
        flat = displacement.reshape(len(displacement), -1)
        for part, gauss in gauss_blocks(self._mesh, _DEGREE[n_nodes]):
            n, n_gauss = gauss.volumes.shape
            gradients = gauss.gradients.swapaxes(1, 2).reshape(n, n_nodes, -1)  # (node, Gauss point × x)
            slope = gradients.swapaxes(1, 2) @ flat[self._mesh.tets[part]]
            stress = _stress(slope.reshape(n, n_gauss, 3, 3, count), self._material.of(part))
            stress *= gauss.volumes[:, :, None, None, None]
            for number in range(count):
                pushed = gauss.gradients @ np.ascontiguousarray(stress[..., number])
                values[part, ..., number] = gradients @ pushed.swapaxes(2, 3).reshape(n, -1, n_nodes)
        entries, shape = self._sum @ values.reshape(-1, count), (len(self._mesh.points),) * 2
        return [sparse.csr_array((load, *self._layout), shape=shape) for load in entries.T]


def _stress(slope: Floats, constants: Material | Constants) -> Floats:
    """Stress tensors (n_elements, n_points, 3, 3, k), MPa, of ∂u_j/∂x_i."""
    both = constants.lame_lambda, constants.shear_modulus
    lam, mu = (np.reshape(value, (-1, 1, 1, 1, 1)) for value in both)
    trace = np.einsum("npiik->npk", slope)[:, :, None, None]
    return np.asarray(lam * trace * np.eye(3)[..., None] + mu * (slope + slope.swapaxes(2, 3)))
