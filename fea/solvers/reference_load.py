"""The geometric stiffness of the reference load of buckling, with pin pressures of fixed direction."""

from collections.abc import Mapping
from itertools import product

import numpy as np
from scipy import sparse

from fea.solid.parity import Parity
from fea.solid.pins import TURN_Z, Held, mean_motions, motions
from geometry.arrays import Floats
from mesh.tetmesh import TetMesh


class ReferenceLoad:
    """K_σ of a reference load.

    Parameters
    ----------
    mesh
        The cell.
    ends
        Surfaces whose mean motions are constrained. If one may rotate about z, the direction of a pressure
        on it stays fixed.
    parts
        `GeometricStiffness` of the load's parts about y = 0.
    """

    def __init__(
        self, mesh: TetMesh, ends: tuple[Held, ...], parts: Mapping[Parity, sparse.csr_array]
    ) -> None:
        self._parts = parts
        self._pins: list[tuple[float, Floats]] = []
        forces = parts[Parity.SYMMETRIC] @ mesh.points
        for end in ends:
            if TURN_Z not in end.motions:
                nodes = np.unique(mesh.facets[end.surface])
                arm = motions(mesh.points[nodes], end.center)[TURN_Z]
                turned = np.cross([0.0, 0.0, 1.0], forces[nodes])
                row = mean_motions(mesh, end.surface, end.center)[TURN_Z]
                self._pins.append((float((arm * turned).sum()), row))

    def times(self, shape: Mapping[Parity, Floats], parity_z: Parity) -> dict[Parity, Floats]:
        """K_σ φ of shapes given by their parts (n_nodes, 3, k)."""
        product_of = {side: np.zeros_like(part) for side, part in shape.items()}
        for (own, matrix), (side, part) in product(self._parts.items(), shape.items()):
            product_of[Parity(own * side)] += (matrix @ part.reshape(len(part), -1)).reshape(part.shape)
        # The stress term alone describes forces that rotate with the bore; the pressure of a pin does not.
        turning = Parity.ANTISYMMETRIC if Parity.ANTISYMMETRIC in shape else Parity.SYMMETRIC
        for moment, row in self._pins if parity_z is Parity.SYMMETRIC else ():
            turn = np.einsum("ni,nik->k", row, shape[turning])
            product_of[turning] -= moment * row[:, :, None] * turn
        return product_of
