"""A bolt as one unknown: its force, which presses under the head and at the other end of the grip."""

from dataclasses import dataclass, replace

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
        point: Floats | None = None,
    ) -> "BoltPull":
        """Spread the force of a bolt over its seats, as a traction along its axis.

        The traction is uniform but for a small linear part, which leads its resultant through the axis: the
        centroids of meshed annuli lie beside it, on either end by another distance, and a pair of forces
        that do not oppose each other would be a moment.

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
        point
            (3,) on the axis, mm; without it the traction is uniform.
        """
        n_nodes = len(mesh.points)
        forces, traction = np.zeros(3 * n_nodes), {}
        for surface, sign in ((Surface.BOLT_HEAD, -1.0), (Surface.BOLT_THREAD, 1.0)):
            facets = mesh.facets[surface][seats[surface]]
            own = TetMesh(mesh.points, mesh.tets, {surface: facets})
            pull = sign * axis
            pressed = Multipliers.of(own, surface, _constant(pull))
            across = np.zeros((0, 3)) if point is None else _levers(axis, halved=share < 1)
            origin = np.zeros(3) if point is None else point
            spread = share * _through(pressed, across, origin)
            led = replace(pressed, direction=_linear(pull, across, origin, spread))
            forces += np.asarray(led.forces(n_nodes).sum(axis=1)).ravel()
            nodes = np.unique(facets)
            traction[surface] = np.zeros((n_nodes, 3))
            traction[surface][nodes] = led.direction(mesh.points[nodes])
        return cls(name, forces, share, stiffness, traction)


def _constant(vector: Floats) -> Direction:
    return lambda places: np.broadcast_to(vector, places.shape)


def _levers(axis: Floats, *, halved: bool) -> Floats:
    """Unit vectors (n, 3) across an axis in which the cell holds the whole seat: not z if z = 0 halves it."""
    in_plane = np.cross([0.0, 0.0, 1.0], axis)
    return np.array([in_plane] if halved else [in_plane, np.cross(axis, in_plane)])


def _through(pressed: Multipliers, across: Floats, origin: Floats) -> Floats:
    """Coefficients (1 + n,) of the traction 1, (x − origin) · across of resultant 1 through the origin."""
    basis = np.concatenate(
        [np.ones((1, *pressed.areas.shape)), np.einsum("nk,fqk->nfq", across, pressed.places - origin)]
    )
    moments = np.einsum("ifq,jfq,fq->ij", basis, basis, pressed.areas)
    return np.asarray(np.linalg.solve(moments, np.eye(len(basis))[0]))


def _linear(pull: Floats, across: Floats, origin: Floats, spread: Floats) -> Direction:
    """Traction along `pull` with these coefficients."""
    return lambda places: (spread[0] + (places - origin) @ (spread[1:] @ across))[..., None] * pull
