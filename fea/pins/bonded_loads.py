"""Unit loads of pins that are bonded to their bores: a force along x and one along y on each, and inertia."""

import numpy as np

from fea.base.choices import Support
from fea.pins.pressure_loads import StoredFields
from fea.pins.unit_loads import ALONE, Contacts, Weights, inertial_fields
from fea.rod.meshed_rod import Bores
from fea.solid.bonded_bore import BondedBore
from fea.solid.bore import bore_facets
from fea.solid.inertia import Inertia
from fea.solid.tilt import Tilt
from geometry.arrays import Floats
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.instants import Instants
from mesh.tetmesh import TetMesh


class BondedLoads:
    """The unit loads of a meshed rod whose pins are bonded to it: they span every instant exactly.

    Parameters
    ----------
    mesh
        The meshed cell.
    bores
        Dimensions of the bores.
    inertia
        Inertia of the same mesh.
    support
        With a clamped big end, the crank force is a reaction and not applied.
    """

    together = ALONE
    series_error = 0.0
    jumps = False
    remembers = False

    def __init__(self, mesh: TetMesh, bores: Bores, inertia: Inertia, support: Support) -> None:
        self._inertia = inertia
        self._tilt = Tilt.where_free(mesh, inertia, held=support is Support.CLAMPED)
        places = {Surface.SMALL_END_BORE: bores.rod_length}
        if support is not Support.CLAMPED:
            places[Surface.BIG_END_BORE] = 0.0
        self._bonds = {
            surface: BondedBore.of(bore_facets(mesh, surface, x), len(mesh.points))
            for surface, x in places.items()
        }

    def fields(self) -> tuple[StoredFields, StoredFields]:
        """Return the even and the odd unit loads."""
        even, odd = inertial_fields(self._inertia)
        return self._fields(0, even), self._fields(1, odd)

    def _fields(self, axis: int, inertial: list[Floats]) -> StoredFields:
        """A unit force along an axis on every bore, then the inertia fields."""
        loads = [*(bond.forces[axis] for bond in self._bonds.values()), *inertial]
        if self._tilt is not None:  # balanced in every load separately, and so in their sum
            loads = [self._tilt.balanced(load) for load in loads]
        traction = {}
        for number, (surface, bond) in enumerate(self._bonds.items()):
            traction[surface] = np.zeros((*bond.traction.shape[1:], len(loads)))
            traction[surface][..., number] = bond.traction[axis]
        return StoredFields(tuple(loads), traction)

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:  # noqa: ARG002
        """Weights of the unit loads at n instants, as `UnitLoads.weights`."""
        given = {Surface.SMALL_END_BORE: instants.pin, Surface.BIG_END_BORE: instants.crank}
        forces = [given[surface] for surface in self._bonds]
        even = [*(force[:1] for force in forces), instants.motions[:2]]
        odd = [*(force[1:] for force in forces), instants.motions[2:]]
        return Weights(np.concatenate(even), np.concatenate(odd))

    def contacts(self, weights: Weights, instants: Instants, cycle: CrankCycle) -> Contacts:  # noqa: ARG002
        """Nothing: the load on the bores is prescribed."""
        return Contacts()
