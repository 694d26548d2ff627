"""The fields of a result that a picture can show: their arrays, names and worst values."""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geometry.arrays import Floats
from geometry.invalid import require

MODE, VON_MISES = "mode_", "von_mises"
# The colour scale of a safety factor ends at this many times its smallest value.
_CAP = 4.0


@dataclass(frozen=True)
class Field:
    """A scalar at the nodes.

    Attributes
    ----------
    name
        Name of its array, which may contain vectors whose length is shown.
    label
        Its label in the legend.
    unit
        The unit after a value.
    low
        Whether the smallest value is the worst.
    signed
        Whether negative values are meaningful.
    """

    name: str
    label: str
    unit: str = ""
    low: bool = False
    signed: bool = False

    @property
    def capped(self) -> bool:
        """Whether the colour scale is capped: for a safety factor, which has no natural upper end."""
        return self.low and not self.signed

    def said(self, value: float) -> str:
        """Return its worst value as text."""
        if self.name.startswith(MODE):
            return "largest displacement"
        return f"{'min' if self.low else 'max'} {value:.4g}{self.unit}"

    def values(self, data: Mapping[str, Floats]) -> Floats:
        """Return its values (n_nodes,) from the arrays of a result."""
        found = data[self.name]
        if found.ndim > 1:
            return np.asarray(np.linalg.norm(found, axis=1))
        # A negative safety factor stands for an unknown one.
        return np.where(found < 0, np.inf, found) if self.capped else found

    def worst(self, values: Floats) -> int:
        """Return the node of the worst of values (n_nodes,)."""
        return int(values.argmin() if self.low else values.argmax())

    def top(self, worst: float) -> float:
        """Return the upper end of its colour scale."""
        return _CAP * worst if self.capped else worst


_FIELDS = (
    Field(VON_MISES, "von Mises stress, MPa", " MPa"),
    Field("principal_1", "largest principal stress, MPa", " MPa", signed=True),
    Field("principal_3", "least principal stress, MPa", " MPa", low=True, signed=True),
    Field("mean", "mean of signed von Mises stress, MPa", " MPa", signed=True),
    Field("amplitude", "amplitude of signed von Mises stress, MPa", " MPa"),
    Field("safety_factor", "safety factor against yield", low=True),
    Field("fatigue_safety_factor", "safety factor against fatigue", low=True),
    Field("crossland_safety_factor", "safety factor by Crossland", low=True),
    Field("endurance_limit", "endurance limit, MPa", " MPa", low=True),
    Field("contact_pressure", "contact pressure, MPa", " MPa"),
    Field("displacement", "displacement, mm", " mm"),
)


def point_arrays(vtu: Path) -> list[str]:
    """Return the names of the nodal arrays of a .vtu file, without reading the arrays.

    Raises
    ------
    InvalidValue
        The file is incomplete.
    """
    content = vtu.read_bytes()
    rule = "is not a complete .vtu file, which must end with </VTKFile>"
    remedy = "Name a .vtu file written by fea."
    require(content.rstrip().endswith(b"</VTKFile>"), "FILE", vtu.name, rule, remedy)
    head = content.partition(b"<AppendedData")[0].partition(b"<CellData")[0]
    return [name.decode(errors="replace") for name in re.findall(rb'Name="([^"]+)"', head)]


def available(arrays: Collection[str]) -> list[str]:
    """Return the names of the fields that a result with these arrays can show, the default first."""
    modes = sorted(
        (name for name in arrays if re.fullmatch(MODE + "[0-9]+", name)), key=lambda name: (len(name), name)
    )
    return [field.name for field in _FIELDS if field.name in arrays] + modes


def field_of(name: str) -> Field:
    """Return a field by its name."""
    if name.startswith(MODE):
        return Field(name, "mode shape, displacement (largest = 1)")
    return next(field for field in _FIELDS if field.name == name)


def chosen_field(name: str | None, arrays: Collection[str], file: str) -> str:
    """Return the requested field, or the first that a file has.

    Raises
    ------
    InvalidValue
        The file has no field, or not the requested one.
    """
    names = available(arrays)
    rule = "is not a result of fea: it has no stress, safety factor or mode shape"
    require(bool(names), "FILE", file, rule, "Name a .vtu file written by fea.")
    if name is not None:
        require(name in names, "--field", name, f"must be one of {', '.join(names)} for {file}")
    return name or names[0]
