"""Rods from CAD files: units, formats, roles of solids, and the report of an import."""

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from geometry.arrays import Vector
from geometry.errors import InvalidValue, require
from geometry.holes import Diameters

CAP_ASSUMED = "the cap is missing: a ring of the section at the joint is assumed, without bolts (rod.cap)"


class Role(StrEnum):
    """Role of a solid of a file."""

    ROD = "rod"
    OTHER_ROD = "another rod"
    CAP = "cap"
    ASSUMED_CAP = "assumed cap"
    BUSHING = "bushing or shell"
    PIN = "pin"
    BOLT = "bolt"
    OTHER = "other part"


@dataclass(frozen=True)
class CadSolid:
    """A solid of the file."""

    tag: int  #: gmsh's volume tag
    name: str  #: in the file, or its number
    role: Role  #: what it is
    kept: bool  #: whether it is analysed
    volume: float  #: mm³
    size: Vector  #: extents (3,) along the axes of the file, mm

    def text(self) -> str:
        """Name it, with its role."""
        return self.name if self.name == self.role else f"{self.name} ({self.role})"


@dataclass(frozen=True)
class BoreLocation:
    """A bore as it lies in the file: diameter, middle of its axis and mean width, mm."""

    diameter: float
    center: Vector
    width: float


@dataclass(frozen=True)
class ImportReport:
    """Report of an import: solids that are analysed, bores, assumptions."""

    unit: str  #: of the lengths in the file, of `geometry.imports.UNITS`
    solids: tuple[CadSolid, ...]  #: its solids, in the order of the file
    bores: tuple[BoreLocation, BoreLocation]  #: of the big and the small end
    assumed: tuple[str, ...]  #: what was assumed or left out, for the user
    #: The joint, bolts and interfaces that were found, if it is taken for an assembly
    assembly: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()  #: what may make the answer wrong: solids left out that touch the rod
    carried: str = ""  #: description of the pin holes of rods that hang on this one; empty if there are none


# Millimetres per unit of length: those that can be asked for, and those that a file may declare.
UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
DECLARED = {**UNITS, "µm": 1e-3, "dm": 100.0, "km": 1e6, "ft": 304.8}
# Distances of the bores, mm, with which the unit of a file is accepted, and to which another unit must lead:
# rods are 50 mm to 2 m long.
_ACCEPTED, _USUAL = (20.0, 4000.0), (50.0, 2000.0)
_POSSIBLE = (2.0, 20_000.0)  # of the smallest model engine and the largest ship's, with room


def is_usual(length: float) -> bool:
    """Whether a distance of the bores, mm, is that of most rods."""
    return _USUAL[0] <= length <= _USUAL[1]


def usual_units(number: float) -> Iterator[str]:
    """The units in which a distance of bores is that of a rod, the most frequent first."""
    return (unit for unit in ("mm", "m", "in", "cm") if is_usual(number * UNITS[unit]))


def plausible_unit(length: float, unit: str) -> str:
    """Unit in which the bores' distance, mm as read with `unit`, is a rod's; else `unit`."""
    if _ACCEPTED[0] <= length <= _ACCEPTED[1]:
        return unit
    return next(usual_units(length / DECLARED[unit]), unit)


def not_a_length(length: float, unit: str) -> str:
    """Reason why a distance of bores, mm as read with `unit`, is not that of a rod; empty if it may be."""
    if _POSSIBLE[0] <= length <= _POSSIBLE[1]:
        return ""
    others = " or ".join(f"{other} ({length / DECLARED[unit] * UNITS[other]:.4g} mm)"
                         for other in usual_units(length / DECLARED[unit]))  # fmt: skip
    remedy = (
        f"Give the right unit: --unit or rod.unit, as {others}" if others
        else f"No unit of --unit ({', '.join(UNITS)}) makes it one. Scale the rod in the program that drew it"
    )  # fmt: skip
    return f"in {unit} the bores are {length:.4g} mm apart, as in no rod. {remedy}"


class CadFormat(StrEnum):
    """A format of CAD files."""

    STEP = "STEP"
    IGES = "IGES"
    BREP = "Open CASCADE BREP"
    FREECAD = "FreeCAD"


# The tables of `cad_formats.toml`, and the formats that are read by their endings.
CAD_FORMATS = tomllib.loads(Path(__file__).with_name("cad_formats.toml").read_text(encoding="utf-8"))
FORMATS = {ending: kind for kind in CadFormat for ending in CAD_FORMATS["read"][kind]["endings"]}


def require_readable(name: str, path: Path) -> None:
    """Refuse a file that only a CAD program reads (`InvalidValue`); `name` is what gives it."""
    suffix = path.suffix.lower()
    rule = "is a surface of triangles in a format that is not read"
    require(
        suffix not in CAD_FORMATS["triangles"]["endings"],
        name,
        str(path),
        rule,
        "Save it as STL, or better export STEP.",
    )
    program = CAD_FORMATS["foreign"].get(suffix)
    if program is not None:
        rule = f"is in the format of {program}, which other programs do not read"
        raise InvalidValue(name, str(path), rule, f"Export STEP from {program}, and name that file.")


class MissingCap(StrEnum):
    """Treatment of a rod without its cap."""

    REFUSED = "refused"
    ASSUMED = "assumed"


@dataclass(frozen=True)
class RodFile:
    """A rod from another program: a CAD file, or a mesh of tetrahedra or of the surface."""

    path: Path  #: the file; its ending gives the format
    #: big_end_bore, small_end_bore: diameters, mm, that identify the bores where their size and place do not
    big_end_bore: float | None = None
    small_end_bore: float | None = None
    #: Of `geometry.imports.UNITS`: the unit of the lengths in the file, whatever it declares; None: the
    #: declared one (of a mesh mm), or the one with which the rod has a plausible length
    unit: str | None = None
    solids: tuple[str, ...] = ()  #: of a CAD file, names of those to keep; empty: the rod and its other parts
    #: What to do where the cap of the big end is missing, or the cap's own file
    cap: MissingCap | Path = MissingCap.REFUSED
    swap_ends: bool = False  #: whether the other bore is the big end's

    @property
    def diameters(self) -> Diameters:
        """Diameters of the bores that are given."""
        return self.big_end_bore, self.small_end_bore


def is_cad(path: Path) -> bool:
    """Whether the ending is that of a CAD file that can be read."""
    return path.suffix.lower() in FORMATS
