"""Shape functions and quadrature of the reference elements, from scikit-fem."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy import sparse
from skfem import ElementTetP1, ElementTetP2, ElementTriP1, ElementTriP2
from skfem.quadrature import get_quadrature

from fea.base.material import Constants, Material
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
