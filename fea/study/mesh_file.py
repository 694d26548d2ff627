"""A rod from a mesh of another program."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fea.study.paths import is_file, located
from fea.study.tables import checked
from geometry.invalid import require, require_positive
from geometry.length_unit import UNITS
from mesh.files.formats import FORMATS, is_mesh

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
        Its unit of length, of `geometry.length_unit.UNITS`; None for millimetres, or the one with which the
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
    rule = f"is not a mesh format that is read: {', '.join(FORMATS)}"
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
