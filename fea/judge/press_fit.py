"""Press fits of a bushing or of bearing shells, by Lamé: an estimate before anything is solved.

The housing is taken as a ring of the rod's least wall; shells as a closed ring. Interferences are diametral.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from fea.base.material import Material
from fea.base.note import Note, assumptions, doubt, remark, warning
from fea.study.assembly_table import BUSHING, SHELL, AssemblyTable
from fea.study.material_table import REFERENCE_TEMPERATURE, MaterialTable, thermal_expansion
from geometry.errors import require
from geometry.rod import Rod


@dataclass(frozen=True)
class Ring:
    """A ring or bush between an inner and an outer radius, mm."""

    inner: float
    outer: float
    material: Material

    @property
    def hoop(self) -> float:
        """Hoop stress at the bore over an inner pressure: (outer² + inner²)/(outer² − inner²)."""
        return (self.outer**2 + self.inner**2) / (self.outer**2 - self.inner**2)

    @property
    def widening(self) -> float:
        """Growth of the bore's radius over an inner pressure, mm/MPa."""
        return self.inner / self.material.youngs_modulus * (self.hoop + self.material.poissons_ratio)

    @property
    def shrinking(self) -> float:
        """Loss of the outer radius over an outer pressure, mm/MPa."""
        return self.outer / self.material.youngs_modulus * (self.hoop - self.material.poissons_ratio)


# Back pressure below which bearing shells may move in their housing, MPa (Kopeliovich, Crush height of engine
# bearings, SubsTech: 8 to 10).
LEAST_BACK_PRESSURE = 8.0


@dataclass(frozen=True)
class PressFit:
    """A ring pressed into another."""

    #: inner, outer: the rings, which share a radius
    inner: Ring
    outer: Ring
    interference: float  #: by how much the outer diameter of the one exceeds the bore of the other, mm

    @property
    def pressure(self) -> float:
        """Pressure p = δ/2 / (widening + shrinking), MPa; 0 for a clearance."""
        return max(self.interference, 0.0) / 2 / (self.outer.widening + self.inner.shrinking)

    @property
    def inner_hoop(self) -> float:
        """Hoop stress at the bore of the inner ring, MPa: compression, and uniaxial."""
        return -2 * self.pressure * self.inner.outer**2 / (self.inner.outer**2 - self.inner.inner**2)

    @property
    def outer_stress(self) -> float:
        """Von Mises stress at the bore of the outer ring, MPa, from the hoop stress and the pressure."""
        hoop = self.outer.hoop
        return self.pressure * math.sqrt(hoop**2 + hoop + 1)


def judge_fit(what: str, fit: PressFit, *, key: str, given: float) -> tuple[Note, ...]:
    """Judge a study's interference, warmed. Raises `InvalidValue`: a part would yield through its wall."""
    pressure, inner, outer = fit.pressure, fit.inner, fit.outer
    # Pressures that make a whole ring yield (Tresca): from outside S_y (1 − r/R), from inside S_y ln(R/r).
    collapsing = inner.material.yield_strength * (1 - inner.inner / inner.outer)
    bursting = outer.material.yield_strength * math.log(outer.outer / outer.inner)
    for name, limit in ((what, collapsing), ("rod", bursting)):
        most = given if pressure == 0 else given + fit.interference * (limit / pressure - 1)
        rule = f"makes the {name} yield through its wall (about {pressure:.3g} MPa; it bears {limit:.3g} MPa)"
        remedy = f"Keep it below about {most:.2g} mm."
        require(pressure <= limit, key, given, rule, remedy)
    stresses = (what, -fit.inner_hoop, inner.material), ("rod", fit.outer_stress, outer.material)
    return tuple(
        doubt(
            f"its interference of {fit.interference:.3g} mm makes the {part} yield at its bore (by Lamé "
            f"{stress:.0f} MPa, yield strength {material.yield_strength:g} MPa); the model is elastic",
            what,
        )
        for part, stress, material in stresses
        if stress > material.yield_strength
    )


def judge_seat(what: str, fit: PressFit) -> tuple[Note, ...]:
    """Warn of a fit that warming has opened, or of shells with too little pressure on their backs."""
    if fit.interference <= 0:
        return (warning(f"loose in its seat, with a clearance of {-fit.interference:.2g} mm", what),)
    if what.endswith("shells") and fit.pressure < LEAST_BACK_PRESSURE:
        usual = f"{LEAST_BACK_PRESSURE:g} to 10 MPa are usual, so that they do not move"
        return (warning(f"by Lamé {fit.pressure:.2g} MPa on their backs; {usual}", what),)
    return ()


# The part that the others are fitted into; its table is [material].
ROD = "rod"


@dataclass(frozen=True)
class Expansions:
    """Thermal expansion by part, 1/K, and how much warmer than its drawing the assembly is."""

    by_part: Mapping[str, float]  #: α of the rod (cap included), and of bolt, bushing and shell
    temperature_change: float  #: K
    assumed: tuple[str, ...]  #: assumptions where the study gives no expansion, in words

    def interference(self, part: str, interference: float, diameter: float) -> float:
        """Diametral interference of a part in the rod at temperature, mm: δ + (α_i − α_o) d ΔT.

        The moduli are those at the reference temperature.
        """
        difference = self.by_part[part] - self.by_part[ROD]
        return interference + difference * diameter * self.temperature_change

    @classmethod
    def of(cls, table: AssemblyTable, materials: Mapping[str, MaterialTable]) -> "Expansions":
        """Look up expansions if [assembly] has a temperature. Raises `InvalidValue`: one is not known."""
        if table.temperature_C is None or table.temperature_C == REFERENCE_TEMPERATURE:
            return cls(dict.fromkeys(materials, 0.0), 0.0, ())
        by_part, assumed = {}, []
        for part, given in materials.items():
            name = "material" if part == ROD else f"material.{part}"
            by_part[part], metal = thermal_expansion(name, given)
            if metal is not None:
                expansion = f"{by_part[part] * 1e6:.3g}e-6/K of {metal} for the {part}"
                assumed.append(f"{expansion} ({name}.thermal_expansion_1_K)")
        return cls(by_part, table.temperature_C - REFERENCE_TEMPERATURE, tuple(assumed))

    @property
    def notes(self) -> tuple[Note, ...]:
        """Notes for the reader on the temperature."""
        if self.temperature_change == 0:
            return ()
        text = f"{self.temperature_change:+.4g} K from 20 °C change its fits and preloads, not its moduli"
        return (remark(text, "assembly"), *assumptions("assembly", self.assumed))


class FitRadii(NamedTuple):
    """Radii of a fit: bore of the inner part, seat, and outside of the rod's ring, mm."""

    bore: float
    seat: float
    outside: float


def radii_of(rod: Rod, shell: float) -> dict[str, FitRadii]:
    """Return the radii of the fits of a parametric rod, by the inner part; the shells' thickness in mm."""
    small, big = rod.small_end_bore / 2, rod.big_end_bore / 2
    return {
        BUSHING: FitRadii(small, small + rod.bushing, small + rod.small_end_ring),
        SHELL: FitRadii(big, big + shell, rod.big_end_radius),
    }


def fit_notes(
    table: AssemblyTable,
    radii: Mapping[str, FitRadii],
    materials: Mapping[str, MaterialTable],
    expansions: Expansions,
) -> tuple[Note, ...]:
    """Judge the fits of [assembly]. Raises `InvalidValue`: too large an interference."""
    interferences = {
        BUSHING: table.bushing_interference_mm,
        SHELL: None if table.shell_thickness_mm is None else table.shell_interference_mm or 0.0,
    }
    notes: list[Note] = []
    for part, given in interferences.items():
        if given is None:
            continue
        bore, seat, outside = radii[part]
        fit = PressFit(
            inner=Ring(bore, seat, materials[part].material()),
            outer=Ring(seat, outside, materials[ROD].material()),
            interference=expansions.interference(part, given, 2 * seat),
        )
        key, what = f"assembly.{part}_interference_mm", "bearing shells" if part == SHELL else part
        if expansions.temperature_change:
            change = f"interference {given:.3g} mm, at the assembly's temperature {fit.interference:.3g} mm"
            notes.append(remark(change, what))
        notes += [*judge_fit(what, fit, key=key, given=given), *judge_seat(what, fit)]
    return tuple(notes)
