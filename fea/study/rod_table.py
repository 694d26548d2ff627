"""[rod]: a preset, dimensions, a CAD file, a mesh, or mass properties alone (for the dynamics)."""

import dataclasses
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fea.study.paths import is_file, located
from fea.study.tables import checked, nearest, unknown_key
from fea.units import KG, KG_M2
from geometry.assembly import Assembly
from geometry.dimensions import ShankSection, dimensions, options
from geometry.errors import InvalidValue, require, require_positive
from geometry.imports import FORMATS, UNITS, CadFile, CadFormat, MissingCap, is_cad
from geometry.mass import MassProperties
from geometry.presets import PRESETS
from geometry.rod import Rod, proportioned
from mesh.files.tets import FORMATS as MESH_FORMATS
from mesh.files.tets import is_mesh

if TYPE_CHECKING:
    from geometry.solid import Solid

LARGEST_MESH_FILE = 2**30  # bytes; a deck of a million ten-node tetrahedra takes a sixth
_BORES = ("big_end_bore_mm", "small_end_bore_mm")
KEYS = ("mesh", "unit", *_BORES)


@dataclass(frozen=True)
class MeshFile:
    """A mesh of tetrahedra from another program.

    Attributes
    ----------
    path
        The file.
    unit
        Its unit of length, of `geometry.imports.UNITS`; None for millimetres, or the one with which the
        rod has a usual length.
    big_end_bore, small_end_bore
        Diameters that identify the bores, mm, needed if these are not the two largest parallel through-holes.
    """

    path: Path
    unit: str | None = None
    big_end_bore: float | None = None
    small_end_bore: float | None = None

    @property
    def named(self) -> tuple[float | None, float | None]:
        """Diameters of the bores, mm, where they are given."""
        return self.big_end_bore, self.small_end_bore

    def as_dict(self) -> dict[str, Any]:
        """Return its keys and values, as a study file holds them."""
        values = (str(self.path), self.unit, *self.named)
        return {key: value for key, value in zip(KEYS, values, strict=True) if value is not None}


def read_mesh_file(raw: Mapping[str, object], folder: Path) -> MeshFile:
    """Read the keys of [rod] that describe a mesh; a relative path starts at `folder`.

    Raises
    ------
    InvalidValue
        The file does not exist or has another format, or a key does not go with it.
    """
    others = ("mass_kg", "center_of_gravity_mm", "inertia_kg_m2")
    for key, value in raw.items():
        rule = "cannot be combined with mesh: the mesh has its own dimensions"
        require(key in (*KEYS, *others), f"rod.{key}", value, rule, "Remove one of them.")
    path = located("rod.mesh", checked("rod.mesh", raw["mesh"], str), folder)
    rule = f"is not a mesh format that is read: {', '.join(MESH_FORMATS)}"
    remedy = "Write the mesh in one of these, or give a solid as rod.step."
    require(is_mesh(path), "rod.mesh", str(path), rule, remedy)
    require(is_file(path), "rod.mesh", str(path), "is not a file", "Name a mesh file.")
    unit = None if "unit" not in raw else checked("rod.unit", raw["unit"], str)
    require(unit is None or unit in UNITS, "rod.unit", unit, f"must be one of {', '.join(UNITS)}")
    bores = [
        require_positive(f"rod.{key}", checked(f"rod.{key}", raw[key], float)) if key in raw else None
        for key in _BORES
    ]
    return MeshFile(path, unit, *bores)


_MASS_KEYS = ("mass_kg", "center_of_gravity_mm", "inertia_kg_m2")
# Relative difference up to which given and computed mass properties count as equal.
_ALIKE = 0.01
_LEAST = ("length", "big_end_bore", "small_end_bore")
# Keys that name a file, and those that say how to read it.
_FILES = ("step", "cad")
_FILE_OPTIONS: Mapping[str, Any] = {"unit": str, "solids": tuple[str, ...], "cap": MissingCap}
# All keys that are not dimensions, with their types.
_OTHERS: Mapping[str, Any] = {
    **dict.fromkeys(_MASS_KEYS, float),
    "preset": str,
    **dict.fromkeys((*_FILES, "mesh"), str),
    **_FILE_OPTIONS,
}


@dataclass(frozen=True)
class RodTable:
    """The rod of a study: dimensions, a CAD file, a mesh, or its mass properties alone.

    Attributes
    ----------
    dimensions
        Of a parametric rod.
    cad
        The CAD file that it comes from.
    mass
        Given mass properties, used for the dynamics of `fea loads`.
    length
        Distance of the bores' centres, mm; None for a CAD file or a mesh, which must be measured.
    mesh
        The mesh that it comes from.
    """

    dimensions: Rod | None
    cad: CadFile | None
    mass: MassProperties | None
    length: float | None
    mesh: MeshFile | None = None

    @property
    def from_file(self) -> bool:
        """Whether a solid or a mesh is read from a file."""
        return self.cad is not None or self.mesh is not None

    def draw(
        self, tell: Callable[[str], None] = lambda _stage: None, assembly: Assembly | None = None
    ) -> "Solid":
        """Draw the smallest mirror cell in the open gmsh session.

        Parameters
        ----------
        tell
            Told what is being done, where that takes long.
        assembly
            What is separate in it; None for a rod in one piece.

        Raises
        ------
        InvalidValue
            Only mass properties are given, the file cannot be read, or the parts do not go together.
        GeometryError
            No solid could be made, or its bores cannot be identified.
        """
        if self.cad is not None:
            return _imported(self.cad, tell, assembly)
        from geometry.solid import build  # noqa: PLC0415 - dynamics alone need no gmsh

        rod = self.solid()
        cell = rod.smallest_cell if assembly is None else assembly.smallest_cell(rod)
        return build(rod, cell, assembly)

    def solid(self) -> Rod:
        """Return the dimensions.

        Raises
        ------
        InvalidValue
            There are none.
        """
        if self.dimensions is None:
            if self.cad is not None:
                rule = "is an imported solid: it has no dimensions to fit or to export again"
                remedy = "Use a rod given by dimensions or a preset."
                raise InvalidValue(f"rod.{_key_of(self.cad)}", str(self.cad.path), rule, remedy)
            if self.mesh is not None:
                rule = "is a mesh: it has no dimensions to fit or to export as a solid"
                remedy = "Use a rod given by dimensions or a preset."
                raise InvalidValue("rod.mesh", str(self.mesh.path), rule, remedy)
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
        if self.cad is not None:
            entries |= _cad_entries(self.cad)
        elif self.mesh is not None:
            entries |= self.mesh.as_dict()
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


def _imported(cad: CadFile, tell: Callable[[str], None], assembly: Assembly | None) -> "Solid":
    from geometry.cad.imported import import_cad  # noqa: PLC0415 - dynamics alone need no gmsh

    try:
        return import_cad(cad, tell=tell, assembly=assembly)
    except OSError as error:
        reason = error.strerror or str(error)
        rule = f"cannot be read ({reason})"
        raise InvalidValue(f"rod.{_key_of(cad)}", str(cad.path), rule) from error


def _key_of(cad: CadFile) -> str:
    """The key that names the file."""
    return "step" if FORMATS.get(cad.path.suffix.lower(), CadFormat.STEP) is CadFormat.STEP else "cad"


def _cad_entries(cad: CadFile) -> dict[str, Any]:
    given: dict[str, Any] = {
        "big_end_bore_mm": cad.big_end_bore,
        "small_end_bore_mm": cad.small_end_bore,
        "unit": cad.unit,
        "solids": list(cad.solids) or None,
        "cap": None if cad.cap is MissingCap.REFUSED else str(cad.cap),
    }
    present = {key: value for key, value in given.items() if value is not None}
    return {_key_of(cad): str(cad.path), **present}


def _key(field: str) -> str:
    return f"{field}_mm" if field in dimensions() else field


@cache
def _fields() -> Mapping[str, str]:
    """Field of `Rod` by its key in a study."""
    return {_key(field.name): field.name for field in dataclasses.fields(Rod)}


def rod_keys() -> dict[str, Any]:
    """Return the keys of the [rod] table with their types."""
    lengths = {key: float if name in dimensions() else ShankSection for key, name in _fields().items()}
    return lengths | dict(_OTHERS)


def sufficient() -> list[list[str]]:
    """Return sets of keys, each of which is enough to define a rod."""
    return [
        *([key] for key in (*_FILES, "mesh")),
        ["preset"],
        ["length_mm", *_MASS_KEYS],
        [f"{name}_mm" for name in _LEAST],
    ]


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
    if "mesh" in raw:
        return RodTable(None, None, _mass(raw), None, read_mesh_file(raw, folder))
    given = _dimensions({key: value for key, value in raw.items() if key not in _OTHERS}, list(_OTHERS))
    mass = _mass(raw)
    for key in _FILES:
        if key in raw:
            return RodTable(None, _cad(key, raw, given, folder), mass, None)
    for key in _FILE_OPTIONS:
        rule = "has no effect without a CAD file"
        require(key not in raw, f"rod.{key}", raw.get(key), rule, "Remove it, or name a file: step or cad.")
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


def rod_of_file(path: Path) -> RodTable:
    """Return the rod of a CAD or mesh file about which nothing else is said."""
    if is_mesh(path):
        return RodTable(None, None, None, None, MeshFile(path))
    return RodTable(None, CadFile(path), None, None)


def _dimensions(raw: Mapping[str, object], others: Sequence[str] = ()) -> dict[str, Any]:
    """Return fields of `Rod` from their keys; `others` are keys that would be valid as well."""
    fields = _fields()
    for key in raw:
        if key not in fields:
            raise unknown_key("[rod]", key, [*fields, *others])
    hints = rod_keys()
    return {fields[key]: checked(f"rod.{key}", value, hints[key]) for key, value in raw.items()}


def _between_bores(table: RodTable) -> RodTable:
    """Return the table, or refuse a centre of gravity that does not lie between the bores."""
    if table.mass is not None and table.length is not None:
        rule = f"must lie between the centres of the bores, 0 to {table.length:g} mm"
        place, remedy = table.mass.center[0], "Measure it from the crank pin."
        require(0 < place < table.length, "rod.center_of_gravity_mm", place, rule, remedy)
    return table


def _cad(key: str, raw: Mapping[str, object], given: Mapping[str, Any], folder: Path) -> CadFile:
    """Read the keys of a rod from a file."""
    allowed = {"big_end_bore", "small_end_bore"}
    for name in given:
        rule = f"cannot be combined with {key}: the file has its own dimensions"
        require(name in allowed, f"rod.{_key(name)}", given[name], rule, "Remove one of them.")
    for other in ("preset", *(file for file in _FILES if file != key)):
        rule = f"cannot be combined with {key}"
        require(other not in raw, f"rod.{other}", raw.get(other), rule, "Remove one of them.")
    path = located(f"rod.{key}", checked(f"rod.{key}", raw[key], str), folder)
    require(is_file(path), f"rod.{key}", str(path), "is not a file", "Name a CAD file.")
    rule = f"is not a CAD file that can be read ({', '.join(FORMATS)})"
    require(key == "step" or is_cad(path), f"rod.{key}", path.name, rule, "Export the rod as STEP.")
    bores = {name: require_positive(f"rod.{_key(name)}", value) for name, value in given.items()}
    return CadFile(
        path,
        bores.get("big_end_bore"),
        bores.get("small_end_bore"),
        unit=_one_of("unit", raw.get("unit"), UNITS),
        solids=_names(raw.get("solids", [])),
        cap=MissingCap(_one_of("cap", raw.get("cap"), MissingCap) or MissingCap.REFUSED),
    )


def _one_of(key: str, value: object, valid: Iterable[str]) -> str | None:
    """Return a value that must be one of some, or None if it is not given."""
    if value is None:
        return None
    names = [str(name) for name in valid]
    require(value in names, f"rod.{key}", value, f"must be one of {', '.join(names)}")
    return str(value)


def _names(value: object) -> tuple[str, ...]:
    """Return the names of solids."""
    rule = 'must be a list of names, such as ["rod", "cap"]'
    valid = isinstance(value, list) and all(isinstance(name, str) for name in value)
    require(valid, "rod.solids", value, rule, "fea rod FILE lists the solids of a file.")
    return tuple(value)  # type: ignore[arg-type]


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
