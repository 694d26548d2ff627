"""What was made of a CAD file: which of its solids are analysed, where the bores are, what was assumed."""

from dataclasses import dataclass
from enum import StrEnum

Vector = tuple[float, float, float]


class Role(StrEnum):
    """What a solid of a file is."""

    ROD = "rod"
    OTHER_ROD = "another rod"
    CAP = "cap"
    ASSUMED_CAP = "assumed cap"
    BUSHING = "bushing or shell"
    PIN = "pin"
    BOLT = "bolt"
    OTHER = "other part"


@dataclass(frozen=True)
class Member:
    """A solid of the file.

    Attributes
    ----------
    tag
        gmsh's volume tag.
    name
        In the file, or its number.
    role
        What it is.
    kept
        Whether it is analysed.
    volume
        mm³.
    size
        Extents (3,) along the axes of the file, mm.
    """

    tag: int
    name: str
    role: Role
    kept: bool
    volume: float
    size: Vector


@dataclass(frozen=True)
class FoundBore:
    """A bore as it lies in the file: diameter, middle of its axis and mean width, mm."""

    diameter: float
    center: Vector
    width: float


@dataclass(frozen=True)
class Intake:
    """What was made of a file.

    Attributes
    ----------
    unit
        Of the lengths in the file, of `geometry.length_unit.UNITS`.
    members
        Its solids, in the order of the file.
    bores
        Of the big and the small end.
    assumed
        What was assumed or left out, for the user.
    assembly
        The joint, bolts and interfaces that were found, if it is taken for an assembly.
    """

    unit: str
    members: tuple[Member, ...]
    bores: tuple[FoundBore, FoundBore]
    assumed: tuple[str, ...]
    assembly: tuple[str, ...] = ()
