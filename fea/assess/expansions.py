"""Thermal expansion of an assembly's parts, and how much warmer than its drawing it is."""

from collections.abc import Mapping
from dataclasses import dataclass

from fea.study.assembly_table import AssemblyTable
from fea.study.expansion import REFERENCE_TEMPERATURE, thermal_expansion
from fea.study.material_table import MaterialTable

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
