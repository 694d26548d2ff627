"""[rod]: a preset, dimensions, a STEP file, or mass properties alone (for the dynamics)."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fea.study.paths import is_file, located
from fea.study.tables import checked, nearest, unknown_key
from fea.units import KG, KG_M2
from geometry.dimensions import ShankSection, dimensions, options
from geometry.invalid import InvalidValue, require, require_positive
from geometry.mass import MassProperties
from geometry.presets import PRESETS
from geometry.proportions import proportioned
from geometry.rod import Rod

if TYPE_CHECKING:
    from geometry.solid import Solid

_MASS_KEYS = ("mass_kg", "center_of_gravity_mm", "inertia_kg_m2")
# Relative difference up to which given and computed mass properties count as equal.
_ALIKE = 0.01
_LEAST = ("length", "big_end_bore", "small_end_bore")


@dataclass(frozen=True)
class StepFile:
    """A solid from a CAD program.

    Attributes
    ----------
    path
        The file.
    big_end_bore, small_end_bore
        Diameters that identify the bores, mm, needed if these are not the two largest parallel through-holes.
    """

    path: Path
    big_end_bore: float | None = None
    small_end_bore: float | None = None


@dataclass(frozen=True)
class RodTable:
    """The rod of a study: dimensions, a STEP file, or its mass properties alone.

    Attributes
    ----------
    dimensions
        Of a parametric rod.
    step
        The STEP file that it comes from.
    mass
        Given mass properties, used for the dynamics of `fea loads`.
    length
        Distance of the bores' centres, mm; None for a STEP file, whose solid must be measured.
    """

    dimensions: Rod | None
    step: StepFile | None
    mass: MassProperties | None
    length: float | None

    def draw(self) -> "Solid":
        """Draw the smallest mirror cell in the open gmsh session.

        Raises
        ------
        InvalidValue
            Only mass properties are given, or the file cannot be read.
        GeometryError
            No solid could be made, or its bores cannot be identified.
        """
        if self.step is not None:
            return _imported(self.step)
        from geometry.solid import build  # noqa: PLC0415 - dynamics alone need no gmsh

        rod = self.solid()
        return build(rod, rod.smallest_cell)

    def solid(self) -> Rod:
        """Return the dimensions.

        Raises
        ------
        InvalidValue
            There are none.
        """
        if self.dimensions is None:
            if self.step is not None:
                rule = "is an imported solid: it has no dimensions to fit or to export again"
                remedy = "Use a rod given by dimensions or a preset."
                raise InvalidValue("rod.step", str(self.step.path), rule, remedy)
            remedy = "Add big_end_bore_mm and small_end_bore_mm to length_mm, or give a preset."
            rule = "gives no dimensions, so no solid can be made"
            raise InvalidValue("[rod]", "mass properties only", rule, remedy)
        return self.dimensions

    def with_dimensions(self, changes: Mapping[str, object]) -> "RodTable":
        """Return the table with some dimensions changed, by their keys.

        Raises
        ------
        InvalidValue
            There are no dimensions, or one of those given is unknown or breaks a rule.
        """
        rod = dataclasses.replace(self.solid(), **_dimensions(changes))
        return _between_bores(dataclasses.replace(self, dimensions=rod, length=rod.length))

    def mass_remarks(self, drawn: MassProperties) -> list[str]:
        """Return a remark if given mass properties differ from the solid's, whose own inertia loads it.

        Parameters
        ----------
        drawn
            Mass properties of the solid.
        """
        if self.mass is None:
            return []
        pairs = {
            "mass_kg": (self.mass.mass / KG, drawn.mass / KG),
            "center_of_gravity_mm": (self.mass.center[0], drawn.center[0]),
            "inertia_kg_m2": (self.mass.inertia_z / KG_M2, drawn.inertia_z / KG_M2),
        }
        others = [
            f"{key} = {given:.4g} (solid: {own:.4g})"
            for key, (given, own) in pairs.items()
            if not math.isclose(given, own, rel_tol=_ALIKE)
        ]
        if not others:
            return []
        text = (
            f"given mass properties are used by fea loads only, not here: {', '.join(others)}; fea rod --fit "
            "adjusts the dimensions to them"
        )
        return [text]

    def as_dict(self) -> dict[str, Any]:
        """Return the table's keys and plain values, as a study file holds them."""
        entries: dict[str, Any] = {}
        if self.step is not None:
            bores = {"big_end_bore_mm": self.step.big_end_bore, "small_end_bore_mm": self.step.small_end_bore}
            entries["step"] = str(self.step.path)
            entries |= {key: value for key, value in bores.items() if value is not None}
        elif self.dimensions is not None:
            for field in dataclasses.fields(self.dimensions):
                value = getattr(self.dimensions, field.name)
                if value or field.name not in options():
                    entries[_key(field.name)] = str(value) if isinstance(value, ShankSection) else value
        else:
            entries["length_mm"] = self.length
        if self.mass is not None:
            entries["mass_kg"] = self.mass.mass / KG
            entries["center_of_gravity_mm"] = self.mass.center[0]
            entries["inertia_kg_m2"] = self.mass.inertia_z / KG_M2
        return entries


def _imported(step: StepFile) -> "Solid":
    from geometry.imported import import_step  # noqa: PLC0415 - dynamics alone need no gmsh

    try:
        return import_step(step.path, None, step.big_end_bore, step.small_end_bore)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InvalidValue("rod.step", str(step.path), f"cannot be read ({reason})") from error


def _key(field: str) -> str:
    return f"{field}_mm" if field in dimensions() else field


def _fields() -> dict[str, str]:
    """Field of `Rod` by its key in a study."""
    return {_key(field.name): field.name for field in dataclasses.fields(Rod)}


def dimension_of(key: str) -> str:
    """Return the dimension of a key of the [rod] table.

    Raises
    ------
    InvalidValue
        The key is not a dimension.
    """
    keys = {_key(name): name for name in dimensions()}
    if key not in keys:
        raise unknown_key("[rod]", key, keys)
    return keys[key]


def read_rod(raw: object, folder: Path) -> RodTable:
    """Read the [rod] table; a relative path starts at `folder`.

    Raises
    ------
    InvalidValue
        An unknown key, a wrong type, a missing dimension, or a dimension that breaks a rule.
    """
    if not isinstance(raw, Mapping):
        raise InvalidValue("rod", raw, "must be a table, [rod]")
    others = (*_MASS_KEYS, "preset", "step")
    given = _dimensions({key: value for key, value in raw.items() if key not in others}, others)
    mass = _mass(raw)
    if "step" in raw:
        return RodTable(None, _step(raw, given, folder), mass, None)
    if "preset" in raw:
        name = checked("rod.preset", raw["preset"], str)
        if name not in PRESETS:
            raise InvalidValue("rod.preset", name, "is not a preset", nearest(name, PRESETS))
        rod = dataclasses.replace(PRESETS[name], **given)
        return _between_bores(RodTable(rod, None, mass, rod.length))
    if mass is not None and set(given) == {"length"}:
        length = require_positive("rod.length_mm", given["length"])
        return _between_bores(RodTable(None, None, mass, length))
    for name in _LEAST:
        remedy = "Give length_mm, big_end_bore_mm and small_end_bore_mm, or a preset."
        require(name in given, f"rod.{name}_mm", None, "is missing", remedy)
    rod = proportioned(**given)
    return _between_bores(RodTable(rod, None, mass, rod.length))


def _dimensions(raw: Mapping[str, object], others: Sequence[str] = ()) -> dict[str, Any]:
    """Return fields of `Rod` from their keys; `others` are keys that would be valid as well."""
    fields = _fields()
    for key in raw:
        if key not in fields:
            raise unknown_key("[rod]", key, [*fields, *others])
    return {
        fields[key]: checked(f"rod.{key}", value, ShankSection if fields[key] == "shank_section" else float)
        for key, value in raw.items()
    }


def _between_bores(table: RodTable) -> RodTable:
    """Return the table, or refuse a centre of gravity that does not lie between the bores."""
    if table.mass is not None and table.length is not None:
        rule = f"must lie between the centres of the bores, 0 to {table.length:g} mm"
        place, remedy = table.mass.center[0], "Measure it from the crank pin."
        require(0 < place < table.length, "rod.center_of_gravity_mm", place, rule, remedy)
    return table


def _step(raw: Mapping[str, object], given: Mapping[str, Any], folder: Path) -> StepFile:
    """Read the keys of a rod from a file."""
    allowed = {"big_end_bore", "small_end_bore"}
    for name in given:
        rule = "cannot be combined with step: the STEP file has its own dimensions"
        require(name in allowed, f"rod.{_key(name)}", given[name], rule, "Remove one of them.")
    rule, remedy = "cannot be combined with step", "Remove one of them."
    require("preset" not in raw, "rod.preset", raw.get("preset"), rule, remedy)
    path = located("rod.step", checked("rod.step", raw["step"], str), folder)
    require(is_file(path), "rod.step", str(path), "is not a file", "Name a STEP file.")
    bores = {
        f"rod.{_key(name)}": require_positive(f"rod.{_key(name)}", value) for name, value in given.items()
    }
    return StepFile(path, bores.get("rod.big_end_bore_mm"), bores.get("rod.small_end_bore_mm"))


def _mass(raw: Mapping[str, object]) -> MassProperties | None:
    present = [key for key in _MASS_KEYS if key in raw]
    if not present:
        return None
    for key in _MASS_KEYS:
        rule = f"is missing, but {present[0]} is given"
        require(key in raw, f"rod.{key}", None, rule, f"Give all of {', '.join(_MASS_KEYS)}, or none.")
    mass, center, inertia = (checked(f"rod.{key}", raw[key], float) for key in _MASS_KEYS)
    for key, value in (("mass_kg", mass), ("inertia_kg_m2", inertia)):
        require_positive(f"rod.{key}", value)
    moment = inertia * KG_M2
    zero = (0.0, 0.0, 0.0)
    return MassProperties(mass * KG, (center, 0.0, 0.0), (zero, zero, (0.0, 0.0, moment)))
