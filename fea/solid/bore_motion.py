"""How a pin supports a bore: constraints on the mean motions of the bore's surface."""

from dataclasses import dataclass

import numpy as np

from fea.solid.bore import bore_facets
from fea.solid.parity import Parity
from fea.solid.supports import rigid_motions
from fea.solid.traction import traction_forces
from geometry.arrays import Floats
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

SLIDE_X, SLIDE_Y, SLIDE_Z, TURN_X, TURN_Y, TURN_Z = range(6)
BENDING = {SLIDE_Y, SLIDE_Z, TURN_X}  # those of a slender body along x as it bends and twists
# Each motion's parity about y = 0 and about z = 0.
MOTION_PARITY = (
    (Parity.SYMMETRIC, Parity.SYMMETRIC),
    (Parity.ANTISYMMETRIC, Parity.SYMMETRIC),
    (Parity.SYMMETRIC, Parity.ANTISYMMETRIC),
    (Parity.ANTISYMMETRIC, Parity.ANTISYMMETRIC),
    (Parity.SYMMETRIC, Parity.ANTISYMMETRIC),
    (Parity.ANTISYMMETRIC, Parity.SYMMETRIC),
)


@dataclass(frozen=True)
class ConstrainedSurface:
    """A surface and the mean motions of it that are constrained."""

    surface: Surface  #: A bore, or the end of a strut
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

    def row(motion: int) -> Floats:
        weights = traction_forces(mesh, surface, lambda places, _: rigid_motions(places, about)[motion])
        return np.asarray(weights / (weights * rigid_motions(mesh.points, about)[motion]).sum())

    return np.stack([row(motion) for motion in range(6)])


def motions_with(mesh: TetMesh, y: Parity, z: Parity = Parity.SYMMETRIC) -> list[int]:
    """Numbers of the rigid motions of fields with parities about the planes y = 0 and z = 0 of a cell."""
    cut_y, cut_z = (plane in mesh.facets for plane in (Surface.SYMMETRY_Y, Surface.SYMMETRY_Z))
    return [
        motion
        for motion, (own_y, own_z) in enumerate(MOTION_PARITY)
        if (own_y is y or not cut_y) and (own_z is z or not cut_z)
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
