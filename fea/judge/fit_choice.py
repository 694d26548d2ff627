"""The press fits of a study's assembly, at its temperature, judged before anything is solved."""

from collections.abc import Mapping
from dataclasses import dataclass

from fea.judge.press_fit import PressFit, judge_fit, judge_seat, ring_of, warmed
from fea.study.assembly_table import BUSHING, SHELL, AssemblyTable
from fea.study.material_table import REFERENCE_TEMPERATURE, MaterialTable, thermal_expansion
from geometry.rod import Rod

# The part that the others are fitted into; its table is [material].
ROD = "rod"


@dataclass(frozen=True)
class Expansions:
    """Thermal expansion by part, 1/K, and how much warmer than its drawing the assembly is.

    Attributes
    ----------
    by_part
        α of the rod (cap included), and of bolt, bushing and shell.
    warming
        K.
    assumed
        What the study does not say, in words.
    """

    by_part: Mapping[str, float]
    warming: float
    assumed: tuple[str, ...]

    @classmethod
    def of(cls, table: AssemblyTable, materials: Mapping[str, MaterialTable]) -> "Expansions":
        """Look up the expansion of every material, where the temperature makes it count.

        Parameters
        ----------
        table
            [assembly].
        materials
            Tables by part.

        Raises
        ------
        InvalidValue
            The expansion of a material is neither given nor known.
        """
        if table.temperature_C is None or table.temperature_C == REFERENCE_TEMPERATURE:
            return cls(dict.fromkeys(materials, 0.0), 0.0, ())
        by_part, assumed = {}, []
        for part, own in materials.items():
            name = "material" if part == ROD else f"material.{part}"
            by_part[part], metal = thermal_expansion(name, own)
            if metal is not None:
                said = f"{by_part[part] * 1e6:.3g}e-6/K of {metal} for the {part}"
                assumed.append(f"{said} ({name}.thermal_expansion_1_K)")
        return cls(by_part, table.temperature_C - REFERENCE_TEMPERATURE, tuple(assumed))

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a reader must know of the temperature."""
        if self.warming == 0:
            return ()
        said = f"assembly: {self.warming:+.4g} K from 20 °C change its fits and preloads, not its moduli"
        assumed = (f"assembly: assumed are {', '.join(self.assumed)}",) if self.assumed else ()
        return (said, *assumed)


@dataclass(frozen=True)
class FitRadii:
    """Radii of a fit: bore of the inner part, seat, and outside of the rod's ring, mm."""

    bore: float
    seat: float
    outside: float


@dataclass(frozen=True)
class ChosenFit:
    """A press fit, and what a reader must know of it.

    Attributes
    ----------
    fit
        By Lamé, at the assembly's temperature.
    given
        Diametral interference as the study says, at the reference temperature, mm.
    remarks
        In words.
    """

    fit: PressFit
    given: float
    remarks: tuple[str, ...]

    @property
    def interference(self) -> float:
        """Diametral interference at the assembly's temperature, mm; negative for a clearance."""
        return self.fit.interference


def radii_of(rod: Rod, shell: float) -> dict[str, FitRadii]:
    """Return the radii of the fits of a parametric rod, by the inner part; the shells' thickness in mm."""
    small, big = rod.small_end_bore / 2, rod.big_end_bore / 2
    return {
        BUSHING: FitRadii(small, small + rod.bushing, small + rod.small_end_ring),
        SHELL: FitRadii(big, big + shell, rod.big_end_radius),
    }


def choose_fits(
    table: AssemblyTable,
    radii: Mapping[str, FitRadii],
    materials: Mapping[str, MaterialTable],
    expansions: Expansions,
) -> dict[str, ChosenFit]:
    """Return the fits that a study asks for, by the inner part.

    Parameters
    ----------
    table
        [assembly].
    radii
        By the inner part.
    materials
        Tables of the rod and of the inner parts.
    expansions
        Of the same.

    Raises
    ------
    InvalidValue
        An interference is more than a part bears.
    """
    wanted = {
        BUSHING: table.bushing_interference_mm,
        SHELL: None if table.shell_thickness_mm is None else table.shell_interference_mm or 0.0,
    }
    return {
        part: _chosen(part, given, radii[part], materials, expansions)
        for part, given in wanted.items()
        if given is not None
    }


def _chosen(
    part: str,
    given: float,
    radii: FitRadii,
    materials: Mapping[str, MaterialTable],
    expansions: Expansions,
) -> ChosenFit:
    inner, outer = materials[part].material(), materials[ROD].material()
    alpha = expansions.by_part
    fit = PressFit(
        inner=ring_of(radii.bore, radii.seat, inner),
        outer=ring_of(radii.seat, radii.outside, outer),
        interference=warmed(given, 2 * radii.seat, alpha[part], alpha[ROD], expansions.warming),
    )
    key, what = f"assembly.{part}_interference_mm", "bearing shells" if part == SHELL else part
    said = (*judge_fit(what, fit, inner, outer, key=key, given=given), *judge_seat(what, fit))
    if expansions.warming:
        change = (
            f"{what}: interference {given:.3g} mm, at the assembly's temperature {fit.interference:.3g} mm"
        )
        said = (change, *said)
    return ChosenFit(fit, given, said)
