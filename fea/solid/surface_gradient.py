"""How a nodal field changes from the surface inwards."""

import numpy as np

from fea.solid.assembly import blocks, reference_nodes
from fea.solid.recovery import ElementStress
from geometry.arrays import Floats, Ints
from mesh.creases import SurfaceMesh
from mesh.tetmesh import TetMesh

_TINY = 1e-12


def inward_derivative(mesh: TetMesh, facets: Ints, values: Floats) -> Floats:
    """Derivative (n_nodes, k), per mm, of nodal values (n_nodes, k) along the inward normal of `facets`.

    At a node it is the mean of those in the elements there, whose interpolation is differentiated; 0 at nodes
    that are not on the facets.
    """
    flat, normal = SurfaceMesh(mesh.points, facets[:, :3]), np.zeros_like(mesh.points)
    for corner in facets.T:
        np.add.at(normal, corner, flat.vectors)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    near = mesh.tets[(normal != 0).any(axis=1)[mesh.tets].any(axis=1)]
    places, total = reference_nodes(mesh.tets.shape[1]), np.zeros((len(mesh.points), values.shape[1]))
    for some in blocks(len(near)):
        tets = near[some]
        slopes = ElementStress(TetMesh(mesh.points, tets), places).slopes()  # (e, place, 3, node)
        gradient = slopes @ values[tets][:, None]
        np.add.at(total, tets, -np.einsum("epik,epi->epk", gradient, normal[tets]))
    count = np.bincount(near.ravel(), minlength=len(total))
    return np.asarray(total / np.maximum(count, 1)[:, None])


def relative_gradient(mesh: TetMesh, facets: Ints, values: Floats) -> Floats:
    """−(∂v/∂s)/v (n_nodes,), 1/mm, along the inward normal: the least of values (n_nodes, k)."""
    inward = inward_derivative(mesh, facets, values)
    return np.asarray((-inward / np.maximum(values, _TINY)).min(axis=1))
