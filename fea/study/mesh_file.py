"""A rod from a mesh of another program."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fea.study.paths import is_file, located
from fea.study.tables import checked, nearest
from geometry.invalid import require, require_positive

LARGEST_MESH_FILE = 2**30  # bytes; a deck of a million ten-node tetrahedra takes a sixth
# Suffixes that `mesh.reading` reads, which is loaded only where a mesh is used.
SUFFIXES = (
    ".inp",
    ".msh",
    ".bdf",
    ".nas",
    ".fem",
    ".med",
    ".vtk",
    ".vtu",
    ".xdmf",
    ".xmf",
    ".mesh",
    ".meshb",
    ".vol",
)
# Millimetres per unit of length.
UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "inch": 25.4}
_BORES = ("big_end_bore_mm", "small_end_bore_mm")
KEYS = ("mesh", "unit", *_BORES)


def is_mesh(path: Path) -> bool:
    """Whether a path has the suffix of a mesh file."""
    return path.suffix.lower() in SUFFIXES


@dataclass(frozen=True)
class MeshFile:
    """A mesh of tetrahedra from another program.

    Attributes
    ----------
    path
        The file.
    unit
        Its unit of length, a key of `UNITS`; None for millimetres, or metres where the mesh would be tiny.
    big_end_bore, small_end_bore
        Diameters that identify the bores, mm, needed if these are not the two largest parallel through-holes.
    """

    path: Path
    unit: str | None = None
    big_end_bore: float | None = None
    small_end_bore: float | None = None

    @property
    def scale(self) -> float | None:
        """Millimetres per unit of the file, where it is given."""
        return None if self.unit is None else UNITS[self.unit]

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
    rule = f"is not a mesh format that is read: {', '.join(SUFFIXES)}"
    remedy = "Write the mesh in one of these, or give a solid as rod.step."
    require(path.suffix.lower() in SUFFIXES, "rod.mesh", str(path), rule, remedy)
    require(is_file(path), "rod.mesh", str(path), "is not a file", "Name a mesh file.")
    unit = None if "unit" not in raw else checked("rod.unit", raw["unit"], str)
    if unit is not None:
        require(unit in UNITS, "rod.unit", unit, "is not a unit of length", nearest(unit, UNITS))
    bores = [
        require_positive(f"rod.{key}", checked(f"rod.{key}", raw[key], float)) if key in raw else None
        for key in _BORES
    ]
    return MeshFile(path, unit, *bores)
