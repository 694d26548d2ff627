"""The mesh as arrays, independent of gmsh."""

from dataclasses import dataclass, field

import numpy as np

from geometry.arrays import Floats, Ints
from geometry.surfaces import INTERFACES, Surface

# Vertex pairs of the mid-edge nodes 4…9, in VTK's order (gmsh swaps the last two).
EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
# Vertices of the faces, anticlockwise from outside.
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
# All nodes of the faces, by the number of an element's: vertices, then the middles of (0,1), (1,2), (2,0).
_MIDDLE = {(int(a), int(b)): node for node, (a, b) in enumerate(EDGES, start=4)}
FACE_NODES = {
    4: FACES,
    10: np.array(
        [
            [*face, *(_MIDDLE[min(a, b), max(a, b)] for a, b in zip(face, np.roll(face, -1), strict=True))]
            for face in FACES.tolist()
        ]
    ),
}
# Vertex pairs of a facet's mid-edge nodes, and the nodes of a facet, by their number, that is turned over.
FACET_EDGES = np.array([[0, 1], [1, 2], [2, 0]])
FACET_TURN = {3: [0, 2, 1], 6: [0, 2, 1, 5, 4, 3]}
# Nodes of a tetrahedron, by their number, that is turned inside out: two vertices and the middles beside them
# change places.
TET_TURN = {4: [0, 2, 1, 3], 10: [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]}
# From gmsh's order of nodes to ours, by the order of the elements: the last two middles are swapped.
FROM_GMSH = {1: [0, 1, 2, 3], 2: [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]}


@dataclass(frozen=True)
class TetMesh:
    """Tetrahedra of first or second order with named boundary facets."""

    points: Floats  # (n_nodes, 3) coordinates, mm, rod frame
    # (n_elements, 4) or (n_elements, 10) node numbers in VTK's order: four vertices, positively oriented,
    # then the mid-edge nodes of `EDGES`
    tets: Ints
    # Per surface (n_facets, 3) or (n_facets, 6) node numbers: three vertices, then the mid-edge nodes of
    # (0,1), (1,2), (2,0); outward orientation
    facets: dict[Surface, Ints] = field(default_factory=dict)
    # (n_elements,) number of the part each element belongs to, or None if there is only one part
    part: Ints | None = None

    @property
    def interfaces(self) -> tuple[tuple[Surface, Surface], ...]:
        """Where separate parts touch: the surfaces of both sides."""
        return tuple(sides for sides in INTERFACES if sides[0] in self.facets)

    @property
    def order(self) -> int:
        """1 or 2: the order of geometry and nodes."""
        return 1 if self.tets.shape[1] == 4 else 2


class MeshError(RuntimeError):
    """No usable mesh could be made."""


# The faces of a tetrahedron by its vertices.


def submesh(mesh: TetMesh, number: int) -> tuple[TetMesh, Ints]:
    """The elements of a part, with the named facets that belong to them, and each node's number in the whole.

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
