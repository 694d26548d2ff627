"""Balance the small resultants that would tilt a rod out of its plane of motion by its own inertia.

If a body is not symmetric about z = 0, its centre of gravity or the middle of a bore may lie off that plane,
or it has a product of inertia. Pressures that are constant along the pins then leave a small force along z
and small moments about x and y, which the restraints would react as point forces. As in any inertia relief,
the rigid accelerations that they cause balance them instead.
"""

from dataclasses import dataclass

import numpy as np

from fea.solid.inertia import Inertia
from fea.solid.parity import Split
from geometry.arrays import Floats
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

# Resultants that vanish in plane motion: force along z, moments about x and y.
_OUT_OF_PLANE = (2, 3, 4)


@dataclass(frozen=True)
class Tilt:
    """The inertia of a body without a mirror plane that keeps it in its plane of motion."""

    points: Floats  # (n_nodes, 3), mm
    # Nodal forces (3, n_nodes, 3) of rigid accelerations with one resultant each: a force of 1 N along z, a
    # moment of 1 N·mm about x, and about y
    fields: Floats

    @classmethod
    def of(cls, points: Floats, inertia: Inertia) -> "Tilt":
        """Form the fields of a body whose nodes are `points`."""
        w, moments = inertia.weight, (inertia.weight_x, inertia.weight_y, inertia.weight_z)
        shifted, turned = np.zeros((2, 3, len(points), 3))
        for axis in range(3):
            after, last = (axis + 1) % 3, (axis + 2) % 3
            shifted[axis, :, axis] = w
            turned[axis, :, after], turned[axis, :, last] = -moments[last], moments[after]
        rigid = np.concatenate([shifted, turned])
        reached = np.stack([resultants(points, field) for field in rigid], axis=1)
        scale = np.sqrt(np.diag(reached))  # mass and moments of inertia differ by powers of ten
        shares = np.linalg.inv(reached / np.outer(scale, scale)) / np.outer(scale, scale)
        return cls(points, np.tensordot(shares[:, _OUT_OF_PLANE].T, rigid, axes=1))

    @classmethod
    def where_free(cls, mesh: TetMesh, inertia: Inertia, *, held: bool) -> "Tilt | None":
        """Form the fields of a cell; None if a clamp or the mirror plane z = 0 prevents any tilt."""
        return None if held or Surface.SYMMETRY_Z in mesh.facets else cls.of(mesh.points, inertia)

    def balanced(self, forces: Floats) -> Floats:
        """Nodal forces (n_nodes, 3) plus the inertia forces that cancel their out-of-plane resultants."""
        return np.asarray(forces - np.tensordot(self.out_of_plane(forces), self.fields, axes=1))

    def out_of_plane(self, forces: Floats) -> Floats:
        """Force along z (N) and moments about x and y (N·mm) of nodal forces (n_nodes, 3)."""
        return resultants(self.points, forces)[list(_OUT_OF_PLANE)]


def resultants(points: Floats, forces: Floats) -> Floats:
    """Force (N) and moment about the origin (N·mm) of nodal forces (n_nodes, 3): (6,)."""
    return np.concatenate([forces.sum(axis=0), np.cross(points, forces).sum(axis=0)])


def imbalance(points: Floats, forces: Split, images: int) -> tuple[float, float]:
    """Resultant force (N) and moment about z (N·mm) of nodal forces on the whole rod, both zero in balance.

    Parameters
    ----------
    points
        Nodes of the cell, (n_nodes, 3).
    forces
        On the cell.
    images
        Number of cells that make the whole rod.
    """
    x_part = forces.symmetric
    y_part = forces.symmetric if forces.antisymmetric is None else forces.antisymmetric
    moment = points[:, 0] @ y_part[:, 1] - points[:, 1] @ y_part[:, 0]
    resultant = np.hypot(x_part[:, 0].sum(), y_part[:, 1].sum())
    return float(images * resultant), float(images * abs(moment))
