"""Reflect a mesh about its cut planes, and extend fields on it in the same way."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from geometry.arrays import Floats, Ints
from geometry.surfaces import PLANE_AXIS, Surface
from mesh.tetmesh import FACET_TURN, TET_TURN, TetMesh, numbered

# A reflection turns an element inside out; exchanging two vertices turns it back.


@dataclass(frozen=True)
class MirroredMesh:
    """A mesh put together from reflections of a cell."""

    #: The whole. The cell's elements come first; the nodes stand in the order of `mesh.tetmesh`, in which a
    #: node of the cell comes before its images.
    mesh: TetMesh
    source: Ints  #: (n_nodes,) the node of the cell that each node is an image of
    element_source: Ints  #: (n_elements,) the element of the cell that each element is an image of
    #: (n_nodes, 3) +1, or −1 for the components of a vector that the reflections reverse
    sign: npt.NDArray[np.float64]

    def at(self, nodes: Ints) -> "MirroredMesh":
        """Extend fields to some nodes (n,) alone."""
        return replace(self, source=self.source[nodes], sign=self.sign[nodes])

    def vector(self, symmetric: Floats, antisymmetric: Floats | None = None) -> Floats:
        """Extend a vector field (n_cell, 3, …) from the cell to the whole mesh.

        Its parts are symmetric and antisymmetric about y = 0; both are symmetric about z = 0.
        """
        return self._signed(self.sign, symmetric, antisymmetric)

    def tensor(self, symmetric: Floats, antisymmetric: Floats | None = None) -> Floats:
        """Extend a symmetric tensor field (n_cell, 6, …), XX YY ZZ XY YZ XZ, from the cell to the whole."""
        return self._signed(tensor_signs(self.sign), symmetric, antisymmetric)

    def scalar(self, symmetric: Floats, antisymmetric: Floats | None = None) -> Floats:
        """Extend a scalar field (n_cell, …) from the cell to the whole mesh."""
        field = symmetric[self.source]
        if antisymmetric is not None:
            odd = antisymmetric[self.source]
            odd *= self.sign[:, 1].reshape(-1, *([1] * (symmetric.ndim - 1)))
            field += odd
        return field

    def _signed(self, sign: Floats, symmetric: Floats, antisymmetric: Floats | None) -> Floats:
        field = self.scalar(symmetric, antisymmetric)
        field *= sign.reshape(*sign.shape, *([1] * (symmetric.ndim - 2)))
        return field


def tensor_signs(sign: Floats) -> Floats:
    """Signs (n, 6) of the components of a tensor, XX YY ZZ XY YZ XZ, from those (n, 3) of a vector."""
    return np.asarray(sign[:, [0, 1, 2, 0, 1, 0]] * sign[:, [0, 1, 2, 1, 2, 2]])


def unmirrored(mesh: TetMesh) -> MirroredMesh:
    """Wrap a mesh that needs no reflection."""
    n_nodes, n_elements = len(mesh.points), len(mesh.tets)
    return MirroredMesh(mesh, np.arange(n_nodes), np.arange(n_elements), np.ones((n_nodes, 3)))


def reflect(whole: MirroredMesh, plane: Surface) -> MirroredMesh:
    """Add the mirror image about `plane`, whose facets the mesh must carry; they become interior."""
    mesh, axis = whole.mesh, PLANE_AXIS[plane]
    n_nodes = len(mesh.points)
    shared = np.isin(np.arange(n_nodes), mesh.facets[plane])
    image = np.arange(n_nodes)
    image[~shared] = n_nodes + np.arange(np.count_nonzero(~shared))
    turn = np.ones(3)
    turn[axis] = -1
    joined = TetMesh(
        np.concatenate([mesh.points, mesh.points[~shared] * turn]),
        np.concatenate([mesh.tets, image[mesh.tets][:, TET_TURN[mesh.tets.shape[1]]]]),
        {
            surface: np.concatenate([facets, image[facets][:, FACET_TURN[facets.shape[1]]]])
            for surface, facets in mesh.facets.items()
            if surface is not plane
        },
        None if mesh.part is None else np.concatenate([mesh.part, mesh.part]),
    )
    joined, order = numbered(joined)
    return MirroredMesh(
        joined,
        np.concatenate([whole.source, whole.source[~shared]])[order],
        np.concatenate([whole.element_source, whole.element_source]),
        np.concatenate([whole.sign, whole.sign[~shared] * turn])[order],
    )
