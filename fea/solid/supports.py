"""Boundary conditions: mirror planes, inertia relief, clamped and pinned bores; free rigid motions.

Pins constrain the mean motions of the surfaces of their bores.
"""

from dataclasses import dataclass
from functools import reduce

import numpy as np
from scipy.linalg import qr

from fea.solid.bore import bore_facets
from fea.solid.errors import UnderconstrainedError
from fea.solid.parity import Parity
from fea.solid.traction import traction_forces
from geometry.arrays import Floats, Ints, Mask, linked_groups, twins
from geometry.holes import place_text
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh, element_faces, face_keys

# An eigenvalue below this fraction of the largest belongs to a free motion.
_FREE = 1e-8


def bodies(mesh: TetMesh) -> Ints:
    """Number (n_elements,) of the body, joined over facets, that each element belongs to."""
    # 64 bits hold the keys of two million nodes.
    first, second = (face // 4 for face in twins(face_keys(element_faces(mesh.tets), len(mesh.points))))
    return linked_groups(len(mesh.tets), first, second)


def rigid_motions(points: Floats, center: Floats) -> Floats:
    """The six rigid motions (6, n_nodes, 3) about a centre (3,): slides, then turns by one radian."""
    slides = np.broadcast_to(np.eye(3)[:, None, :], (3, *points.shape))
    return np.concatenate([slides, np.cross(np.eye(3)[:, None, :], (points - center)[None])])


def rigid_modes(points: Floats) -> Floats:
    """The six rigid displacements (n_nodes, 3, 6), rotations about the centroid scaled to unit size."""
    centred = points - points.mean(axis=0)
    motions = rigid_motions(centred / np.abs(centred).max(), np.zeros(3))
    return np.ascontiguousarray(np.moveaxis(motions, 0, -1))


def free_shares(mesh: TetMesh, body: Ints, fixed: Mask) -> Floats:
    """Share (n_bodies, 6) of each body's rigid modes in the motions that supports and joints leave free.

    `body` (n_elements,) is from `bodies`; `fixed` (n_nodes, 3) are supported. Zero: the body cannot move.
    """
    count = int(body.max()) + 1
    first = np.full(len(mesh.points), -1)  # the first body that has the node; other bodies are joined to it
    modes_at = np.zeros((len(mesh.points), 3, 6))
    normal = np.zeros((6 * count, 6 * count))
    for number in range(count):
        nodes = np.unique(mesh.tets[body == number])
        modes = rigid_modes(mesh.points[nodes])
        of_body = slice(6 * number, 6 * number + 6)
        held = modes[fixed[nodes]]
        normal[of_body, of_body] += held.T @ held
        joined = first[nodes] >= 0
        for other in np.unique(first[nodes[joined]]):
            at = first[nodes] == other
            rows = np.zeros((3 * np.count_nonzero(at), 6 * count))
            rows[:, of_body] = modes[at].reshape(-1, 6)
            rows[:, 6 * other : 6 * other + 6] = -modes_at[nodes[at]].reshape(-1, 6)
            normal += rows.T @ rows
        first[nodes[~joined]], modes_at[nodes[~joined]] = number, modes[~joined]
    return _null_shares(normal).reshape(count, 6)


def _null_shares(normal: Floats) -> Floats:
    """Share (n,) of each unknown in the null space of AᵀA, whichever vectors span it."""
    values, vectors = np.linalg.eigh(normal)
    # Each fixed degree of freedom contributes a value of order one to a mode that it stops.
    free = vectors[:, values < _FREE * max(values.max(initial=0.0), 1e-300)]
    return np.asarray(np.linalg.norm(free, axis=1))


_MODES = [f"{motion} {axis}" for motion in ("translation along", "rotation about") for axis in "xyz"]
# Slope of a line that counts as parallel to the rod's axis.
_ALONG = 1e-9


def plane_conditions(mesh: TetMesh, parity: Parity, parity_z: Parity = Parity.SYMMETRIC) -> Mask:
    """Degrees of freedom (n_nodes, 3) that vanish on the mirror planes the mesh is cut at, by both parities.

    Of a symmetric field this is the normal component, of an antisymmetric one the tangential components.
    """
    fixed = np.zeros((len(mesh.points), 3), dtype=bool)
    for plane, normal, about_plane in ((Surface.SYMMETRY_Y, 1, parity), (Surface.SYMMETRY_Z, 2, parity_z)):
        if plane in mesh.facets:
            across = np.arange(3) == normal
            fixed[mesh.facets[plane].ravel()] |= across if about_plane is Parity.SYMMETRIC else ~across
    return fixed


def determinate_restraints(mesh: TetMesh) -> Mask:
    """Six degrees of freedom (n_nodes, 3) at three nodes that stop every rigid motion and nothing else.

    Node A at the outer end of the big end is held in x, y and z, node B at the other end of the rod in
    y and z, node C off the line AB in z. Some of them may coincide with those that a mirror plane holds.
    """
    held = np.zeros((len(mesh.points), 3), dtype=bool)
    x, y, z = mesh.points.T
    along = _on_axis(mesh)
    a, b = along[x[along].argmin()], along[x[along].argmax()]
    level = np.flatnonzero(np.abs(z) <= np.abs(z).min() + 1e-9)
    slope = (y[b] - y[a]) / (x[b] - x[a])
    slope = slope if abs(slope) > _ALONG else 0.0
    distance = np.abs(y - y[a] - slope * (x - x[a]))
    c = level[distance[level].argmax()]
    if Surface.SYMMETRY_Z not in mesh.facets and distance[c] < np.ptp(y) / 8:  # few nodes on z = 0, near AB
        c = distance.argmax()
    held[a] = True
    held[b, 1:] = True
    held[c, 2] = True
    return held


def _on_axis(mesh: TetMesh) -> Ints:
    """Nodes on the rod's axis, or, where these do not span half of it, on all mirror planes of the cell.

    A held node must lie on every mirror plane, where its reaction has the plane's symmetry: elsewhere the
    plane's own conditions and the restraint would hold the rod twice.
    """
    x, y, z = mesh.points.T
    axial = np.flatnonzero(np.hypot(np.abs(y), np.abs(z)) <= np.hypot(y, z).min() + 1e-9)
    if np.ptp(x[axial]) > np.ptp(x) / 2:
        return axial
    planes = [np.unique(mesh.facets[plane]) for plane in mesh.planes]
    return reduce(np.intersect1d, planes, np.arange(len(y)))


def clamped(mesh: TetMesh, surface: Surface) -> Mask:
    """Every degree of freedom (n_nodes, 3) on a surface."""
    held = np.zeros((len(mesh.points), 3), dtype=bool)
    held[mesh.facets[surface].ravel()] = True
    return held


def components(mesh: TetMesh) -> Ints:
    """Number (n_nodes,) of the connected piece of the mesh that each node belongs to."""
    first = np.repeat(mesh.tets[:, 0], mesh.tets.shape[1] - 1)
    return linked_groups(len(mesh.points), first, mesh.tets[:, 1:].ravel())


def require_restrained(mesh: TetMesh, fixed: Mask) -> None:
    """Refuse an under-constrained model, in which a connected piece can still move as a rigid body.

    This is found before factorising, from the rank of the six rigid modes of all pieces on their fixed
    degrees of freedom, and where they meet without a common facet. Raises `UnderconstrainedError`: naming the
    piece, if there are several, and its free motions.
    """
    body, label = bodies(mesh), components(mesh)
    shares = free_shares(mesh, body, fixed)
    number = int(np.linalg.norm(shares, axis=1).argmax())
    motions = _in_words(shares[number])
    if not motions:
        return
    nodes, count = np.unique(mesh.tets[body == number]), int(label.max()) + 1
    who, remedy = "the model", "Add a support"
    if body.max() or count > 1:
        who = f"{len(nodes)} nodes around {place_text(mesh.points[nodes].mean(axis=0))} mm"
    if np.count_nonzero(label == label[nodes[0]]) > len(nodes):
        who = f"a piece of {who} is connected to the rest only along an edge or at a point and"
        remedy = "Join the pieces over a face"
    elif count > 1:
        who, remedy = f"one of {count} disconnected pieces ({who})", f"{remedy} or join the pieces"
    raise UnderconstrainedError(f"{who} is under-constrained: nothing prevents {motions}. {remedy}")


def _in_words(share: Floats) -> str:
    return ", ".join(name for name, size in zip(_MODES, share, strict=True) if size > 0.1)


SLIDE_X, SLIDE_Y, SLIDE_Z, TURN_X, TURN_Y, TURN_Z = range(6)
BENDING = {SLIDE_Y, SLIDE_Z, TURN_X}  # those of a slender body along x as it bends and twists
# Each motion's parity about y = 0 and about z = 0.
_EVEN, _ODD = Parity.SYMMETRIC, Parity.ANTISYMMETRIC
_MOTION_PARITY = (_EVEN, _EVEN), (_ODD, _EVEN), (_EVEN, _ODD), (_ODD, _ODD), (_EVEN, _ODD), (_ODD, _EVEN)


@dataclass(frozen=True)
class ConstrainedSurface:
    """A surface and the mean motions of it that are constrained."""

    surface: Surface  #: a bore, or the end of a strut
    center: float  #: x of the centre (x, 0, 0) about which it turns, mm
    motions: tuple[int, ...]  #: the constrained ones of `SLIDE_X` … `TURN_Z`


def constrained_by_pins(rod_length: float) -> tuple[ConstrainedSurface, ConstrainedSurface]:
    """Pinned in the plane of motion and built-in sideways; the small end is free to slide along the rod."""
    return (
        ConstrainedSurface(Surface.BIG_END_BORE, 0.0, (SLIDE_X, SLIDE_Y, SLIDE_Z, TURN_X, TURN_Y)),
        ConstrainedSurface(Surface.SMALL_END_BORE, rod_length, (SLIDE_Y, SLIDE_Z, TURN_X, TURN_Y)),
    )


def mean_motions(mesh: TetMesh, surface: Surface, center: float) -> Floats:
    """The rows (6, n_nodes, 3) whose product with a displacement gives the six mean motions of a surface.

    A mean rotation is that of the rigid motion closest in the least-squares sense. On a cell of a symmetric
    body only the rows with the parity of the field are meaningful.
    """
    about = np.array([center, 0.0, 0.0])
    everywhere = rigid_motions(mesh.points, about)

    def row(motion: int) -> Floats:
        weights = traction_forces(mesh, surface, lambda places, _: rigid_motions(places, about)[motion])
        return np.asarray(weights / (weights * everywhere[motion]).sum())

    return np.stack([row(motion) for motion in range(6)])


def motions_with(mesh: TetMesh, y: Parity, z: Parity = Parity.SYMMETRIC) -> list[int]:
    """Numbers of the rigid motions of fields with parities about the planes y = 0 and z = 0 of a cell."""
    cut_y, cut_z = (plane in mesh.facets for plane in (Surface.SYMMETRY_Y, Surface.SYMMETRY_Z))
    return [
        motion
        for motion, (parity_y, parity_z) in enumerate(_MOTION_PARITY)
        if (parity_y is y or not cut_y) and (parity_z is z or not cut_z)
    ]


def bore_mean(mesh: TetMesh, surface: Surface, field: Floats) -> Floats:
    """Area mean of a nodal field (n_nodes, …) over a bore."""
    bore = bore_facets(mesh, surface, 0.0)
    nodal = bore.areas @ bore.shape_values
    weights = np.bincount(bore.nodes.ravel(), nodal.ravel(), minlength=len(mesh.points))
    return np.asarray(np.tensordot(weights / weights.sum(), field, axes=1))


def referred_to_bores(mesh: TetMesh, displacement: Floats) -> Floats:
    """Displacement (n_nodes, 3, n_cases), mm, minus the rigid motion of the bores.

    The mean of the big-end bore is at rest, that of the small-end bore stays on the x axis, and the big-end
    bore does not turn about the x axis: its mean turn is that of the closest rigid motion (least squares).
    """
    motions = np.moveaxis(rigid_motions(mesh.points, np.zeros(3)), 0, -1)
    turning = traction_forces(
        mesh, Surface.BIG_END_BORE, lambda places, _: rigid_motions(places, np.zeros(3))[TURN_X]
    )

    def means(field: Floats) -> Floats:
        big, small = (bore_mean(mesh, bore, field) for bore in (Surface.BIG_END_BORE, Surface.SMALL_END_BORE))
        return np.concatenate([big, small[1:], np.tensordot(turning, field, axes=2)[None]])

    return np.asarray(displacement - motions @ np.linalg.solve(means(motions), means(displacement)))


def isostatic_restraints(mesh: TetMesh, parities: tuple[Parity, Parity]) -> Mask:
    """Degrees of freedom (n,) that mirror planes fix, and one more for each rigid motion left to a piece.

    The cell is of one piece or of several that are not connected; the parities are about y = 0 and z = 0.
    """
    planes = plane_conditions(mesh, *parities).ravel()
    # On an interface, restraints at the same place on both sides would stop the forces between them.
    touching = [mesh.facets[side].ravel() for sides in mesh.interfaces for side in sides]
    held = planes | np.repeat(np.isin(np.arange(len(mesh.points)), np.concatenate([*touching, []])), 3)
    rigid, piece = np.where(held[:, None], 0.0, rigid_with(mesh, parities)), np.repeat(components(mesh), 3)
    for number in range(int(piece.max()) + 1):
        of_piece = np.where((piece == number)[:, None], rigid, 0.0)
        # Pivoting chooses degrees of freedom that are far apart.
        scaled = of_piece / np.abs(of_piece).max(axis=0, initial=1e-300)
        _, _, order = qr(scaled.T, mode="economic", pivoting=True)
        planes[order[: rigid.shape[1]]] = True
    return planes


def rigid_with(mesh: TetMesh, parities: tuple[Parity, Parity]) -> Floats:
    """Rigid motions (n, n_rigid) that have the parities."""
    motions = rigid_motions(mesh.points, mesh.points.mean(axis=0) * [1.0, 0.0, 0.0])
    return motions[motions_with(mesh, *parities)].reshape(-1, mesh.points.size).T
