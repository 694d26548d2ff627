"""Press fits of a bushing or of bearing shells, by Lamé: an estimate before anything is solved.

The housing is taken as a ring of the rod's least wall; shells as a closed ring. Interferences are diametral.
"""

import math
from dataclasses import dataclass

from fea.base.material import Material
from geometry.errors import require


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


# Back pressure below which bearing shells may move in their housing, MPa (Kopeliovich, Crush height of engine
# bearings, SubsTech: 8 to 10).
LEAST_BACK_PRESSURE = 8.0


@dataclass(frozen=True)
class PressFit:
    """A ring pressed into another.

    Attributes
    ----------
    inner, outer
        The rings, which share a radius.
    interference
        By how much the outer diameter of the one exceeds the bore of the other, mm.
    """

    inner: Ring
    outer: Ring
    interference: float

    @property
    def pressure(self) -> float:
        """Pressure p = δ/2 / (widening + shrinking), MPa; 0 for a clearance."""
        return max(self.interference, 0.0) / 2 / (self.outer.widening + self.inner.shrinking)

    @property
    def inner_hoop(self) -> float:
        """Hoop stress at the bore of the inner ring, MPa; its size is the von Mises stress there."""
        return self.pressure * self.inner.hoop_at_bore_pressed

    @property
    def outer_hoop(self) -> float:
        """Hoop stress at the bore of the outer ring, MPa."""
        return self.pressure * self.outer.hoop_at_bore

    @property
    def outer_stress(self) -> float:
        """Von Mises stress at the bore of the outer ring, MPa."""
        return self.pressure * self.outer.stress_at_bore

    @property
    def closing(self) -> float:
        """Loss of diameter of the bore of the inner ring, mm."""
        hoop = self.inner_hoop
        return -2 * self.inner.inner * hoop / self.inner.youngs_modulus

    def retention(self, width: float, friction: float) -> float:
        """Axial force that slides the inner ring, μ p π d w, N."""
        return friction * self.pressure * math.pi * 2 * self.outer.inner * width


def warmed(interference: float, diameter: float, inner: float, outer: float, warming: float) -> float:
    """Return an interference after warming, mm: δ + (α_i − α_o) d ΔT.

    Parameters
    ----------
    interference
        At the reference temperature, diametral, mm; a clearance is negative.
    diameter
        Of the fit, mm.
    inner, outer
        Thermal expansion of the inner and the outer part, 1/K; moduli are taken as unchanged.
    warming
        K.
    """
    return interference + (inner - outer) * diameter * warming


def ring_of(inner: float, outer: float, material: Material) -> Ring:
    """Return a ring of a material, radii in mm."""
    return Ring(inner, outer, material.youngs_modulus, material.poissons_ratio)


def judge_fit(
    what: str, fit: PressFit, inner: Material, outer: Material, *, key: str, given: float
) -> tuple[str, ...]:
    """Judge an interference before it is solved.

    Parameters
    ----------
    what
        The inner part, in words.
    fit
        The fit.
    inner, outer
        Materials of the rings.
    key, given
        The study's key of the interference, and its value; that of the fit differs at another temperature.

    Raises
    ------
    InvalidValue
        One of the parts would yield through its whole wall: the pressure of an elastic model cannot arise.
    """
    pressure = fit.pressure
    for name, limit in (
        (what, fit.inner.collapsing(inner.yield_strength)),
        ("rod", fit.outer.bursting(outer.yield_strength)),
    ):
        most = given if pressure == 0 else given + fit.interference * (limit / pressure - 1)
        rule = f"makes the {name} yield through its wall (about {pressure:.3g} MPa; it bears {limit:.3g} MPa)"
        remedy = f"Keep it below about {most:.2g} mm."
        require(pressure <= limit, key, given, rule, remedy)
    return tuple(_yielding(what, fit, inner, outer))


def _yielding(what: str, fit: PressFit, inner: Material, outer: Material) -> list[str]:
    stresses = (what, -fit.inner_hoop, inner.yield_strength), ("rod", fit.outer_stress, outer.yield_strength)
    return [
        f"{what}: its interference of {fit.interference:.3g} mm makes the {part} yield at its bore (by Lamé "
        f"{stress:.0f} MPa, yield strength {strength:g} MPa); the model is elastic"
        for part, stress, strength in stresses
        if stress > strength
    ]


def judge_seat(what: str, fit: PressFit) -> tuple[str, ...]:
    """Warn of a fit that warming has opened, or of shells with too little pressure on their backs."""
    if fit.interference <= 0:
        return (f"{what}: loose in its seat, with a clearance of {-fit.interference:.2g} mm",)
    if what.endswith("shells") and fit.pressure < LEAST_BACK_PRESSURE:
        usual = f"{LEAST_BACK_PRESSURE:g} to 10 MPa are usual, for them not to move"
        return (f"{what}: by Lamé {fit.pressure:.2g} MPa on their backs; {usual}",)
    return ()
