"""What a study says of a CAD file, and the formats that can be read; needs no CAD kernel."""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path


class CadFormat(StrEnum):
    """A format of CAD files."""

    STEP = "STEP"
    IGES = "IGES"
    BREP = "Open CASCADE BREP"
    FREECAD = "FreeCAD"


FORMATS = {
    ".step": CadFormat.STEP,
    ".stp": CadFormat.STEP,
    ".igs": CadFormat.IGES,
    ".iges": CadFormat.IGES,
    ".brep": CadFormat.BREP,
    ".brp": CadFormat.BREP,
    ".fcstd": CadFormat.FREECAD,
}


class MissingCap(StrEnum):
    """What to do about a rod without its cap."""

    REFUSED = "refused"
    ASSUMED = "assumed"


@dataclass(frozen=True)
class CadFile:
    """A rod from a CAD program.

    Attributes
    ----------
    path
        The file; its ending tells the format.
    big_end_bore, small_end_bore
        Diameters, mm, that identify the bores where their size and place do not.
    unit
        Of `geometry.intake.UNITS`: the unit of the lengths in the file, whatever it declares; None: the
        declared one, or the one with which the rod has a plausible length.
    solids
        Names of the solids to keep; empty: the rod and what belongs to it.
    cap
        What to do where the cap of the big end is missing.
    """

    path: Path
    big_end_bore: float | None = None
    small_end_bore: float | None = None
    unit: str | None = None
    solids: tuple[str, ...] = ()
    cap: MissingCap = MissingCap.REFUSED


def is_cad(path: Path) -> bool:
    """Whether the ending is that of a CAD file that can be read."""
    return path.suffix.lower() in FORMATS
