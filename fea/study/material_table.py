"""[material] of a study file."""

import dataclasses
from dataclasses import dataclass

from fea.choices import Finish
from fea.material import Material
from fea.study.endurance import estimated_endurance, finish_factor, reliability_factor, size_factor
from fea.study.material_presets import MATERIALS
from fea.study.tables import nearest
from fea.units import GPA, KG_M3
from geometry.invalid import InvalidValue, require, require_positive


@dataclass(frozen=True)
class MaterialTable:
    """[material]: a preset's name, or the constants; constants override those of a preset.

    `endurance_MPa` is the fully reversed limit of polished specimens in tension, `endurance_torsion_MPa`
    in torsion. `surface`, `size_mm` (of a round section in bending) and `reliability_percent` convert both
    into limits of the part.
    """

    preset: str | None = None
    E_GPa: float | None = None
    nu: float | None = None
    density_kg_m3: float | None = None
    yield_MPa: float | None = None
    ultimate_MPa: float | None = None
    endurance_MPa: float | None = None
    endurance_torsion_MPa: float | None = None
    surface: Finish | None = None
    size_mm: float | None = None
    reliability_percent: float | None = None

    def resolved(self) -> "MaterialTable":
        """Return the table with the preset's constants filled in."""
        base = {}
        if self.preset is not None:
            if self.preset not in MATERIALS:
                remedy = nearest(self.preset, MATERIALS)
                raise InvalidValue("material.preset", self.preset, "is not a preset", remedy)
            base = MATERIALS[self.preset]
        own = {key: value for key, value in dataclasses.asdict(self).items() if value is not None}
        own.pop("preset", None)
        return MaterialTable(**base | own)

    def material(self) -> Material:
        """Return the material in coherent units."""
        table = self.resolved()
        (modulus, nu), factor = table.stiffness(), table.part_factor()
        endurance, torsion = table.endurance_MPa, table.endurance_torsion_MPa
        if endurance is not None:
            require_positive("material.endurance_MPa", endurance)
        estimated = endurance is None and table.ultimate_MPa is not None
        if endurance is None and table.ultimate_MPa is not None:
            endurance = estimated_endurance(table.ultimate_MPa, modulus)
        return Material(
            youngs_modulus=modulus,
            poissons_ratio=nu,
            density=_needed(table, "density_kg_m3") * KG_M3,
            yield_strength=_needed(table, "yield_MPa"),
            ultimate_strength=table.ultimate_MPa,
            endurance_limit=None if endurance is None else factor * endurance,
            torsion_limit=None if torsion is None else factor * torsion,
            endurance_estimated=estimated and endurance is not None,
        )

    def stiffness(self) -> tuple[float, float]:
        """Return Young's modulus, MPa, and Poisson's ratio."""
        table = self.resolved()
        modulus = require_positive("material.E_GPa", _needed(table, "E_GPa"))
        nu = _needed(table, "nu")
        require(-1 < nu < 0.5, "material.nu", nu, "must be above −1 and below 0.5")
        return modulus * GPA, nu

    def part_factor(self) -> float:
        """Return Marin's factor k_a k_b k_e, from a polished specimen to the part.

        Raises
        ------
        InvalidValue
            A value is out of its range, or the surface is named but not the ultimate strength.
        """
        factor = 1.0
        if self.surface is not None:
            missing = "material.ultimate_MPa"
            rule = "is missing: the surface factor depends on it"
            require(self.ultimate_MPa is not None, missing, None, rule, "Give it, or leave surface out.")
            factor *= finish_factor(self.surface, require_positive(missing, self.ultimate_MPa))
        if self.size_mm is not None:
            factor *= size_factor(self.size_mm)
        if self.reliability_percent is not None:
            factor *= reliability_factor(self.reliability_percent)
        return factor


def _needed(table: MaterialTable, key: str) -> float:
    value = getattr(table, key)
    require(value is not None, f"material.{key}", None, "is missing", "Give it or a preset in [material].")
    return float(value)
