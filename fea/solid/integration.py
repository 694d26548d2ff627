"""Isoparametric maps: gradients, volumes and places of Gauss points, one block of elements at a time."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fea.solid.element import Tabulation, tabulate
from geometry.arrays import Floats
from mesh.tetmesh import TetMesh

# Elements per block, so that the working set of the stiffness kernel fits into the second-level cache.
BLOCK = 512
# Exact for every integrand of loads and mass properties on straight-sided P2 elements.
VOLUME_DEGREE = 5


def stiffness_degree(n_nodes: int) -> int:
    """Polynomial degree of grad N : grad N on a straight-sided element."""
    return 0 if n_nodes == 4 else 2


def blocks(n_elements: int, size: int = BLOCK) -> Iterator[slice]:
    """Split 0…`n_elements` into consecutive slices."""
    for start in range(0, n_elements, size):
        yield slice(start, min(start + size, n_elements))


@dataclass(frozen=True)
class GaussBlock:
    """Physical quantities at the Gauss points of a block of elements.

    Attributes
    ----------
    gradients
        (n_elements, n_points, n_nodes, 3) shape-function gradients, 1/mm.
    volumes
        (n_elements, n_points) quadrature weight times Jacobian determinant, mm³.
    """

    gradients: Floats
    volumes: Floats


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
