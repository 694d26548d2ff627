"""Split every tetrahedron into eight; straight-sided meshes stay nested."""

import numpy as np

from geometry.arrays import Ints
from geometry.surfaces import Surface
from mesh.tetmesh import EDGES, FACET_EDGES, TetMesh

# Of a ten-node tetrahedron: the four corners, and the octahedron between them cut around a diagonal.
_CORNERS = [[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3]]
_DIAGONALS = np.array([[4, 9], [5, 7], [6, 8]])
_AROUND = ((5, 6, 7, 8), (4, 8, 9, 6), (4, 5, 9, 7))
_CHILDREN = np.array(
    [
        _CORNERS + [[*diagonal, a, b] for a, b in zip(ring, ring[1:] + ring[:1], strict=True)]
        for diagonal, ring in zip(_DIAGONALS, _AROUND, strict=True)
    ]
)
_FACET_CHILDREN = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])


def refined(mesh: TetMesh) -> TetMesh:
    """Halve every edge of a straight-sided mesh, keeping its order."""
    return split(raised(mesh)) if mesh.order == 1 else raised(split(mesh))


def raised(mesh: TetMesh) -> TetMesh:
    """Add mid-edge nodes to a first-order mesh, which makes it a second-order mesh."""
    n_points = len(mesh.points)

    def keys(cells: Ints, pairs: Ints) -> Ints:
        ends = np.sort(cells[:, np.array(pairs)], axis=2)
        return np.asarray(ends[..., 0] * n_points + ends[..., 1])

    edges, number = np.unique(keys(mesh.tets, EDGES), return_inverse=True)
    middles = mesh.points[np.stack(np.divmod(edges, n_points))].mean(axis=0)
    middle_nodes: dict[Surface, Ints] = {
        surface: n_points + np.searchsorted(edges, keys(facets, FACET_EDGES))
        for surface, facets in mesh.facets.items()
    }
    return TetMesh(
        np.concatenate([mesh.points, middles]),
        np.hstack([mesh.tets, n_points + number.reshape(-1, len(EDGES))]),
        {surface: np.hstack([facets, middle_nodes[surface]]) for surface, facets in mesh.facets.items()},
    )


def split(mesh: TetMesh) -> TetMesh:
    """Replace each second-order tetrahedron by eight first-order ones with the same nodes.

    The cut is along the shortest diagonal: with any other, elements would become longer at every refinement.
    """
    ends = mesh.points[mesh.tets[:, _DIAGONALS]]
    shortest = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2).argmin(axis=1)
    return TetMesh(
        mesh.points,
        np.take_along_axis(mesh.tets[:, None, :], _CHILDREN[shortest], axis=2).reshape(-1, 4),
        {surface: facets[:, _FACET_CHILDREN].reshape(-1, 3) for surface, facets in mesh.facets.items()},
    )
