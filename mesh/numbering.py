"""The order in which scikit-fem numbers nodes: vertices first, then the nodes amid the edges.

Edges are sorted by their two vertices, the lower number first (`skfem.MeshTet.edges`). In this order the
degree of freedom of scikit-fem's vector elements is 3 · node + axis, as it is ours: matrices agree entry by
entry.
"""

from dataclasses import replace

import numpy as np

from geometry.arrays import Ints
from mesh.tetmesh import EDGES, FACES, FACET_TURN, MeshError, TetMesh


def numbered(mesh: TetMesh) -> tuple[TetMesh, Ints]:
    """Renumber the nodes of a mesh as scikit-fem does; vertices keep their order among themselves.

    Elements and facets keep theirs. The second result (n_nodes,) is the earlier number of each node; nodes
    that no element has come last.
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


# The faces of a positively oriented tetrahedron, seen from outside counter-clockwise.


def outward(mesh: TetMesh) -> TetMesh:
    """Return the mesh with every facet oriented outwards from the element behind it.

    Raises
    ------
    MeshError
        A facet bounds no element or two elements: the surface of a damaged solid may fold onto itself.
    """
    faces = mesh.tets[:, FACES].reshape(-1, 3)
    keys = face_keys(faces, len(mesh.points))
    order = np.argsort(keys)
    ordered, even = keys[order], _even(faces)

    def turned(facets: Ints) -> Ints:
        found = face_keys(facets[:, :3], len(mesh.points))
        first = np.searchsorted(ordered, found)
        astray = np.searchsorted(ordered, found, side="right") - first != 1
        if astray.any():
            x, y, z = mesh.points[facets[astray][0, :3]].mean(axis=0)
            message = (
                f"{astray.sum()} surface triangles do not bound exactly one tetrahedron each; the first is "
                f"at ({x:.1f}, {y:.1f}, {z:.1f}) mm. The solid may be damaged: export it again, or try "
                "another --size"
            )
            raise MeshError(message)
        wrong = even[order[first]] != _even(facets[:, :3])
        return np.where(wrong[:, None], facets[:, FACET_TURN[facets.shape[1]]], facets)

    return replace(mesh, facets={surface: turned(facets) for surface, facets in mesh.facets.items()})


def face_keys(faces: Ints, n_points: int) -> Ints:
    """One number for the three nodes of a face, independent of their order."""
    a, b, c = np.sort(faces, axis=1).T
    return np.asarray((a * n_points + b) * n_points + c)


def _even(faces: Ints) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Whether the nodes are an even permutation of their ascending order."""
    a, b, c = faces.T
    return np.asarray((a < b).astype(int) + (b < c) + (c < a) == 2)
