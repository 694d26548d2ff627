"""Elastic compliance of clamped parts (VDI 2230-1:2015, section 5.1.2.1): sleeve and deformation cone.

A comparison for the meshed parts, whose compliance is computed. Lengths in mm, moduli in MPa.
"""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class ClampedParts:
    """Parts under a bolt, clamped along its axis.

    Attributes
    ----------
    grip
        l_K, mm.
    seat
        d_W: outer diameter of the head's seat, mm.
    hole
        d_h, mm.
    outer
        D_A: diameter of a cylinder around the bolt that the parts fill, mm.
    modulus
        E_P, MPa.
    nut
        Whether a nut seats on the far side, too; else the bolt is screwed into the last part.
    """

    grip: float
    seat: float
    hole: float
    outer: float
    modulus: float
    nut: bool = True

    @property
    def slope(self) -> float:
        """Tan φ of the cone's half angle, which depends on the parts' proportions."""
        slender = self.grip / self.seat
        wide = math.log(max(self.outer, self.seat) / self.seat)
        if self.nut:
            return 0.362 + 0.032 * math.log(slender / 2) + 0.153 * wide
        return 0.348 + 0.013 * math.log(slender) + 0.193 * wide

    @property
    def widest(self) -> float:
        """D_A,Gr: outer diameter that the cones reach, mm."""
        return self.seat + self._cones * self.grip * self.slope

    @property
    def compliance(self) -> float:
        """δ_P of a sleeve (outer at most seat), a cone with a sleeve, or cones alone, mm/N."""
        if self.outer <= self.seat:
            return 4 * self.grip / (math.pi * self.modulus * (self.outer**2 - self.hole**2))
        reach = min(self.outer, self.widest)
        cone = 2 / (self._cones * self.hole * self.slope) * self._logarithm(reach)
        sleeve = self.grip - (reach - self.seat) / (self._cones * self.slope)
        return (cone + 4 / (reach**2 - self.hole**2) * sleeve) / (math.pi * self.modulus)

    @property
    def _cones(self) -> int:
        """The guideline's w, over 1: cones that meet in the middle with a nut (1), one cone otherwise (2)."""
        return 1 if self.nut else 2

    def _logarithm(self, reach: float) -> float:
        w, h = self.seat, self.hole
        return math.log((w + h) * (reach - h) / ((w - h) * (reach + h)))
