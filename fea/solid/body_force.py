"""Nodal forces of a field of body force."""

from collections.abc import Callable

from fea.solid import forms
from fea.solid.integration import VOLUME_DEGREE
from fea.solid.scikit_fem import by_point, volume_forces
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
    return volume_forces(mesh, forms.body_force(by_point(field)), VOLUME_DEGREE)
