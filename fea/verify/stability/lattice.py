"""Structured meshes without a mesher: a lattice of cells, each cut into six tetrahedra, placed by a map."""

from collections.abc import Callable, Mapping
from itertools import permutations

import numpy as np

from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from mesh.tetmesh import EDGES, FACES, FACET_EDGES, TetMesh

# An axis of the lattice and one of its ends, 0 or 1.
End = tuple[int, int]


def lattice(
    cells: tuple[int, int, int],
    place: Callable[[Floats], Floats],
    ends: Mapping[End, Surface],
) -> TetMesh:
    """Cut each cell along its diagonal (Kuhn 1960) and place the nodes of second-order tetrahedra.

    `place` maps the unit cube, (n, 3), to the body, mm, and keeps the orientation. It also places mid-edge
    nodes, so that edges may be curved. `ends` names surfaces by the end of the lattice.
    """
    counts = np.array(cells)
    corners = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), axis=-1).reshape(-1, 1, 1, 3)
    # Twice the indices, so that the middle of an edge has integer indices too.
    vertices = (2 * (corners + _kuhn())).reshape(-1, 4, 3)
    nodes = _with_middles(vertices, EDGES)
    faces = vertices[:, FACES].reshape(-1, 3, 3)
    facets = {}
    for (axis, end), surface in ends.items():
        own = faces[(faces[:, :, axis] == 2 * end * counts[axis]).all(axis=1)]
        facets[surface] = _with_middles(own, FACET_EDGES)
    weights = np.array([(2 * counts[1] + 1) * (2 * counts[2] + 1), 2 * counts[2] + 1, 1])
    used, tets = np.unique(nodes @ weights, return_inverse=True)
    indices = np.stack([used // weights[0], used % weights[0] // weights[1], used % weights[1]], axis=1)
    return TetMesh(
        place(indices / (2 * counts)),
        tets.reshape(nodes.shape[:2]),
        {surface: np.searchsorted(used, own @ weights) for surface, own in facets.items()},
    )


def _kuhn() -> Ints:
    """Vertices (6, 4, 3) of the tetrahedra of the unit cube: paths along the axes in every order."""
    found = []
    for axes in permutations(range(3)):
        steps = np.eye(3, dtype=np.int64)[list(axes)]
        path = np.vstack([np.zeros((1, 3), dtype=np.int64), steps.cumsum(axis=0)])
        found.append(path if np.linalg.det(steps) > 0 else path[[0, 1, 3, 2]])
    return np.array(found)


def _with_middles(vertices: Ints, edges: Ints) -> Ints:
    middles = [(vertices[:, a] + vertices[:, b]) // 2 for a, b in edges]
    return np.concatenate([vertices, np.stack(middles, axis=1)], axis=1)
