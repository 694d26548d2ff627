"""Mechanisms: pieces of a mesh that are connected by an edge or a point only and can move there.

Elements that share a facet move as one body; bodies that share nodes but no facet are hinged there. Such a
mechanism does not show in a single piece, so the rigid modes of all bodies are considered together.
"""

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from geometry.arrays import Floats, Ints, Mask
from mesh.tetmesh import FACES, TetMesh

# An eigenvalue below this fraction of the largest belongs to a free motion.
FREE = 1e-8


def bodies(mesh: TetMesh) -> Ints:
    """Number (n_elements,) of the body, joined over facets, that each element belongs to."""
    n_nodes, n_elements = len(mesh.points), len(mesh.tets)
    a, b, c = np.sort(mesh.tets[:, FACES].reshape(-1, 3), axis=1).T
    keys = (a * n_nodes + b) * n_nodes + c  # 64 bits hold two million nodes
    order = np.argsort(keys)
    shared = np.flatnonzero(keys[order][1:] == keys[order][:-1])
    one, other = order[shared] // len(FACES), order[shared + 1] // len(FACES)
    graph = sparse.csr_array((np.ones(one.size, np.int8), (one, other)), shape=(n_elements, n_elements))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def rigid_modes(points: Floats) -> Floats:
    """The six rigid displacements (n_nodes, 3, 6), rotations about the centroid scaled to unit size."""
    centred = points - points.mean(axis=0)
    x, y, z = (centred / np.abs(centred).max()).T
    modes = np.zeros((len(points), 3, 6))
    modes[:, [0, 1, 2], [0, 1, 2]] = 1
    modes[:, 1, 3], modes[:, 2, 3] = -z, y
    modes[:, 0, 4], modes[:, 2, 4] = z, -x
    modes[:, 0, 5], modes[:, 1, 5] = -y, x
    return modes


def free_shares(mesh: TetMesh, body: Ints, fixed: Mask) -> Floats:
    """Share of each body's rigid modes in the motions that supports and joints leave free.

    Parameters
    ----------
    mesh
        The mesh.
    body
        (n_elements,) from `bodies`.
    fixed
        (n_nodes, 3) held degrees of freedom.

    Returns
    -------
    ndarray
        (n_bodies, 6), zero for a body that cannot move.
    """
    count = int(body.max()) + 1
    first = np.full(len(mesh.points), -1)  # the first body that has the node; other bodies are joined to it
    modes_at = np.zeros((len(mesh.points), 3, 6))
    normal = np.zeros((6 * count, 6 * count))
    for number in range(count):
        nodes = np.unique(mesh.tets[body == number])
        modes = rigid_modes(mesh.points[nodes])
        own = slice(6 * number, 6 * number + 6)
        held = modes[fixed[nodes]]
        normal[own, own] += held.T @ held
        joined = first[nodes] >= 0
        for other in np.unique(first[nodes[joined]]):
            at = first[nodes] == other
            rows = np.zeros((3 * np.count_nonzero(at), 6 * count))
            rows[:, own] = modes[at].reshape(-1, 6)
            rows[:, 6 * other : 6 * other + 6] = -modes_at[nodes[at]].reshape(-1, 6)
            normal += rows.T @ rows
        first[nodes[~joined]], modes_at[nodes[~joined]] = number, modes[~joined]
    values, vectors = np.linalg.eigh(normal)
    free = vectors[:, values < FREE * max(values.max(), 1e-300)]
    # The shares of the modes in the null space do not depend on which vectors span it.
    return np.asarray(np.linalg.norm(free, axis=1).reshape(count, 6))
