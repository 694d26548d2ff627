"""Pins that are bonded to their bores: a traction along the force, the same all over a plain bore.

This is what finite-element programs make of a force on a cylindrical face: Ansys Mechanical distributes it
"across one or more flat or curved faces, resulting in uniform traction" (Mechanical User's Guide 2024 R2,
section 17.6.2.6, Force), and a distributing coupling (RBE3, Ansys' Remote Force with deformable behaviour) to
a point on the axis gives the same. It is not a rigid pin glued into the bore, which keeps the bore round
(RBE2, rigid behaviour).
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fea.pins.prescribed import LinearPins, LoadedBore
from fea.solid.bore import BoreFacets, BoreLoad
from fea.solid.parity import ParityPair
from geometry.arrays import Floats
from geometry.surfaces import Surface


@dataclass(frozen=True)
class BondedBore:
    """A bore and what a pin force of 1 N along x, and of 1 N along y, does to it.

    The traction of a force F through the axis is t = F/A + ω e_z × (r − c), with the area A and the centroid
    c of the meshed bore. The second term, with ω = −(c × F)_z / ∫ |r − c|² dA, cancels the moment that the
    first has about the axis if c lies off it (an oil hole, a slanted end); on a plain bore it vanishes. It is
    the law of a distributing coupling (RBE3) whose reference point is on the axis.
    """

    forces: Floats  #: (2, n_nodes, 3) nodal forces on the cell, N
    traction: Floats  #: (2, n_nodes, 3) at the bore's nodes, MPa, zero elsewhere
    area: float  #: of the whole rod's bore as meshed, mm²
    #: Whether the cell represents its mirror image about y = 0: the forces along x are then symmetric and
    #: those along y antisymmetric
    cut_y: bool

    @classmethod
    def of(cls, bore: BoreFacets, n_nodes: int) -> "BondedBore":
        """Integrate the tractions over a bore of a mesh with `n_nodes` nodes."""
        places = (bore.shape_values @ bore.corners)[..., :2]  # (n_facets, n_points, 2) from the axis
        images = bore.images
        area = images * float(bore.areas.sum())
        center = images * np.einsum("fq,fqd->d", bore.areas, places) / area
        if bore.cut_y:
            center[1] = 0.0  # the mirror image has the opposite
        polar = images * float(np.einsum("fq,fqd,fqd->", bore.areas, places - center, places - center))
        x, y = center
        forces, tractions = np.zeros((2, 2, n_nodes, 3))
        for number, turn in enumerate((y / polar, -x / polar)):
            uniform = np.eye(2)[number] / area
            away = (each - center for each in (places, bore.corners[..., :2]))
            there, nodal = (uniform + turn * each[..., ::-1] * [-1.0, 1.0] for each in away)
            spread = np.swapaxes(bore.shape_values, -1, -2) @ (bore.areas[..., None] * there)
            np.add.at(forces[number, :, :2], bore.nodes, spread)
            tractions[number, bore.nodes, :2] = nodal
        return cls(forces, tractions, area, bore.cut_y)

    def load(self, force: tuple[float, float], area: float) -> BoreLoad:
        """Load the bore with the force (x, y) on the whole rod, N; `area` is that of the exact bore, mm²."""
        return BoreLoad(self._split(self.forces, force), self._split(self.traction, force), area / self.area)

    def _split(self, units: Floats, force: tuple[float, float]) -> ParityPair:
        return ParityPair.of(force[0] * units[0], force[1] * units[1], cut=self.cut_y)


class BondedPins(LinearPins):
    """Pins that pull one side of their bores as hard as they press on the other."""

    @cached_property
    def _bonds(self) -> dict[Surface, BondedBore]:
        return {bore.surface: BondedBore.of(bore.facets, self.n_nodes) for bore in self.bores}

    def load(self, bore: LoadedBore, force: tuple[float, float]) -> BoreLoad:
        """Load a bore with a force (x, y) on the whole rod, N."""
        return self._bonds[bore.surface].load(force, 2 * math.pi * bore.radius * bore.width)
