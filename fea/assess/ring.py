"""A cylindrical ring under pressure, in plane stress.

Lamé & Clapeyron 1831; Timoshenko, Strength of Materials, part II, 3rd ed. 1956, section 41.
"""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Ring:
    """A ring or bush.

    Attributes
    ----------
    inner, outer
        Radii, mm.
    youngs_modulus, poissons_ratio
        E, MPa, and ν.
    """

    inner: float
    outer: float
    youngs_modulus: float
    poissons_ratio: float

    @property
    def _shape(self) -> float:
        """(outer² + inner²)/(outer² − inner²)."""
        return (self.outer**2 + self.inner**2) / (self.outer**2 - self.inner**2)

    @property
    def widening(self) -> float:
        """Growth of the bore's radius over an inner pressure, mm/MPa."""
        return self.inner / self.youngs_modulus * (self._shape + self.poissons_ratio)

    @property
    def shrinking(self) -> float:
        """Loss of the outer radius over an outer pressure, mm/MPa."""
        return self.outer / self.youngs_modulus * (self._shape - self.poissons_ratio)

    @property
    def hoop_at_bore(self) -> float:
        """Hoop stress at the bore over an inner pressure, tension positive."""
        return self._shape

    @property
    def hoop_at_bore_pressed(self) -> float:
        """Hoop stress at the bore over an outer pressure: compression, and uniaxial."""
        return -2 * self.outer**2 / (self.outer**2 - self.inner**2)

    @property
    def stress_at_bore(self) -> float:
        """Von Mises stress at the bore over an inner pressure p, from the hoop stress and −p."""
        hoop = self._shape
        return math.sqrt(hoop**2 + hoop + 1)

    def bursting(self, yield_strength: float) -> float:
        """Inner pressure that makes the whole ring yield (Tresca): S_y ln(outer/inner), MPa."""
        return yield_strength * math.log(self.outer / self.inner)

    def collapsing(self, yield_strength: float) -> float:
        """Outer pressure that makes the whole ring yield (Tresca): S_y (1 − inner/outer), MPa."""
        return yield_strength * (1 - self.inner / self.outer)
