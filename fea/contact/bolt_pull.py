"""A bolt as one unknown: its force, which presses under the head and at the other end of the grip."""

from dataclasses import dataclass

import numpy as np

from fea.contact.multipliers import Direction, Multipliers
from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh


@dataclass(frozen=True)
class BoltPull:
    """A bolt on the cell, or one of a pair of images about z = 0.

    Attributes
    ----------
    name
        Of the bolt.
    forces
        (3 n_nodes,) nodal forces on the cell of a bolt force of 1 N, N.
    share
        Of the bolt that belongs to the cell: one half if the plane z = 0 cuts it.
    stiffness
        Of what the mesh does not hold, head, shank and thread, N/mm.
    traction
        Per surface (n_nodes, 3) of a bolt force of 1 N, MPa.
    """

    name: str
    forces: Floats
    share: float
    stiffness: float
    traction: dict[Surface, Floats]

    @classmethod
    def of(
        cls,
        mesh: TetMesh,
        name: str,
        seats: dict[Surface, Ints],
        axis: Floats,
        stiffness: float,
        *,
        share: float,
    ) -> "BoltPull":
        """Spread the force of a bolt over its seats, as a uniform traction along its axis.

        Parameters
        ----------
        mesh
            The cell.
        name
            Of the bolt.
        seats
            Of `BOLT_HEAD` and `BOLT_THREAD`, the numbers of the facets that belong to this bolt.
        axis
            (3,) unit direction from the thread to the head.
        stiffness, share
            See the class.
        """
        n_nodes = len(mesh.points)
        forces, traction = np.zeros(3 * n_nodes), {}
        for surface, sign in ((Surface.BOLT_HEAD, -1.0), (Surface.BOLT_THREAD, 1.0)):
            facets = mesh.facets[surface][seats[surface]]
            own = TetMesh(mesh.points, mesh.tets, {surface: facets})
            pull = sign * axis
            pressed = Multipliers.of(own, surface, _constant(pull))
            stress = share / pressed.areas.sum()
            forces += stress * np.asarray(pressed.forces(n_nodes).sum(axis=1)).ravel()
            traction[surface] = np.zeros((n_nodes, 3))
            traction[surface][np.unique(facets)] = stress * pull
        return cls(name, forces, share, stiffness, traction)


def _constant(vector: Floats) -> Direction:
    return lambda places: np.broadcast_to(vector, places.shape)
