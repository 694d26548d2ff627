"""The order in which scikit-fem numbers nodes: vertices first, then the nodes amid the edges.

Edges are sorted by their two vertices, the lower number first (`skfem.MeshTet.edges`). In this order the
degree of freedom of scikit-fem's vector elements is 3 · node + axis, as it is ours: matrices agree entry by
entry.
"""

from dataclasses import replace

import numpy as np

from geometry.arrays import Ints
from mesh.tetmesh import EDGES, TetMesh


def numbered(mesh: TetMesh) -> tuple[TetMesh, Ints]:
    """Renumber the nodes of a mesh as scikit-fem does; vertices keep their order among themselves.

    Returns
    -------
    TetMesh, ndarray
        The mesh, its elements and facets in the order given, and (n_nodes,) the earlier number of each node.
        Nodes that no element has come last.
    """
    order = scikit_fem_order(mesh.tets, len(mesh.points))
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    facets = {surface: number[nodes] for surface, nodes in mesh.facets.items()}
    return replace(mesh, points=mesh.points[order], tets=number[mesh.tets], facets=facets), order


def scikit_fem_order(tets: Ints, n_points: int) -> Ints:
    """Nodes (n_points,) of the elements (n_elements, 4) or (n_elements, 10) as scikit-fem orders them."""
    key = np.full(n_points, np.iinfo(np.int64).max)
    if tets.shape[1] > 4:
        ends = tets[:, EDGES]
        key[tets[:, 4:]] = ends.min(axis=2) * n_points + ends.max(axis=2)
    key[tets[:, :4]] = tets[:, :4] - n_points  # negative, so ahead of every edge
    return np.argsort(key, kind="stable")
