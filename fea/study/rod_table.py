"""[rod]: a preset, dimensions, a CAD file, a mesh, or mass properties alone (for the dynamics).

Rods by kind have cap screws and the proportions of `rod_kinds.toml`.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fea.base.note import Note, warning
from fea.base.shipped import TomlTable, shipped_toml
from fea.base.units import KG, KG_M2
from fea.study.assembly_table import Thread, parse_thread
from fea.study.files import absolute, is_file, located
from fea.study.tables import (
    Positive,
    StudyTable,
    Written,
    entries_of,
    full_key,
    key,
    nearest,
    one_of,
    read_keys,
    read_table,
    switch,
    unknown_key,
    with_changes,
)
from geometry.assembly import Assembly
from geometry.dimensions import ShankSection, dimensions, options
from geometry.dimensions import key as key_of
from geometry.errors import InvalidValue, require, require_positive
from geometry.imports import FORMATS, UNITS, CadFormat, MissingCap, RodFile, is_cad, require_readable
from geometry.mass import MassProperties
from geometry.outline import bosses
from geometry.presets import PRESETS
from geometry.rod import Rod, proportioned
from mesh.files.tets import FORMATS as MESH_FORMATS
from mesh.files.tets import is_mesh, require_known

if TYPE_CHECKING:
    from geometry.solid import Solid

LARGEST_MESH_FILE = 2**30  # bytes; a deck of a million ten-node tetrahedra takes a sixth


# Relative difference up to which given and computed mass properties count as equal.
_ALIKE = 0.01
# Enough to draw a rod; crankshaft, piston and cylinder block decide them.
LEAST = ("length_mm", "big_end_bore_mm", "small_end_bore_mm")
_BORES = LEAST[1:]
MASS_KEYS = ("mass_kg", "center_of_gravity_mm", "inertia_kg_m2")
# Keys that name a file, and those that say how to read it.
_FILES = ("step", "cad", "mesh")
_FILE_OPTIONS = ("unit", "solids", "cap", "swap_ends")
_FIELDS = {key_of(field.name): field.name for field in dataclasses.fields(Rod)}  # of a rod, by their keys


@dataclass(frozen=True)
class _Sources(StudyTable, table="rod"):
    preset: str | None = key(
        '"leon-2001"',
        "a published rod; other keys override its dimensions",
        above="Other ways to define the rod:",
    )
    cad: str | None = key(
        '"rod.step"', "STEP, IGES, BREP or FreeCAD; `fea rod FILE` lists its solids and bores"
    )
    step: str | None = key('"rod.step"', "the same, for a STEP file")
    solids: tuple[str, ...] | None = key(
        '["Rod", "Cap"]',
        "which solids to keep; big_end_bore_mm and small_end_bore_mm name the bores",
        flag="solids",
        help="Name of a solid of a CAD file to keep; repeat it for more.",
        kind=list[str],
        parse=tuple,
    )
    unit: str | None = key(
        '"in"',
        "of the lengths in the file: mm, cm, m or in; default: as declared, if plausible",
        one_of(UNITS),
        flag="unit",
    )
    cap: str | None = key(
        '"assumed"',
        "a ring in place of a missing cap, or the file of the cap; default: refused",
        flag="cap",
        parse=lambda given: given if given in list(MissingCap) else absolute("--cap", given),
    )
    swap_ends: bool = switch(
        "take the other bore of the file for the big end's, where both are alike", "swap_ends"
    )
    mesh: str | None = key(
        '"rod.inp"',
        "tetrahedra, solved as they are: .inp, .msh, .unv, .bdf, .med, .mesh, .vol, .vtk, .vtu, .xdmf; .stl",
    )
    mass_kg: Positive | None = key(
        "0.8",
        "mass properties: with length_mm alone they are enough for `fea loads`; with dimensions they are the "
        "targets of `fea rod --fit`",
    )
    center_of_gravity_mm: float | None = key("64.0", "from the crank pin")
    inertia_kg_m2: Positive | None = key(
        "0.0038", "about the pin-parallel axis through the centre of gravity"
    )


def _declared() -> list[tuple[str, Any, Any]]:
    """Name, type and declaration of the key of each dimension; examples are those of a usual rod."""
    least = {"length": 141.0, "big_end_bore": 50.0, "small_end_bore": 22.0}
    usual = proportioned(**least)
    keys = []
    for field in dataclasses.fields(Rod):
        value, about = getattr(usual, field.name), field.metadata
        shown = f'"{value}"' if isinstance(value, str) else str(float(f"{value:.3g}"))
        declared = key(
            about.get("example", shown),
            about["help"],
            above=about.get("above", ""),
            stated=field.name in least,
            flag=field.name if key_of(field.name) in _BORES else "",
            help=f"Diameter of the bore of a file's {field.name[:-5].replace('_', ' ')}, mm.",
        )
        keys.append((key_of(field.name), type(value) | None, declared))
    return keys


# [rod]: the dimensions of `geometry.dimensions`, and other ways to define a rod.
RodKeys: Any = dataclasses.make_dataclass("RodKeys", _declared(), bases=(_Sources,), frozen=True)


@dataclass(frozen=True)
class RodTable:
    """The rod of a study: dimensions, a CAD file, a mesh, or its mass properties alone."""

    dimensions: Rod | None  #: of a parametric rod
    file: RodFile | None  #: the file of a solid or a mesh that is read
    mass: MassProperties | None  #: given mass properties, used for the dynamics of `fea loads`
    #: Distance of the bores' centres, mm; None for a CAD file or a mesh, which must be measured
    length: float | None
    written: frozenset[str] = frozenset()  #: keys whose values had a unit beside them

    def with_file_keys(self, changes: Mapping[str, Any]) -> "RodTable":
        """Return the table with keys for reading its file. Raises `InvalidValue`: no file, or broken rule."""
        flag, value = next(iter(changes.items()))
        rule = "says how a CAD file or a mesh is read, but the rod of this study is given by dimensions"
        name = f"--{flag.removesuffix('_mm').replace('_', '-')}"
        require(self.from_file, name, value, rule, "Leave it out, or name a file.")
        return read_rod({**self.as_dict(), **changes}, Path.cwd())

    @property
    def mesh(self) -> RodFile | None:
        """The mesh that it comes from."""
        return None if self.file is None or not is_mesh(self.file.path) else self.file

    @property
    def cad(self) -> RodFile | None:
        """The CAD file that it comes from."""
        return None if self.mesh is not None else self.file

    @property
    def from_file(self) -> bool:
        """Whether a solid or a mesh is read from a file."""
        return self.file is not None

    @property
    def file_key(self) -> str:
        """The key that names the file: step, cad or mesh."""
        if self.cad is None:
            return "mesh"
        kind = FORMATS.get(self.cad.path.suffix.lower(), CadFormat.STEP)
        return "step" if kind is CadFormat.STEP else "cad"

    def draw(
        self, tell: Callable[[str], None] = lambda _stage: None, assembly: Assembly | None = None
    ) -> "Solid":
        """Draw the smallest symmetry cell in the open gmsh session; `tell` is called with long stages.

        Raises `InvalidValue`: only mass properties, an unreadable file, or parts that do not go together;
        `GeometryError`: no solid could be made, or its bores cannot be identified.
        """
        if self.cad is not None:
            from geometry.cad.imported import import_cad  # noqa: PLC0415 - dynamics alone need no gmsh

            try:
                return import_cad(self.cad, tell=tell, assembly=assembly)
            except OSError as error:
                rule = f"cannot be read ({error.strerror or error})"
                raise InvalidValue(f"rod.{self.file_key}", str(self.cad.path), rule) from error
        from geometry.solid import build  # noqa: PLC0415 - likewise

        return build(self.solid(), assembly=assembly)

    def solid(self) -> Rod:
        """Return the dimensions; raises `InvalidValue`: there are none."""
        if self.dimensions is not None:
            return self.dimensions
        if self.file is not None:
            what = "an imported solid" if self.cad else "a mesh"
            rule = f"is {what}: it has no dimensions to fit or to export"
            remedy = "Use a rod given by dimensions or a preset."
            raise InvalidValue(f"rod.{self.file_key}", str(self.file.path), rule, remedy)
        remedy = "Add big_end_bore_mm and small_end_bore_mm to length_mm, or give a preset."
        rule = "gives no dimensions, so no solid can be made"
        raise InvalidValue("[rod]", "mass properties only", rule, remedy)

    def with_dimensions(self, changes: Mapping[str, object]) -> "RodTable":
        """Return the table with dimensions changed by key. `InvalidValue`: unknown, or a broken rule."""
        for name in changes:
            if full_key(name, _FIELDS) not in _FIELDS:
                raise unknown_key("[rod]", name, _FIELDS)
        given = read_keys(RodKeys, "rod", changes)
        rod = dataclasses.replace(self.solid(), **_dimensions(given))
        written = (self.written - given.keys()) | _written(given)
        return _between_bores(RodTable(rod, None, self.mass, rod.length, written))

    def with_keys(self, changes: object, folder: Path) -> "RodTable":
        """Return the table with keys changed, None taking one away; a preset or a file is another rod.

        Raises `InvalidValue`: see `read_rod`.
        """
        if not isinstance(changes, Mapping):
            return read_rod(changes, folder)
        kept = {} if {"preset", *_FILES} & changes.keys() else self.as_dict()
        return read_rod(with_changes(RodKeys, "rod", kept, changes), folder)

    def mass_notes(self, drawn: MassProperties) -> list[Note]:
        """Return a note if given mass properties differ from the solid's, whose own inertia loads it."""
        if self.mass is None:
            return []
        meshed = _mass_figures(drawn)
        unlike = ", ".join(
            f"{name} = {given:.4g} (solid: {meshed[name]:.4g})"
            for name, given in _mass_figures(self.mass).items()
            if not math.isclose(given, meshed[name], rel_tol=_ALIKE)
        )
        text = f"given mass properties are used by fea loads only, not here: {unlike}"
        return [warning(f"{text}; fea rod --fit adjusts the dimensions to them")] if unlike else []

    def as_dict(self) -> TomlTable:
        """Return the table's keys and plain values, as a study file holds them."""
        file, entries = self.file, TomlTable()
        if file is not None:
            entries = {self.file_key: str(file.path)}
            given = {key_of(name): value for name, value in vars(file).items() if name != "path" and value}
            given["cap"] = None if file.cap is MissingCap.REFUSED else str(file.cap)
            entries |= {name: value for name, value in given.items() if value}
        elif self.dimensions is not None:
            given = vars(self.dimensions)
            entries = {key_of(name): given[name] for name in given if given[name] or name not in options()}
        else:
            entries = {"length_mm": self.length}
        if self.mass is not None:
            entries |= _mass_figures(self.mass)
        return {name: Written(value) if name in self.written else value for name, value in entries.items()}


def _mass_figures(mass: MassProperties) -> dict[str, float]:
    figures = (mass.mass / KG, mass.center[0], mass.inertia_z / KG_M2)
    return dict(zip(MASS_KEYS, figures, strict=True))


def sufficient() -> list[list[str]]:
    """Return sets of keys, each of which is enough to define a rod."""
    return [*([name] for name in _FILES), ["preset"], ["length_mm", *MASS_KEYS], list(LEAST)]


def dimension_of(key: str) -> str:
    """Return the dimension of a key of the [rod] table; raises `InvalidValue`: the key is not a dimension."""
    keys = {name: field for name, field in _FIELDS.items() if field in dimensions()}
    if key not in keys:
        raise unknown_key("[rod]", key, keys)
    return keys[key]


def read_rod(raw: object, folder: Path) -> RodTable:
    """Read [rod]; paths start at `folder`. Raises `InvalidValue`: a wrong key, type or dimension."""
    given = entries_of(read_table(RodKeys, "rod", raw))
    return dataclasses.replace(_table(given, folder), written=_written(given))


def _written(given: Mapping[str, Any]) -> frozenset[str]:
    return frozenset(name for name, value in given.items() if isinstance(value, Written))


def _table(given: Mapping[str, Any], folder: Path) -> RodTable:
    mass = _mass(given)
    for name in ("mesh", *_FILES):
        if name in given:
            return _from_file(name, given, mass, folder)
    for name in _FILE_OPTIONS:
        rule = "has no effect without a file of the rod"
        remedy, value = "Remove it, or name a file: step or cad.", given.get(name)
        require(not value, f"rod.{name}", value, rule, remedy)
    sizes = _dimensions(given)
    if "preset" in given:
        preset = given["preset"]
        if preset not in PRESETS:
            raise InvalidValue("rod.preset", preset, "is not a preset", nearest(preset, PRESETS))
        rod = dataclasses.replace(PRESETS[preset], **sizes)
    elif mass is not None and set(sizes) == {"length"}:
        return _between_bores(RodTable(None, None, mass, require_positive("rod.length_mm", sizes["length"])))
    else:
        for name in LEAST:
            remedy = "Give length_mm, big_end_bore_mm and small_end_bore_mm, or a preset."
            require(name in given, f"rod.{name}", None, "is missing", remedy)
        rod = proportioned(**sizes)
    return _between_bores(RodTable(rod, None, mass, rod.length))


def rod_of_file(path: Path) -> RodTable:
    """Return the rod of a CAD or mesh file about which nothing else is said."""
    return RodTable(None, RodFile(path), None, None)


def _dimensions(given: Mapping[str, Any]) -> dict[str, Any]:
    return {_FIELDS[name]: value for name, value in given.items() if name in _FIELDS}


def _between_bores(table: RodTable) -> RodTable:
    if table.mass is not None and table.length is not None:
        rule = f"must lie between the centres of the bores, 0 to {table.length:g} mm"
        place, remedy = table.mass.center[0], "Measure it from the crank pin."
        require(0 < place < table.length, "rod.center_of_gravity_mm", place, rule, remedy)
    return table


def _from_file(key: str, given: Mapping[str, Any], mass: MassProperties | None, folder: Path) -> RodTable:
    mesh = key == "mesh"
    allowed = {key, *_BORES, *MASS_KEYS, *_FILE_OPTIONS} - ({"solids"} if mesh else set())
    for name, value in given.items():
        why = f": the {'mesh' if mesh else 'file'} has its own dimensions"
        rule = f"cannot be combined with {key}" + ("" if not mesh and name in ("preset", *_FILES) else why)
        require(name in allowed, f"rod.{name}", value, rule, "Remove one of them.")
    path, name = located(f"rod.{key}", given[key], folder), f"rod.{key}"
    require_readable(name, path)
    require_known(name, path)
    rule = f"is not a mesh format that is read: {', '.join(MESH_FORMATS)}"
    remedy = "Write the mesh in one of these, or give a solid as rod.step."
    require(not mesh or is_mesh(path), name, str(path), rule, remedy)
    require(is_file(path), name, str(path), "is not a file", f"Name a {'mesh' if mesh else 'CAD'} file.")
    rule = f"is not a CAD file that can be read ({', '.join(FORMATS)})"
    readable = mesh or is_cad(path) or (key == "step" and not is_mesh(path))
    require(readable, name, path.name, rule, "Export the rod as STEP.")
    big, small = (require_positive(f"rod.{name}", given[name]) if name in given else None for name in _BORES)
    cap = _cap(given.get("cap", MissingCap.REFUSED), folder, is_mesh if mesh else is_cad)
    solids, swap = given.get("solids", ()), given.get("swap_ends", False)
    file = RodFile(path, big, small, given.get("unit"), solids, cap, swap)
    return RodTable(None, file, mass, None)


def _cap(given: str, folder: Path, readable: Callable[[Path], bool]) -> MissingCap | Path:
    if given in list(MissingCap):
        return MissingCap(given)
    path = located("rod.cap", given, folder)
    remedy = 'Give "assumed", or the file of the cap in the same kind of format as that of the rod.'
    require(is_file(path) and readable(path), "rod.cap", given, "is not a file that can be read", remedy)
    return path


def _mass(given: Mapping[str, Any]) -> MassProperties | None:
    present = [name for name in MASS_KEYS if name in given]
    if not present:
        return None
    for name in MASS_KEYS:
        rule = f"is missing, but {present[0]} is given"
        require(name in given, f"rod.{name}", None, rule, f"Give all of {', '.join(MASS_KEYS)}, or none.")
    zero = (0.0, 0.0, 0.0)
    moment = given["inertia_kg_m2"] * KG_M2
    center = (given["center_of_gravity_mm"], 0.0, 0.0)
    return MassProperties(given["mass_kg"] * KG, center, (zero, zero, (0.0, 0.0, moment)))


_KINDS = shipped_toml("study/rod_kinds.toml")
KINDS = tuple(_KINDS)
# Of rod bolts; a fine thread each.
_THREADS = ("1/4-28 UNF", "5/16-24 UNF", "3/8-24 UNF", "7/16-20 UNF", "1/2-20 UNF")
# Radius of the seat of a head over the bolt's diameter: flanges of 12-point bolts are about 1.55 d wide.
_HEAD = 0.8
_OF_BORES = ("big_end_bore", "small_end_bore")


@dataclass(frozen=True)
class RodOfKind:
    """A rod in the proportions of its kind."""

    rod: Rod
    thread: Thread  #: of its cap screws
    #: title, material, grade: of the kind, and in a study those of the rod and of its bolts
    title: str
    material: str
    grade: str


def rod_of_kind(
    kind: str, length: float, big_end_bore: float, small_end_bore: float, thread: str | None = None
) -> RodOfKind:
    """Return a rod of a kind, by the distance and the diameters of its bores, mm.

    Its cap screws are of the given `thread`, or of one that suits the big end. Raises `InvalidValue`: there
    is no such kind, or a dimension breaks a rule.
    """
    one_of(_KINDS)("--kind", kind)
    proportions = _KINDS[kind]
    threads = [parse_thread("--thread", name) for name in ((thread,) if thread else _THREADS)]
    screw = min(threads, key=lambda thread: abs(thread.diameter - proportions["bolt"] * big_end_bore))
    bores = dict(zip(_OF_BORES, (big_end_bore, small_end_bore), strict=True))
    given = {
        name: round(share * bores[bore], 2) for bore in _OF_BORES for name, share in proportions[bore].items()
    }
    section = ShankSection(proportions["shank_section"])
    given |= {"cap_bolt": screw.diameter}
    rod = proportioned(length, *bores.values(), shank_section=section, **given)
    boss = bosses(rod)
    if boss is not None:  # the head's seat begins where the fillet ends
        given["cap_bolt_spacing"] = round(2 * (boss.seat + _HEAD * screw.diameter), 2)
        rod = proportioned(length, *bores.values(), shank_section=section, **given)
    return RodOfKind(rod, screw, proportions["title"], proportions["material"], proportions["grade"])
