"""Parts that touch without being joined: a mesh with nodes of its own for each body, and matching sides."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from geometry.arrays import Ints, linked_groups, twins
from geometry.surfaces import Surface
from mesh.tetmesh import FACE_NODES, FACET_TURN, TetMesh, face_counts, faces_behind

# Numbers of two parts that touch; the surfaces that their sides of the interface become.
Interfaces = Mapping[tuple[int, int], tuple[Surface, Surface]]


def separated(mesh: TetMesh, interfaces: Interfaces) -> tuple[TetMesh, Ints]:
    """Double the nodes between parts that only touch.

    Parts that share facets and are not named in `interfaces` stay joined. The second result (n_nodes,) is the
    earlier number of each node. Row k of the second side is the facet of row k of the first, turned over:
    ``second[:, FACET_TURN[n]]`` has the nodes at the places of ``first``. Raises `ValueError`: the mesh has
    only one part.
    """
    if mesh.part is None:
        raise ValueError("the mesh has only one part")
    behind = np.stack(twins(face_counts(mesh.tets)[0].ravel()))  # 4 · element + face, on both sides
    behind = behind[:, mesh.part[behind[0] // 4] != mesh.part[behind[1] // 4]]
    first, second = behind // 4
    sides = mesh.part[first], mesh.part[second]

    # Parts that share facets and are not separated make one body.
    apart = {frozenset(pair) for pair in interfaces}
    touching = np.unique(np.sort(np.stack(sides, axis=1), axis=1), axis=0)
    joined = [pair for pair in touching.tolist() if frozenset(pair) not in apart]
    body = linked_groups(int(mesh.part.max()) + 1, *np.array(joined, dtype=int).reshape(-1, 2).T)[mesh.part]
    n_points = len(mesh.points)
    keys, tets = np.unique(body[:, None] * n_points + mesh.tets, return_inverse=True)

    def renumbered(facets: Ints, elements: Ints) -> Ints:
        """New numbers of the nodes of facets, by the elements behind them."""
        return np.searchsorted(keys, body[elements][:, None] * n_points + facets)

    behind_of = faces_behind(mesh).items()
    facets = {name: [renumbered(mesh.facets[name], face // 4)] for name, (face, _) in behind_of}
    outwards = mesh.tets[first[:, None], FACE_NODES[mesh.tets.shape[1]][behind[0] % 4]]
    turn = FACET_TURN[outwards.shape[1]]
    for (one, other), (surface, opposite) in interfaces.items():
        ahead = (sides[0] == one) & (sides[1] == other)
        back = (sides[0] == other) & (sides[1] == one)
        near = np.concatenate([outwards[ahead], outwards[back][:, turn]])
        elements = np.concatenate([first[ahead], second[back]]), np.concatenate([second[ahead], first[back]])
        facets.setdefault(surface, []).append(renumbered(near, elements[0]))
        facets.setdefault(opposite, []).append(renumbered(near[:, turn], elements[1]))
    origin = keys % n_points
    named = {surface: np.concatenate(rows) for surface, rows in facets.items()}
    return replace(mesh, points=mesh.points[origin], tets=tets.reshape(mesh.tets.shape), facets=named), origin
