"""Parts that touch without being joined: a mesh with nodes of its own for each body, and matching sides."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from geometry.arrays import Ints, linked_groups
from geometry.surfaces import Surface
from mesh.tetmesh import FACE_NODES, FACET_TURN, TetMesh, element_faces, faces_behind

# Numbers of two parts that touch; the surfaces that their sides of the interface become.
Interfaces = Mapping[tuple[int, int], tuple[Surface, Surface]]


def separated(mesh: TetMesh, interfaces: Interfaces) -> tuple[TetMesh, Ints]:
    """Double the nodes between parts that only touch.

    Parts that share facets and are not named in `interfaces` stay joined. The second result (n_nodes,) is the
    earlier number of each node. Row k of the second side is the facet of row k of the first, turned over:
    ``second[:, FACET_TURN[n]]`` has the nodes at the places of ``first``.

    Raises
    ------
    ValueError
        The mesh has only one part.
    """
    if mesh.part is None:
        raise ValueError("the mesh has only one part")
    body = _bodies(mesh, interfaces)[mesh.part]
    n_points = len(mesh.points)
    keys, tets = np.unique(body[:, None] * n_points + mesh.tets, return_inverse=True)
    tets = tets.reshape(mesh.tets.shape)
    origin = keys % n_points
    facets = {
        surface: np.searchsorted(keys, body[face // 4][:, None] * n_points + mesh.facets[surface])
        for surface, (face, _) in faces_behind(mesh).items()
    }
    facets |= _sides(mesh, tets, interfaces)
    return replace(mesh, points=mesh.points[origin], tets=tets, facets=facets), origin


def _bodies(mesh: TetMesh, interfaces: Interfaces) -> Ints:
    """Number of the body of each part: parts that share facets and are not separated make one."""
    apart = {frozenset(pair) for pair in interfaces}
    _, first, second = _inner(mesh)
    touching = np.unique(np.sort(np.stack([_part(mesh)[first], _part(mesh)[second]], axis=1), axis=1), axis=0)
    joined = [pair for pair in touching.tolist() if frozenset(pair) not in apart]
    return linked_groups(int(_part(mesh).max()) + 1, *np.array(joined, dtype=int).reshape(-1, 2).T)


def _part(mesh: TetMesh) -> Ints:
    return np.zeros(len(mesh.tets), dtype=np.int64) if mesh.part is None else mesh.part


def _inner(mesh: TetMesh) -> tuple[Ints, Ints, Ints]:
    """Faces between parts, by the elements on both sides: 4 · element + face of the first; the elements."""
    faces = np.sort(element_faces(mesh.tets), axis=1)
    order = np.lexsort(faces.T)
    same = (faces[order[1:]] == faces[order[:-1]]).all(axis=1)
    one, other = order[:-1][same], order[1:][same]
    between = _part(mesh)[one // 4] != _part(mesh)[other // 4]
    one, other = one[between], other[between]
    return one, one // 4, other // 4


def _sides(mesh: TetMesh, tets: Ints, interfaces: Interfaces) -> dict[Surface, Ints]:
    place, first, second = _inner(mesh)
    sides = _part(mesh)[first], _part(mesh)[second]
    rows_of: dict[Surface, list[Ints]] = {}
    for (one, other), (surface, opposite) in interfaces.items():
        ahead = (sides[0] == one) & (sides[1] == other)
        back = (sides[0] == other) & (sides[1] == one)
        facets = np.concatenate([_facets(mesh, place[ahead]), _turned(_facets(mesh, place[back]))])
        near = np.concatenate([first[ahead], second[back]])
        far = np.concatenate([second[ahead], first[back]])
        rows_of.setdefault(surface, []).append(_renumbered(mesh, tets, facets, near))
        rows_of.setdefault(opposite, []).append(_renumbered(mesh, tets, _turned(facets), far))
    return {surface: np.concatenate(rows) for surface, rows in rows_of.items()}


def _turned(facets: Ints) -> Ints:
    return facets[:, FACET_TURN[facets.shape[1]]]


def _facets(mesh: TetMesh, faces: Ints) -> Ints:
    """Nodes (n, 3 or 6) of faces given as 4 · element + face, oriented outwards."""
    return np.asarray(mesh.tets[(faces // 4)[:, None], FACE_NODES[mesh.tets.shape[1]][faces % 4]])


def _renumbered(mesh: TetMesh, tets: Ints, facets: Ints, elements: Ints) -> Ints:
    """New numbers of nodes that belong to the elements behind the facets."""
    nodes = mesh.tets[elements]
    at = (nodes[:, None, :] == facets[:, :, None]).argmax(axis=2)
    return np.take_along_axis(tets[elements], at, axis=1)
