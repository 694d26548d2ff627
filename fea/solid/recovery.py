"""Nodal stress from a displacement field: the mean of what the elements around a node say."""

from enum import IntEnum

import numpy as np
import numpy.typing as npt
from scipy import sparse

from fea.material import Material
from fea.solid.elasticity import COMPONENTS, stress_from_gradient
from fea.solid.element import shape_functions
from fea.solid.integration import inverse_and_determinant, jacobians
from geometry.surfaces import Surface
from mesh.tetmesh import EDGES, TetMesh

Floats = npt.NDArray[np.float64]

_VERTICES = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])

# The axis along which each mirror plane reflects.
NORMAL_AXIS = {Surface.SYMMETRY_Y: 1, Surface.SYMMETRY_Z: 2}


class Parity(IntEnum):
    """How a solution continues across the plane y = 0."""

    SYMMETRIC = 1
    ANTISYMMETRIC = -1


def stress_parity(plane: Surface) -> npt.NDArray[np.int64]:
    """Sign (6,) each stress component takes when a symmetric field is mirrored at `plane`."""
    axis = NORMAL_AXIS[plane]
    return np.array([-1 if (i == axis) != (j == axis) else 1 for i, j in COMPONENTS])


def reference_nodes(n_nodes: int) -> Floats:
    """Places (n_nodes, 3) of the nodes of the reference tetrahedron."""
    if n_nodes == len(_VERTICES):
        return _VERTICES
    return np.vstack([_VERTICES, [(_VERTICES[a] + _VERTICES[b]) / 2 for a, b in EDGES]])


class ElementStress:
    """Stress at fixed reference points of every element; the geometry is worked out once.

    Parameters
    ----------
    mesh
        The mesh.
    reference_points
        (n_places, 3) places in the reference tetrahedron.
    """

    def __init__(self, mesh: TetMesh, reference_points: Floats) -> None:
        self.tets = mesh.tets
        _, self.slopes = shape_functions(mesh.tets.shape[1], reference_points.T)
        self.inverse, _ = inverse_and_determinant(jacobians(mesh.points[mesh.tets], self.slopes))

    def __call__(self, displacement: Floats, material: Material) -> Floats:
        """Stress (n_elements, n_places, 6, n_cases), MPa, of displacements (n_points, 3, n_cases), mm."""
        n_points, _, n_cases = displacement.shape
        n_places, n_nodes, _ = self.slopes.shape
        flat = self.slopes.transpose(0, 2, 1).reshape(3 * n_places, n_nodes)
        nodal = displacement.reshape(n_points, 3 * n_cases)[self.tets]
        by_reference = (flat @ nodal).reshape(-1, n_places, 3, 3 * n_cases)
        gradient = (self.inverse.swapaxes(-1, -2) @ by_reference).reshape(-1, n_places, 3, 3, n_cases)
        return stress_from_gradient(gradient.transpose(0, 1, 4, 3, 2), material).swapaxes(-1, -2)


class Recovery:
    """Continuous nodal stress: the plain mean over the elements that share a node.

    On a mirror plane the other half adds the same values with the signs of `stress_parity`, so the
    mean stays for components that are even there and vanishes for those that are odd.

    Parameters
    ----------
    mesh
        The mesh; `mesh.facets` names the facets on the mirror planes.
    planes
        The mirror planes it is cut at: `Surface.SYMMETRY_Y` (y = 0), `Surface.SYMMETRY_Z` (z = 0).
    """

    def __init__(self, mesh: TetMesh, planes: tuple[Surface, ...] = ()) -> None:
        n_points, n_nodes = len(mesh.points), mesh.tets.shape[1]
        self._on_plane = {plane: np.unique(mesh.facets[plane]) for plane in planes}
        self._at_nodes = ElementStress(mesh, reference_nodes(n_nodes))
        counts = np.bincount(mesh.tets.ravel(), minlength=n_points)
        place = np.arange(mesh.tets.size)
        self._mean = sparse.csr_array(
            (1 / counts[mesh.tets.ravel()], (mesh.tets.ravel(), place)), shape=(n_points, mesh.tets.size)
        )

    def nodal_stress(
        self, displacement: Floats, material: Material, parity: Parity = Parity.SYMMETRIC
    ) -> Floats:
        """Recover the stress at the nodes.

        Parameters
        ----------
        displacement
            (n_points, 3, n_cases), mm.
        material
            Of every element.
        parity
            Of the solution about y = 0, where the mesh is cut there; about z = 0 it is symmetric.

        Returns
        -------
        ndarray
            (n_points, 6, n_cases), MPa, components in the order of `fea.solid.elasticity.COMPONENTS`.
        """
        sampled = self._at_nodes(displacement, material)
        n_cases = displacement.shape[2]
        stress: Floats = (self._mean @ sampled.reshape(-1, 6 * n_cases)).reshape(-1, 6, n_cases)
        for plane, nodes in self._on_plane.items():
            sign = stress_parity(plane) * (parity if plane is Surface.SYMMETRY_Y else 1)
            stress[np.ix_(nodes, np.flatnonzero(sign < 0))] = 0.0
        return stress
