"""Pins that are bonded to their bores: a traction along the force, the same all over a plain bore.

This is what finite-element programs make of a force on a cylindrical face: Ansys Mechanical distributes it
"across one or more flat or curved faces, resulting in uniform traction" (Mechanical User's Guide 2024 R2,
section 17.6.2.6, Force), and a distributing coupling (RBE3, Ansys' Remote Force with deformable behaviour) to
a point on the axis gives the same. It is not a rigid pin glued into the bore, which keeps the bore round
(RBE2, rigid behaviour).
"""

import math
from functools import cached_property

from fea.pins.prescribed import LoadedBore, PrescribedPins
from fea.solid.bonded_bore import BondedBore
from fea.solid.bore import BoreLoad
from geometry.surfaces import Surface


class BondedPins(PrescribedPins):
    """Pins that pull one side of their bores as hard as they press on the other."""

    @cached_property
    def _bonds(self) -> dict[Surface, BondedBore]:
        return {bore.surface: BondedBore.of(bore.facets, self.n_nodes) for bore in self.bores}

    def load(self, bore: LoadedBore, force: tuple[float, float]) -> BoreLoad:
        """Load a bore with a force (x, y) on the whole rod, N."""
        return self._bonds[bore.surface].load(force, 2 * math.pi * bore.radius * bore.width)
