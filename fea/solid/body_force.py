"""Nodal forces of a field of body force."""

from collections.abc import Callable

from fea.solid.element import tabulate
from fea.solid.integration import VOLUME_DEGREE, volume_points
from fea.solid.traction import scattered
from geometry.arrays import Floats
from mesh.tetmesh import TetMesh


def body_forces(mesh: TetMesh, field: Callable[[Floats], Floats]) -> Floats:
    """Nodal forces ∫ N_a b dV, (n_nodes, 3), N.

    Parameters
    ----------
    mesh
        The mesh.
    field
        From places (n, 3), mm, to the force per volume b (n, 3), N/mm³.
    """
    places, volumes = volume_points(mesh)
    values = tabulate(mesh.tets.shape[1], VOLUME_DEGREE).values
    force = field(places.reshape(-1, 3)).reshape(places.shape) * volumes[..., None]
    return scattered(mesh.tets, values.T @ force, len(mesh.points))
