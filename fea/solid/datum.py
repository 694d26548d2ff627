"""Displacement relative to the bores instead of to the restraints."""

import numpy as np

from fea.solid.bore import bore_facets
from geometry.arrays import Floats
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh


def bore_mean(mesh: TetMesh, surface: Surface, field: Floats) -> Floats:
    """Area mean of a nodal field (n_nodes, …) over a bore."""
    bore = bore_facets(mesh, surface, 0.0)
    nodal = bore.areas @ bore.shape_values
    weights = np.bincount(bore.nodes.ravel(), nodal.ravel(), minlength=len(mesh.points))
    return np.asarray(np.tensordot(weights / weights.sum(), field, axes=1))


def referred_to_bores(mesh: TetMesh, displacement: Floats, rod_length: float) -> Floats:
    """Displacement (n_nodes, 3, n_cases) minus the rigid motion of the line between the bores.

    The mean of the big-end bore is at rest and that of the small-end bore stays on the x axis.

    Parameters
    ----------
    mesh
        The whole rod.
    displacement
        mm, small.
    rod_length
        Distance between the bores, mm.
    """
    moved = displacement - bore_mean(mesh, Surface.BIG_END_BORE, displacement)
    _, across_y, across_z = bore_mean(mesh, Surface.SMALL_END_BORE, moved) / rod_length
    x, y, z = (coordinate[:, None] for coordinate in mesh.points.T)
    turn = np.stack([-across_y * y - across_z * z, across_y * x, across_z * x], axis=1)
    return np.asarray(moved - turn)
