"""Pins that are bonded to their bores: a traction all around each bore, the same everywhere on a plain one.

It is what finite-element programs make of a force on a cylindrical face: see `loads.bearing.Bonded`.
"""

from functools import cached_property

from fea.pins.prescribed import LoadedBore, PrescribedPins
from fea.solid.bonded_bore import BondedBore
from fea.solid.bore import BoreLoad
from geometry.surfaces import Surface
from loads.bearing import Bonded


class BondedPins(PrescribedPins):
    """Pins that pull one side of their bores as hard as they press on the other."""

    @cached_property
    def _bonds(self) -> dict[Surface, BondedBore]:
        return {bore.surface: BondedBore.of(bore.facets, self.n_nodes) for bore in self.bores}

    def load(self, bore: LoadedBore, force: tuple[float, float]) -> BoreLoad:
        """Load a bore with a force (x, y) on the whole rod, N."""
        return self._bonds[bore.surface].load(force, Bonded().area(bore.radius, bore.width))
