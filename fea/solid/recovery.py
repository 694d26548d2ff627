"""Nodal stress from a displacement field."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
from scipy import sparse

from fea.material import Material
from fea.solid.elasticity import COMPONENTS, stress_from_gradient
from fea.solid.element import shape_functions, tabulate
from fea.solid.integration import inverse_and_determinant, jacobians, stiffness_degree
from fea.solid.parity import Parity
from fea.solid.recovery_surface import SurfaceStress
from geometry.surfaces import Surface
from mesh.mirror import PLANE_AXIS
from mesh.tetmesh import EDGES, TetMesh

Floats = npt.NDArray[np.float64]

_VERTICES = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


def stress_parity(plane: Surface) -> npt.NDArray[np.int64]:
    """Sign (6,) each stress component takes when a symmetric field is mirrored at `plane`."""
    axis = PLANE_AXIS[plane]
    return np.array([-1 if (i == axis) != (j == axis) else 1 for i, j in COMPONENTS])


def reference_nodes(n_nodes: int) -> Floats:
    """Places (n_nodes, 3) of the nodes of the reference tetrahedron."""
    if n_nodes == len(_VERTICES):
        return _VERTICES
    return np.vstack([_VERTICES, [(_VERTICES[a] + _VERTICES[b]) / 2 for a, b in EDGES]])


def gauss_places(n_nodes: int) -> Floats:
    """Places (n_places, 3) of the stiffness's Gauss points in the reference tetrahedron."""
    values = tabulate(n_nodes, stiffness_degree(n_nodes)).values
    return np.asarray(values @ reference_nodes(n_nodes))


def extrapolation(n_nodes: int) -> Floats:
    """Matrix (n_nodes, n_places) from values at the Gauss points to the linear field's at the nodes."""
    places, nodes = gauss_places(n_nodes), reference_nodes(n_nodes)
    if len(places) == 1:
        return np.ones((n_nodes, 1))
    return np.asarray(np.insert(nodes, 0, 1, axis=1) @ np.linalg.inv(np.insert(places, 0, 1, axis=1)))


class ElementStress:
    """Stress at fixed reference places of every element; the geometry is worked out once.

    Parameters
    ----------
    mesh
        The mesh.
    places
        (n_places, 3) in the reference tetrahedron; without it the Gauss points of the stiffness.
    """

    def __init__(self, mesh: TetMesh, places: Floats | None = None) -> None:
        n_nodes = mesh.tets.shape[1]
        self._tets = mesh.tets
        _, self._slopes = shape_functions(n_nodes, (gauss_places(n_nodes) if places is None else places).T)
        self._inverse, _ = inverse_and_determinant(jacobians(mesh.points[mesh.tets], self._slopes))

    def __call__(self, displacement: Floats, material: Material) -> Floats:
        """Stress (n_elements, n_places, 6, n_cases), MPa, of displacements (n_points, 3, n_cases), mm."""
        n_points, _, n_cases = displacement.shape
        n_places, n_nodes, _ = self._slopes.shape
        flat = self._slopes.transpose(0, 2, 1).reshape(3 * n_places, n_nodes)
        nodal = displacement.reshape(n_points, 3 * n_cases)[self._tets]
        by_reference = (flat @ nodal).reshape(-1, n_places, 3, 3 * n_cases)
        gradient = (self._inverse.swapaxes(-1, -2) @ by_reference).reshape(-1, n_places, 3, 3, n_cases)
        return stress_from_gradient(gradient.transpose(0, 1, 4, 3, 2), material).swapaxes(-1, -2)


class Recovery:
    """Continuous nodal stress; what depends on the mesh alone is worked out once.

    Inside the body, the plain mean over the elements that share a node, each extrapolated linearly
    from its Gauss points. On a mirror plane the other half adds the same values with the signs of
    `stress_parity`, so the mean stays for components that are even there and vanishes for those
    that are odd. On surfaces of known traction, `SurfaceStress`.

    Parameters
    ----------
    mesh
        The mesh; `mesh.facets` names the facets on its surfaces and mirror planes.
    planes
        The mirror planes it is cut at: `Surface.SYMMETRY_Y` (y = 0), `Surface.SYMMETRY_Z` (z = 0).
    surfaces
        The surfaces whose traction is known: those that are not held.
    """

    def __init__(
        self, mesh: TetMesh, planes: tuple[Surface, ...] = (), surfaces: tuple[Surface, ...] = ()
    ) -> None:
        n_points, (n_elements, n_nodes) = len(mesh.points), mesh.tets.shape
        self.gauss_stress = ElementStress(mesh)
        self._on_plane = {plane: np.unique(mesh.facets[plane]) for plane in planes}
        self._surface = SurfaceStress(mesh, surfaces, planes) if surfaces else None

        counts = np.bincount(mesh.tets.ravel(), minlength=n_points)
        weights = extrapolation(n_nodes) / counts[mesh.tets][:, :, None]
        n_places = weights.shape[2]
        places = np.broadcast_to(np.arange(n_elements * n_places).reshape(-1, 1, n_places), weights.shape)
        nodes = np.broadcast_to(mesh.tets[:, :, None], weights.shape)
        self._mean = sparse.csr_array(
            (weights.ravel(), (nodes.ravel(), places.ravel())), shape=(n_points, n_elements * n_places)
        )

    def nodal_stress(
        self,
        displacement: Floats,
        material: Material,
        parity: Parity = Parity.SYMMETRIC,
        traction: Mapping[Surface, Floats] | None = None,
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
        traction
            Per loaded surface (n_points, 3, n_cases), MPa, its part of that parity; of `surfaces`
            those not named are free.

        Returns
        -------
        ndarray
            (n_points, 6, n_cases), MPa, components in the order of `fea.solid.elasticity.COMPONENTS`.
        """
        n_cases = displacement.shape[2]
        sampled = self.gauss_stress(displacement, material).reshape(-1, 6 * n_cases)
        stress: Floats = (self._mean @ sampled).reshape(-1, 6, n_cases)
        if self._surface is not None:
            stress[self._surface.nodes] = self._surface(displacement, material, traction or {}, parity)
        for plane, nodes in self._on_plane.items():
            sign = stress_parity(plane) * (parity if plane is Surface.SYMMETRY_Y else 1)
            stress[np.ix_(nodes, np.flatnonzero(sign < 0))] = 0.0
        return stress
