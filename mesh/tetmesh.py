"""The mesh as arrays, independent of gmsh: faces, separate parts, numbering, refinement, mirror images."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from geometry.arrays import Floats, Ints, Mask, linked_groups
from geometry.errors import public
from geometry.surfaces import INTERFACES, PLANE_AXIS, Surface

# Vertex pairs of the mid-edge nodes 4…9, in VTK's order (gmsh swaps the last two).
EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
# Vertices of the faces, anticlockwise from outside.
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
# All nodes of the faces, by the number of an element's: vertices, then the middles of (0,1), (1,2), (2,0).
FACE_NODES = {4: FACES, 10: np.hstack([FACES, [[6, 5, 4], [4, 8, 7], [7, 9, 6], [5, 9, 8]]])}
# Vertex pairs of a facet's mid-edge nodes, and the nodes of a facet, by their number, that is turned over.
FACET_EDGES = np.array([[0, 1], [1, 2], [2, 0]])
FACET_TURN = {3: [0, 2, 1], 6: [0, 2, 1, 5, 4, 3]}
# Nodes of a tetrahedron turned inside out: two vertices and the middles beside them change places.
TET_TURN = {4: [0, 2, 1, 3], 10: [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]}
# From gmsh's order of nodes to ours, by the order of the elements: the last two middles are swapped.
FROM_GMSH = {1: [0, 1, 2, 3], 2: [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]}


@dataclass(frozen=True)
class TetMesh:
    """Tetrahedra of first or second order with named boundary facets."""

    points: Floats  #: (n_nodes, 3) coordinates, mm, rod frame
    #: (n_elements, 4) or (n_elements, 10) node numbers in VTK's order: four vertices, positively oriented,
    #: then the mid-edge nodes of `EDGES`
    tets: Ints
    #: Per surface (n_facets, 3) or (n_facets, 6) node numbers: three vertices, then the mid-edge nodes of
    #: (0,1), (1,2), (2,0); outward orientation
    facets: dict[Surface, Ints] = field(default_factory=dict)
    #: (n_elements,) number of the part each element belongs to, or None if there is only one part
    part: Ints | None = None

    @property
    def planes(self) -> tuple[Surface, ...]:
        """The mirror planes at which it is cut."""
        return tuple(plane for plane in PLANE_AXIS if plane in self.facets)

    @property
    def interfaces(self) -> tuple[tuple[Surface, Surface], ...]:
        """Surfaces of both sides where separate parts touch."""
        return tuple(sides for sides in INTERFACES if sides[0] in self.facets)

    @property
    def order(self) -> int:
        """1 or 2: the order of geometry and nodes."""
        return 1 if self.tets.shape[1] == 4 else 2


@public
class MeshError(RuntimeError):
    """No usable mesh could be made."""


def submesh(mesh: TetMesh, number: int) -> tuple[TetMesh, Ints]:
    """A part's elements, their named facets, and the nodes' numbers in the whole. `ValueError`: no parts."""
    if mesh.part is None:
        raise ValueError("the mesh has only one part")
    tets = mesh.tets[mesh.part == number]
    nodes = np.unique(tets)
    local = np.full(len(mesh.points), -1)
    local[nodes] = np.arange(nodes.size)
    keys = face_keys(element_faces(tets), len(mesh.points))
    facets = {}
    for surface, every in mesh.facets.items():
        mine = np.isin(face_keys(every[:, :3], len(mesh.points)), keys)
        if mine.any():
            facets[surface] = local[every[mine]]
    return TetMesh(mesh.points[nodes], local[tets], facets), nodes


def element_faces(tets: Ints) -> Ints:
    """Vertices (4 n_elements, 3) of the faces of elements; face k of element e is in row 4 e + k."""
    return np.asarray(tets[:, FACES].reshape(-1, 3))


def face_keys(faces: Ints, n_points: int) -> Ints:
    """One number for the three nodes of a face, independent of their order."""
    a, b, c = np.sort(faces, axis=1).T
    return np.asarray((a * n_points + b) * n_points + c)


def _even(faces: Ints) -> Mask:
    """Whether the nodes are an even permutation of their ascending order."""
    a, b, c = faces.T
    return np.asarray((a < b).astype(int) + (b < c) + (c < a) == 2)


def faces_behind(mesh: TetMesh) -> dict[Surface, tuple[Ints, Ints]]:
    """Per surface, the face (n,) behind each facet, as a row of `element_faces`, and how many there are."""
    keys = face_keys(element_faces(mesh.tets), len(mesh.points))
    order = np.argsort(keys)
    behind = {}
    for surface, facets in mesh.facets.items():
        wanted = face_keys(facets[:, :3], len(mesh.points))
        first, after = (np.searchsorted(keys, wanted, side, order) for side in ("left", "right"))
        behind[surface] = order[np.minimum(first, len(order) - 1)], after - first
    return behind


def outward(mesh: TetMesh) -> TetMesh:
    """Return the mesh with facets oriented outwards. Raises `MeshError`: one bounds no or two elements."""
    even, oriented = _even(element_faces(mesh.tets)), {}
    for surface, (face, count) in faces_behind(mesh).items():
        facets = mesh.facets[surface]
        astray = count != 1
        if astray.any():
            x, y, z = mesh.points[facets[astray][0, :3]].mean(axis=0)
            raise MeshError(
                f"{astray.sum()} surface triangles do not bound exactly one tetrahedron each; the first is "
                f"at ({x:.1f}, {y:.1f}, {z:.1f}) mm. The solid may be damaged: export it again, or try "
                "another --size"
            )
        wrong = even[face] != _even(facets[:, :3])
        oriented[surface] = np.where(wrong[:, None], facets[:, FACET_TURN[facets.shape[1]]], facets)
    return replace(mesh, facets=oriented)


def face_counts(tets: Ints) -> tuple[Ints, Ints]:
    """Return a number of each face (n_elements, 4), equal for equal vertices, and how often each occurs."""
    a, b, c = np.sort(element_faces(tets), axis=1).T
    n_points = int(tets.max(initial=0)) + 1
    _, edge = np.unique(a * n_points + b, return_inverse=True)
    _, which, counts = np.unique(edge * n_points + c, return_inverse=True, return_counts=True)
    return which.reshape(-1, 4), counts


def folded(tets: Ints) -> Mask:
    """Elements (n_elements,), positively oriented, that lie on the same side of a face as their neighbour."""
    which, counts = face_counts(tets)
    evens = np.bincount(which.ravel(), _even(element_faces(tets)))
    return np.asarray(((counts == 2) & (evens != 1))[which].any(axis=1))


def boundary_facets(tets: Ints) -> Ints:
    """Faces (n, 3) or (n, 6) that belong to a single element, oriented outwards, in `TetMesh`'s order."""
    which, counts = face_counts(tets)
    element, face = np.nonzero(counts[which] == 1)
    return np.asarray(tets[element[:, None], FACE_NODES[tets.shape[1]][face]])


# Numbers of two parts that touch; the surfaces that their sides of the interface become.
Interfaces = Mapping[tuple[int, int], tuple[Surface, Surface]]


def separated(mesh: TetMesh, interfaces: Interfaces) -> tuple[TetMesh, Ints]:
    """Double the nodes between parts that only touch.

    Parts that share facets and are not in `interfaces` stay joined. The second result (n_nodes,) is the
    earlier number of each node. Row k of the second side is that of the first, turned over: ``second[:,
    FACET_TURN[n]]`` has the nodes at the places of ``first``. Raises `ValueError`: a single part.
    """
    if mesh.part is None:
        raise ValueError("the mesh has only one part")
    faces = np.sort(element_faces(mesh.tets), axis=1)
    order = np.lexsort(faces.T)
    same = (faces[order[1:]] == faces[order[:-1]]).all(axis=1)
    behind = np.stack([order[:-1][same], order[1:][same]])  # 4 · element + face, on both sides
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


# scikit-fem numbers vertices first, then the nodes amid the edges, sorted by their two vertices with the
# lower number first (`skfem.MeshTet.edges`). In this order the degree of freedom of its vector elements is
# 3 · node + axis, as it is ours: matrices agree entry by entry.


def numbered(mesh: TetMesh) -> tuple[TetMesh, Ints]:
    """Renumber the nodes of a mesh as scikit-fem does; vertices keep their order, as elements and facets do.

    The second result (n_nodes,) is the earlier number of each node; nodes without elements come last.
    """
    order = scikit_fem_order(mesh.tets, len(mesh.points))
    number = np.argsort(order)
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


# The eight tetrahedra into which a ten-node one is split: the four corners, and the octahedron between them
# cut around one of its three diagonals.
_CORNERS = [[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3]]
_DIAGONALS = np.array([[4, 9], [5, 7], [6, 8]])
_AROUND = ((5, 6, 7, 8), (4, 8, 9, 6), (4, 5, 9, 7))
CHILDREN = np.array(
    [
        _CORNERS + [[*diagonal, a, b] for a, b in zip(ring, ring[1:] + ring[:1], strict=True)]
        for diagonal, ring in zip(_DIAGONALS, _AROUND, strict=True)
    ]
)
FACET_CHILDREN = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])


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
        np.take_along_axis(mesh.tets[:, None, :], CHILDREN[shortest], axis=2).reshape(-1, 4),
        {surface: facets[:, FACET_CHILDREN].reshape(-1, 3) for surface, facets in mesh.facets.items()},
    )


# A reflection turns an element inside out; exchanging two vertices turns it back.


@dataclass(frozen=True)
class MirroredMesh:
    """A mesh put together from reflections of a cell."""

    #: The whole. The cell's elements come first; the nodes stand in the order of `mesh.tetmesh`, in which a
    #: node of the cell comes before its images.
    mesh: TetMesh
    source: Ints  #: (n_nodes,) the node of the cell that each node is an image of
    element_source: Ints  #: (n_elements,) the element of the cell that each element is an image of
    #: (n_nodes, 3) +1, or −1 for the components of a vector that the reflections reverse
    sign: npt.NDArray[np.float64]

    def at(self, nodes: Ints) -> "MirroredMesh":
        """Extend fields to some nodes (n,) alone."""
        return replace(self, source=self.source[nodes], sign=self.sign[nodes])

    def vector(self, symmetric: Floats, antisymmetric: Floats | None = None) -> Floats:
        """Extend a vector field (n_cell, 3, …) from the cell to the whole mesh.

        Its parts are symmetric and antisymmetric about y = 0; both are symmetric about z = 0.
        """
        return self._signed(self.sign, symmetric, antisymmetric)

    def tensor(self, symmetric: Floats, antisymmetric: Floats | None = None) -> Floats:
        """Extend a symmetric tensor field (n_cell, 6, …), XX YY ZZ XY YZ XZ, from the cell to the whole."""
        return self._signed(tensor_signs(self.sign), symmetric, antisymmetric)

    def scalar(self, symmetric: Floats, antisymmetric: Floats | None = None) -> Floats:
        """Extend a scalar field (n_cell, …) from the cell to the whole mesh."""
        field = symmetric[self.source]
        if antisymmetric is not None:
            odd = antisymmetric[self.source]
            odd *= self.sign[:, 1].reshape(-1, *([1] * (symmetric.ndim - 1)))
            field += odd
        return field

    def _signed(self, sign: Floats, symmetric: Floats, antisymmetric: Floats | None) -> Floats:
        field = self.scalar(symmetric, antisymmetric)
        field *= sign.reshape(*sign.shape, *([1] * (symmetric.ndim - 2)))
        return field


def tensor_signs(sign: Floats) -> Floats:
    """Signs (n, 6) of the components of a tensor, XX YY ZZ XY YZ XZ, from those (n, 3) of a vector."""
    return np.asarray(sign[:, [0, 1, 2, 0, 1, 0]] * sign[:, [0, 1, 2, 1, 2, 2]])


def unmirrored(mesh: TetMesh) -> MirroredMesh:
    """Wrap a mesh that needs no reflection."""
    n_nodes, n_elements = len(mesh.points), len(mesh.tets)
    return MirroredMesh(mesh, np.arange(n_nodes), np.arange(n_elements), np.ones((n_nodes, 3)))


def reflect(whole: MirroredMesh, plane: Surface) -> MirroredMesh:
    """Add the mirror image about `plane`, whose facets the mesh must carry; they become interior."""
    mesh, axis = whole.mesh, PLANE_AXIS[plane]
    n_nodes = len(mesh.points)
    shared = np.isin(np.arange(n_nodes), mesh.facets[plane])
    image = np.arange(n_nodes)
    image[~shared] = n_nodes + np.arange(np.count_nonzero(~shared))
    turn = np.ones(3)
    turn[axis] = -1
    joined = TetMesh(
        np.concatenate([mesh.points, mesh.points[~shared] * turn]),
        np.concatenate([mesh.tets, image[mesh.tets][:, TET_TURN[mesh.tets.shape[1]]]]),
        {
            surface: np.concatenate([facets, image[facets][:, FACET_TURN[facets.shape[1]]]])
            for surface, facets in mesh.facets.items()
            if surface is not plane
        },
        None if mesh.part is None else np.concatenate([mesh.part, mesh.part]),
    )
    joined, order = numbered(joined)
    return MirroredMesh(
        joined,
        np.concatenate([whole.source, whole.source[~shared]])[order],
        np.concatenate([whole.element_source, whole.element_source]),
        np.concatenate([whole.sign, whole.sign[~shared] * turn])[order],
    )
