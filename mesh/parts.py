"""One part of a mesh as a mesh of its own."""

import numpy as np

from geometry.arrays import Ints
from mesh.tetmesh import FACES, TetMesh

# The faces of a tetrahedron by its vertices.


def submesh(mesh: TetMesh, number: int) -> tuple[TetMesh, Ints]:
    """The elements of a part, with the named facets that belong to them.

    Returns
    -------
    TetMesh, ndarray
        The part's mesh and (n_part_nodes,) the number of each of its nodes in the whole mesh.

    Raises
    ------
    ValueError
        The mesh has no parts.
    """
    if mesh.part is None:
        raise ValueError("the mesh has only one part")
    tets = mesh.tets[mesh.part == number]
    nodes = np.unique(tets)
    local = np.full(len(mesh.points), -1)
    local[nodes] = np.arange(nodes.size)
    faces = np.sort(tets[:, FACES].reshape(-1, 3), axis=1)
    own = {tuple(face) for face in faces.tolist()}
    facets = {}
    for surface, every in mesh.facets.items():
        mine = np.array([tuple(face) in own for face in np.sort(every[:, :3], axis=1).tolist()], dtype=bool)
        if mine.any():
            facets[surface] = local[every[mine]]
    return TetMesh(mesh.points[nodes], local[tets], facets), nodes
