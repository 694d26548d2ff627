"""[rod]: a preset, dimensions, or mass properties for dynamics alone."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fea.tables import checked, mapping_text, unknown_key
from fea.units import KG, KG_M2
from geometry.invalid import InvalidValue, require, require_positive
from geometry.mass import MassProperties
from geometry.presets import PRESETS
from geometry.proportions import proportioned
from geometry.rod import Rod, ShankSection, dimensions

_MASS_KEYS = ("mass_kg", "center_of_gravity_mm", "inertia_kg_m2")
_LEAST = ("length", "big_end_bore", "small_end_bore")


@dataclass(frozen=True)
class RodTable:
    """A rod as a study gives it.

    Attributes
    ----------
    rod
        Its dimensions, or None where only mass properties are given.
    length
        Distance of the bores' centres, mm.
    mass
        Given mass properties, for the dynamics alone.
    """

    rod: Rod | None
    length: float
    mass: MassProperties | None = None

    def solid(self) -> Rod:
        """Return the dimensions.

        Raises
        ------
        InvalidValue
            Only mass properties are given.
        """
        if self.rod is None:
            remedy = "Give big_end_bore_mm and small_end_bore_mm beside length_mm, or a preset."
            rule = "has no dimensions to make a solid of"
            raise InvalidValue("[rod]", "mass properties only", rule, remedy)
        return self.rod

    def text(self) -> str:
        """Return the table as TOML text."""
        entries: dict[str, object] = {"length_mm": self.length}
        if self.rod is not None:
            for field in dataclasses.fields(self.rod):
                value = getattr(self.rod, field.name)
                entries[_key(field.name)] = str(value) if isinstance(value, ShankSection) else value
        if self.mass is not None:
            entries["mass_kg"] = self.mass.mass / KG
            entries["center_of_gravity_mm"] = self.mass.center[0]
            entries["inertia_kg_m2"] = self.mass.inertia_z / KG_M2
        return mapping_text("rod", entries)


def _key(field: str) -> str:
    return f"{field}_mm" if field in dimensions() else field


def _fields() -> dict[str, str]:
    """Field of `Rod` by its key in a study."""
    return {_key(field.name): field.name for field in dataclasses.fields(Rod)}


def read_rod(raw: object) -> RodTable:
    """Read the [rod] table.

    Raises
    ------
    InvalidValue
        An unknown key, a wrong type, a missing dimension, or a dimension that breaks a rule.
    """
    if not isinstance(raw, Mapping):
        raise InvalidValue("rod", raw, "must be a table, [rod]")
    fields = _fields()
    for key in raw:
        if key not in fields and key not in _MASS_KEYS and key != "preset":
            raise unknown_key("[rod]", key, [*fields, *_MASS_KEYS, "preset"])
    given: dict[str, Any] = {
        fields[key]: checked(f"rod.{key}", value, ShankSection if fields[key] == "shank_section" else float)
        for key, value in raw.items()
        if key in fields
    }
    mass = _mass(raw)
    if "preset" in raw:
        name = checked("rod.preset", raw["preset"], str)
        if name not in PRESETS:
            raise unknown_key("rod.preset", name, PRESETS)
        rod = dataclasses.replace(PRESETS[name], **given)
        return RodTable(rod, rod.length, mass)
    if mass is not None and set(given) == {"length"}:
        return RodTable(None, require_positive("rod.length_mm", given["length"]), mass)
    for name in _LEAST:
        remedy = "Give length_mm, big_end_bore_mm and small_end_bore_mm, or a preset."
        require(name in given, f"rod.{name}_mm", None, "is missing", remedy)
    rod = proportioned(**given)
    return RodTable(rod, rod.length, mass)


def _mass(raw: Mapping[str, object]) -> MassProperties | None:
    present = [key for key in _MASS_KEYS if key in raw]
    if not present:
        return None
    for key in _MASS_KEYS:
        remedy = "Mass properties go together."
        require(key in raw, f"rod.{key}", None, f"is missing beside {present[0]}", remedy)
    mass, center, inertia = (checked(f"rod.{key}", raw[key], float) for key in _MASS_KEYS)
    for key, value in (("mass_kg", mass), ("inertia_kg_m2", inertia)):
        require_positive(f"rod.{key}", value)
    moment = inertia * KG_M2
    zero = (0.0, 0.0, 0.0)
    return MassProperties(mass * KG, (center, 0.0, 0.0), (zero, zero, (0.0, 0.0, moment)))
