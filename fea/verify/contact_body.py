"""A held body whose surface touches a pin: the contact problem of the benchmark cases."""

from functools import cached_property

import numpy as np
from scipy import sparse

from fea.base.material import Material
from fea.contact.active_set import Contact
from fea.contact.interfaces import PinInBore
from fea.contact.problem import ContactProblem
from fea.solid.assembly import SymmetricMatrix, pattern, stiffness
from fea.solid.parity import Parity
from fea.solvers.linear.amg import Operator
from fea.solvers.linear.choice import direct, factorise, schur
from fea.solvers.static import unheld, work
from fea.stress.recovery import Recovery
from fea.verify.body import mirror_planes
from geometry.arrays import Floats, Mask
from mesh.tetmesh import TetMesh


class TouchedBody:
    """A body, symmetric about y = 0, with its constraints and the one pin that touches it.

    Parameters
    ----------
    mesh, material
        The body.
    fixed
        (n_nodes, 3) constrained degrees of freedom, those of the mirror planes included.
    pin
        In its bore, or at whatever surface it touches.
    """

    def __init__(self, mesh: TetMesh, material: Material, fixed: Mask, pin: PinInBore) -> None:
        self.mesh, self._material, self._fixed, self._pin = mesh, material, fixed.ravel(), pin
        nothing = {Parity.SYMMETRIC: np.zeros((mesh.points.size, 0))}
        self.problem = ContactProblem(self, mesh, [pin], nothing, both_sides=False)

    @cached_property
    def _constrained(self) -> SymmetricMatrix:
        K = stiffness(self.mesh, self._material, pattern(self.mesh.tets, len(self.mesh.points)))
        return K.constrained(self._fixed)

    @cached_property
    def _factor(self) -> Operator:
        return factorise(self._constrained)

    def compliance(self, _parity: Parity, forces: sparse.csc_array) -> Floats:
        """Work (k, k) of symmetric forces (3 n_nodes, k) on what they cause."""
        free, complement = unheld(forces, self._fixed), schur(direct())
        return work(free, self._factor) if complement is None else complement(self._constrained, free)

    def touched(self, clearance: float, force: float) -> Contact:
        """Pressures (n,) at the vertices under a force along x on the whole body, N."""
        gap = self.problem.initial + (clearance - self._pin.clearance) * self._weights
        return self.problem.system.solve(gap, np.array([force]))

    @cached_property
    def _weights(self) -> Floats:
        return self.problem.unfolding.moments({Parity.SYMMETRIC: self._pin.multipliers.weights})

    def stress(self, pressure: Floats) -> Floats:
        """Nodal stress (n_nodes, 6) under pressures (n,), MPa."""
        own, n_nodes = self._pin.multipliers, len(self.mesh.points)
        forces = np.where(self._fixed, 0.0, self.problem.forces @ pressure)
        u = self._factor(forces[:, None]).reshape(n_nodes, 3, 1)
        nodes, values = own.at_nodes(pressure[:, None])
        traction = np.zeros((n_nodes, 3, 1))
        traction[nodes] = values[:, None] * own.direction(self.mesh.points[nodes])[..., None]
        recovery = Recovery(self.mesh, mirror_planes(self.mesh), (own.surface,))
        found = recovery.nodal_stress(u, self._material, Parity.SYMMETRIC, {own.surface: traction})
        return np.asarray(found[:, :, 0])


def contact_end(place: Floats, p: Floats) -> float:
    """Where the pressure (n,) at places (n,) ends: near it, its square is linear."""
    places = np.unique(np.round(place, 9))
    mean = np.array([p[np.abs(place - own) < 1e-8].mean() for own in places])
    last = np.flatnonzero(mean > 0)[-4:-1]
    return float(np.polyfit(mean[last] ** 2, places[last], 1)[1])
