"""Supports: mirror planes, inertia relief, a clamped bore; and whether anything can still move."""

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from fea.solid.errors import UnderconstrainedError
from fea.solid.mechanism import FREE, bodies, free_shares, rigid_modes
from fea.solid.parity import Parity
from geometry.arrays import Floats, Mask
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

_MODES = ("slide along x", "slide along y", "slide along z", "turn about x", "turn about y", "turn about z")


def plane_conditions(mesh: TetMesh, parity: Parity, parity_z: Parity = Parity.SYMMETRIC) -> Mask:
    """Degrees of freedom (n_nodes, 3) that vanish on the mirror planes the mesh is cut at.

    Of a part that is symmetric about the plane that is the normal one, of an antisymmetric part the two
    tangential ones.

    Parameters
    ----------
    mesh
        The cell.
    parity, parity_z
        About y = 0 and z = 0.
    """
    fixed = np.zeros((len(mesh.points), 3), dtype=bool)
    for plane, normal, own in ((Surface.SYMMETRY_Y, 1, parity), (Surface.SYMMETRY_Z, 2, parity_z)):
        if plane in mesh.facets:
            across = np.arange(3) == normal
            fixed[mesh.facets[plane].ravel()] |= across if own is Parity.SYMMETRIC else ~across
    return fixed


def determinate_restraints(mesh: TetMesh) -> Mask:
    """Six degrees of freedom (n_nodes, 3) at three nodes that stop every rigid motion and nothing else.

    Node A at the far end of the big end is held in x, y and z, node B at the other end of the rod in
    y and z, node C off the line AB in z. Those that a mirror plane holds already coincide with it.
    """
    held = np.zeros((len(mesh.points), 3), dtype=bool)
    x, y, z = mesh.points.T
    # On the mirror planes, so that the reaction of each has the plane's symmetry.
    axial = np.hypot(np.abs(y), np.abs(z)) <= np.hypot(y, z).min() + 1e-9
    along = np.flatnonzero(axial) if np.count_nonzero(axial) > 1 else np.arange(len(x))
    a, b = along[x[along].argmin()], along[x[along].argmax()]
    level = np.flatnonzero(np.abs(z) <= np.abs(z).min() + 1e-9)
    c = level[np.abs(y[level] - y[a]).argmax()]
    held[a] = True
    held[b, 1:] = True
    held[c, 2] = True
    return held


def clamped(mesh: TetMesh, surface: Surface) -> Mask:
    """Every degree of freedom (n_nodes, 3) on a surface."""
    held = np.zeros((len(mesh.points), 3), dtype=bool)
    held[mesh.facets[surface].ravel()] = True
    return held


def components(mesh: TetMesh) -> npt.NDArray[np.int64]:
    """Number (n_nodes,) of the connected piece of the mesh that each node belongs to."""
    n_nodes = len(mesh.points)
    first = np.repeat(mesh.tets[:, 0], mesh.tets.shape[1] - 1)
    links = (np.ones(first.size, dtype=np.int8), (first, mesh.tets[:, 1:].ravel()))
    _, labels = connected_components(sparse.csr_array(links, shape=(n_nodes, n_nodes)), directed=False)
    return np.asarray(labels, dtype=np.int64)


def require_restrained(mesh: TetMesh, fixed: Mask) -> None:
    """Refuse a model that leaves a rigid motion to one of its connected pieces.

    Found before anything is factorised, from the rank of the six rigid modes of each piece on its fixed
    degrees of freedom; where pieces meet without a common facet, of those of all with their joints.

    Raises
    ------
    UnderconstrainedError
        Naming the piece, where there are several, and the motions left to it.
    """
    labels = components(mesh)
    count = int(labels.max()) + 1
    for piece in range(count):
        own = labels == piece
        motions = free_motions(mesh.points[own], fixed[own])
        if motions:
            who = "the model" if count == 1 else _piece(mesh.points[own], count)
            raise UnderconstrainedError(f"{who} can still move: {motions}. {_remedy(count)}")
    body = bodies(mesh)
    if body.max() > labels.max():
        _require_no_mechanism(mesh, body, fixed)


def _require_no_mechanism(mesh: TetMesh, body: npt.NDArray[np.int64], fixed: Mask) -> None:
    shares = free_shares(mesh, body, fixed)
    number = int(np.linalg.norm(shares, axis=1).argmax())
    motions = _in_words(shares[number])
    if motions:
        own = np.unique(mesh.tets[body == number])
        x, y, z = mesh.points[own].mean(axis=0)
        message = (
            f"a piece that meets the rest along an edge or at a point only, {len(own)} nodes around "
            f"({x:.4g}, {y:.4g}, {z:.4g}) mm, can still move: {motions}. Join the pieces over a face"
        )
        raise UnderconstrainedError(message)


def _in_words(share: Floats) -> str:
    return ", ".join(name for name, size in zip(_MODES, share, strict=True) if size > 0.1)


def free_motions(points: Floats, fixed: Mask) -> str:
    """Rigid motions of a body that its fixed degrees of freedom (n_nodes, 3) leave free, in words."""
    modes = rigid_modes(points)[fixed]
    values, vectors = np.linalg.eigh(modes.T @ modes)
    # Each fixed entry contributes order one to a mode it stops.
    free = vectors[:, values < FREE * max(values.max(initial=0.0), 1e-300)]
    # Which modes a null space is made of does not depend on the vectors that span it.
    return _in_words(np.linalg.norm(free, axis=1))


def _piece(points: Floats, count: int) -> str:
    x, y, z = points.mean(axis=0)
    return (
        f"one of {count} pieces that do not touch, {len(points)} nodes around ({x:.4g}, {y:.4g}, {z:.4g}) mm,"
    )


def _remedy(count: int) -> str:
    return "Add a support that stops this" + (" or join the pieces" if count > 1 else "")
