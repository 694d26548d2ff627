"""What a picture can show of a result: its colours' array, how its worst place is found, how it is called."""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geometry.arrays import Floats
from geometry.invalid import require

MODE, VON_MISES = "mode_", "von_mises"
# A safety factor is drawn up to so many times its smallest value.
_CAP = 4.0


@dataclass(frozen=True)
class Field:
    """A scalar at the nodes.

    Attributes
    ----------
    name
        Of its array, or of that of vectors whose length it is.
    label
        What the legend calls it.
    unit
        Behind a value.
    low
        Whether the smallest value is the worst.
    signed
        Whether values below zero mean something.
    """

    name: str
    label: str
    unit: str = ""
    low: bool = False
    signed: bool = False

    @property
    def capped(self) -> bool:
        """Whether colours end where it is far from bad: it is a safety factor, which has no upper end."""
        return self.low and not self.signed

    def said(self, value: float) -> str:
        """Return its worst value in words."""
        if self.name.startswith(MODE):
            return "moves most"
        return f"{'min' if self.low else 'max'} {value:.4g}{self.unit}"

    def values(self, data: Mapping[str, Floats]) -> Floats:
        """Return it (n_nodes,) from a result's arrays."""
        found = data[self.name]
        if found.ndim > 1:
            return np.asarray(np.linalg.norm(found, axis=1))
        # A safety factor below zero says that there is none.
        return np.where(found < 0, np.inf, found) if self.capped else found

    def worst(self, values: Floats) -> int:
        """Return the node of the worst of values (n_nodes,)."""
        return int(values.argmin() if self.low else values.argmax())

    def top(self, worst: float) -> float:
        """Return the value at which its colours end."""
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
    Field("displacement", "displacement, mm", " mm"),
)


def point_arrays(vtu: Path) -> list[str]:
    """Return the names of the arrays at the nodes that a .vtu file speaks of, without reading those.

    Raises
    ------
    InvalidValue
        The file is not whole.
    """
    content = vtu.read_bytes()
    rule = "is no whole .vtu file: it must end with </VTKFile>"
    require(content.rstrip().endswith(b"</VTKFile>"), "FILE", vtu.name, rule, "Name one that fea wrote.")
    head = content.partition(b"<AppendedData")[0].partition(b"<CellData")[0]
    return [name.decode(errors="replace") for name in re.findall(rb'Name="([^"]+)"', head)]


def available(arrays: Collection[str]) -> list[str]:
    """Return the names of what can be shown of a result with these arrays; what is shown unasked first."""
    modes = sorted(
        (name for name in arrays if re.fullmatch(MODE + "[0-9]+", name)), key=lambda name: (len(name), name)
    )
    return [field.name for field in _FIELDS if field.name in arrays] + modes


def field_of(name: str) -> Field:
    """Return a field by its name."""
    if name.startswith(MODE):
        return Field(name, "displacement of the mode, largest = 1")
    return next(field for field in _FIELDS if field.name == name)


def chosen_field(name: str | None, arrays: Collection[str], file: str) -> str:
    """Return the name asked for, or the first that a file has.

    Raises
    ------
    InvalidValue
        It has none, or not that.
    """
    names = available(arrays)
    rule = "must be the result of a run: it lacks stress, safety factors and mode shapes"
    require(bool(names), "FILE", file, rule, "Name a .vtu file that fea wrote.")
    if name is not None:
        require(name in names, "--field", name, f"must be one of {', '.join(names)} for {file}")
    return name or names[0]
