"""[material] of a study file."""

import dataclasses
from dataclasses import dataclass
from typing import Any

from fea.choices import Finish, Loading
from fea.material import Basquin, Marin, Material, Skin
from fea.study.endurance import (
    estimated_endurance,
    finish_factor,
    is_steel,
    load_factor,
    reliability_factor,
    size_factor,
)
from fea.study.material_presets import MATERIALS
from fea.study.sn_line import SN_KEYS, sn_line
from fea.study.tables import nearest
from fea.units import GPA, KG_M3
from geometry.invalid import InvalidValue, require, require_positive

# Finishes of forgings and rolled bars, of which the bores and the faces beside them are machined.
_RAW = (Finish.HOT_ROLLED, Finish.AS_FORGED, Finish.SHOT_PEENED)
# Larger gains than this are known of surface treatments of sharply notched parts only.
_LARGEST_FACTOR = 2.0


@dataclass(frozen=True)
class MaterialTable:
    """[material]: a preset's name, or the constants; constants override those of a preset.

    `endurance_MPa` is the fully reversed limit of polished specimens in tension, `endurance_torsion_MPa`
    in torsion. `size_mm` (of a round section in bending), `loading` and `reliability_percent` convert them
    into limits of the part, and so does the finish of its surface, or its factor as a number: `bore_surface`
    on the bores, `face_surface` on the faces beside them, `surface` on the rest. `thermal_expansion_1_K`
    counts in an assembly at another temperature. The S–N line of polished specimens, for the life over a
    [duty], is given by `fatigue_strength_coefficient_MPa` (σ_f′) and `fatigue_strength_exponent` (b), or by
    tests: `sn_cycles` and `sn_amplitude_MPa`.
    """

    preset: str | None = None
    E_GPa: float | None = None
    nu: float | None = None
    density_kg_m3: float | None = None
    yield_MPa: float | None = None
    ultimate_MPa: float | None = None
    endurance_MPa: float | None = None
    endurance_torsion_MPa: float | None = None
    surface: Finish | float | None = None
    bore_surface: Finish | float | None = None
    face_surface: Finish | float | None = None
    size_mm: float | None = None
    loading: Loading | None = None
    reliability_percent: float | None = None
    thermal_expansion_1_K: float | None = None
    fatigue_strength_coefficient_MPa: float | None = None
    fatigue_strength_exponent: float | None = None
    sn_cycles: tuple[float, ...] | None = None
    sn_amplitude_MPa: tuple[float, ...] | None = None

    def resolved(self) -> "MaterialTable":
        """Return the table with the preset's constants filled in."""
        base: dict[str, Any] = {}
        if self.preset is not None:
            if self.preset not in MATERIALS:
                remedy = nearest(self.preset, MATERIALS)
                raise InvalidValue("material.preset", self.preset, "is not a preset", remedy)
            base = dict(MATERIALS[self.preset])
        own = {key: value for key, value in dataclasses.asdict(self).items() if value is not None}
        own.pop("preset", None)
        if own.keys() & set(SN_KEYS):  # one way to give the line replaces another
            base = {key: value for key, value in base.items() if key not in SN_KEYS}
        return MaterialTable(**base | own)

    def material(self) -> Material:
        """Return the material in coherent units."""
        table = self.resolved()
        (modulus, nu), marin = table.stiffness(), table.marin()
        endurance, torsion = table.endurance_MPa, table.endurance_torsion_MPa
        if endurance is not None:
            require_positive("material.endurance_MPa", endurance)
        estimated = endurance is None and table.ultimate_MPa is not None
        if endurance is None and table.ultimate_MPa is not None:
            endurance = estimated_endurance(table.ultimate_MPa, modulus)
        factor = marin.size * marin.reliability
        return Material(
            youngs_modulus=modulus,
            poissons_ratio=nu,
            density=_needed(table, "density_kg_m3") * KG_M3,
            yield_strength=_needed(table, "yield_MPa"),
            ultimate_strength=table.ultimate_MPa,
            endurance_limit=None if endurance is None else marin.load * factor * endurance,
            torsion_limit=None if torsion is None else factor * torsion,
            endurance_estimated=estimated and endurance is not None,
            marin=marin,
            basquin=table.basquin(),
        )

    def basquin(self) -> Basquin | None:
        """Return the S–N line; None where the table gives none.

        Raises
        ------
        InvalidValue
            It is given in part or in two ways, or is no line that falls with the number of cycles.
        """
        return sn_line(*(getattr(self, key) for key in SN_KEYS))

    def stiffness(self) -> tuple[float, float]:
        """Return Young's modulus, MPa, and Poisson's ratio."""
        table = self.resolved()
        modulus = require_positive("material.E_GPa", _needed(table, "E_GPa"))
        nu = _needed(table, "nu")
        require(-1 < nu < 0.5, "material.nu", nu, "must be above −1 and below 0.5")
        return modulus * GPA, nu

    def marin(self) -> Marin:
        """Return Marin's factors, from a polished specimen to the part.

        The bores, and the faces beside them, are machined where the rest of the part is left as it was forged
        or rolled, unless their finish is given.

        Raises
        ------
        InvalidValue
            A value is out of its range, a finish is named but not the ultimate strength, or the metal is none
            that a finish was tested on.
        """
        machined = Finish.MACHINED if self.surface in _RAW else self.surface
        rest, percent = self._surface("surface", None), self.reliability_percent
        return Marin(
            size=1.0 if self.size_mm is None else size_factor(self.size_mm),
            load=1.0 if self.loading is None else load_factor(self.loading),
            reliability=1.0 if percent is None else reliability_factor(percent),
            bores=self._surface("bore_surface", machined),
            faces=self._surface("face_surface", machined),
            rest=rest,
        )

    def _surface(self, key: str, otherwise: Finish | float | None) -> Skin:
        """How a region was made: as its key says, or otherwise as the rest of the part suggests."""
        given = getattr(self, key)
        made = otherwise if given is None else given
        if made is None:
            return Skin()
        name, assumed = f"material.{key}", given is None and made != self.surface
        if not isinstance(made, Finish):
            rule = f"must be above 0 and at most {_LARGEST_FACTOR:g}, the factor of the surface, or a finish"
            require(0 < made <= _LARGEST_FACTOR, name, made, rule)
            return Skin(made, "given", assumed)
        missing, rule = "material.ultimate_MPa", f"is missing: the factor of {key} depends on it"
        require(self.ultimate_MPa is not None, missing, None, rule, f"Give it, or leave {key} out.")
        ultimate = require_positive(missing, self.ultimate_MPa)
        if made is Finish.SHOT_PEENED:
            rule, remedy = "is known of steel only", "Give the factor as a number instead."
            require(is_steel(self.stiffness()[0]), name, made, rule, remedy)
        return Skin(finish_factor(made, ultimate), made.value, assumed)


def _needed(table: MaterialTable, key: str) -> float:
    value = getattr(table, key)
    require(value is not None, f"material.{key}", None, "is missing", "Give it or a preset in [material].")
    return float(value)
