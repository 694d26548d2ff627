"""The fields of a result that a picture can show: their arrays, names and worst values."""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from dataclasses import field as field_of_dataclass
from pathlib import Path

import numpy as np

from fea.analysis.summary_figures import Summary
from fea.base.choices import UnitSystem
from fea.output.json_file import read_summary
from fea.output.pictures.scale import Bands
from fea.output.units import heading, quantity, scale, system, unit
from fea.output.vtu import point_name
from geometry.arrays import Floats
from geometry.errors import require

MODE, VON_MISES = "mode_", "von_mises"
# The colour scale of a safety factor ends at this many times its smallest value.
_CAP = 4.0


@dataclass(frozen=True)
class Field:
    """A scalar at the nodes, by the name of its array, of whose vectors the length is shown."""

    name: str
    words: str  #: in the legend
    own_unit: str = ""  #: of the array
    #: low, signed: whether the smallest value is the worst, and whether negative values are meaningful
    low: bool = False
    signed: bool = False

    @property
    def label(self) -> str:
        """Its words with the unit that is shown."""
        return heading(self.words, self.own_unit)

    @property
    def scale(self) -> float:
        """The factor from the unit of the array to that which is shown."""
        return scale(self.own_unit)

    @property
    def capped(self) -> bool:
        """Whether the colour scale is capped, as that of a safety factor, which has no natural upper end."""
        return self.low and not self.signed

    def extreme(self, value: float) -> str:
        """Return its worst value, in the unit that is shown, as text."""
        if self.name.startswith(MODE):
            return "largest displacement"
        return f"{'min' if self.low else 'max'} {value:.4g} {unit(self.own_unit)}".rstrip()

    def values(self, data: Mapping[str, Floats]) -> Floats:
        """Return its values (n_nodes,) in the unit of its legend, from the arrays of a result."""
        array = self.scale * np.asarray(data[self.name])
        if array.ndim > 1:
            return np.asarray(np.linalg.norm(array, axis=1))
        # A negative safety factor stands for an unknown one.
        return np.where(array < 0, np.inf, array) if self.capped else array

    def worst(self, values: Floats) -> int:
        """Return the node of the worst of values (n_nodes,)."""
        return int(values.argmin() if self.low else values.argmax())

    def top(self, worst: float) -> float:
        """Return the upper end of its colour scale."""
        return _CAP * worst if self.capped else worst

    def bands(self, values: Floats, worst: float) -> Bands:
        """Return the colours of values (n,), the worst of which ends the scale where they have one sign."""
        if self.signed:
            return Bands.around_zero(float(values.min()), float(values.max()))
        return Bands.up_to(self.top(worst), low=self.low)


_FIELDS = (
    Field("plastic_strain_percent", "equivalent plastic strain", "%"),
    Field(VON_MISES, "von Mises stress", "MPa"),
    Field("principal_1", "largest principal stress", "MPa", signed=True),
    Field("principal_3", "least principal stress", "MPa", low=True, signed=True),
    Field("mean", "mean of signed von Mises stress", "MPa", signed=True),
    Field("amplitude", "amplitude of signed von Mises stress", "MPa"),
    Field("safety_factor_node", "safety factor against yield", low=True),
    Field("fatigue_safety_factor", "safety factor against fatigue", low=True),
    Field("crossland_safety_factor", "safety factor by Crossland", low=True),
    Field("endurance_limit", "endurance limit", "MPa", low=True),
    Field("largest_defect_um", "largest defect that does not grow, √area", "µm", low=True),
    Field("contact_pressure", "contact pressure", "MPa"),
    Field("displacement", "displacement", "mm"),
)


def point_arrays(vtu: Path) -> list[str]:
    """Return the names of nodal arrays of a .vtu file, unread. Raises `InvalidValue`: it is incomplete."""
    content = vtu.read_bytes()
    rule = "is not a complete .vtu file, which must end with </VTKFile>"
    remedy = "Name a .vtu file written by fea."
    require(content.rstrip().endswith(b"</VTKFile>"), "FILE", vtu.name, rule, remedy)
    head = content.partition(b"<AppendedData")[0].partition(b"<CellData")[0]
    return [point_name(name.decode(errors="replace")) for name in re.findall(rb'Name="([^"]+)"', head)]


def available(arrays: Collection[str]) -> list[str]:
    """Return the names of the fields that a result with these arrays can show, the default first."""
    modes = [name for name in arrays if re.fullmatch(MODE + "[0-9]+", name)]
    modes.sort(key=lambda name: (len(name), name))
    return [field.name for field in _FIELDS if field.name in arrays] + modes


def field_of(name: str) -> Field:
    """Return a field by its name."""
    if name.startswith(MODE):
        return Field(name, "mode shape, displacement (largest = 1)")
    return next(field for field in _FIELDS if field.name == name)


def chosen_field(name: str | None, arrays: Collection[str], file: str) -> str:
    """Return the field asked for, or the file's first. Raises `InvalidValue`: it does not have it."""
    names = available(arrays)
    rule = "has no stress, safety factor or mode shape"
    remedy = "Name the .vtu file of a load case, an envelope or mode shapes, written by fea."
    require(bool(names), "FILE", file, rule, remedy)
    if name is not None:
        name = point_name(name)
        require(name in names, "--field", name, f"must be one of {', '.join(names)} for {file}")
    return name or names[0]


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A picture to be drawn: of a result file `vtu`, into `png`."""

    vtu: Path
    png: Path
    title: str
    #: peak, at: the worst value that counts and its place, mm; None for the largest in the file
    peak: float | None = None
    at: tuple[float, float, float] | None = None
    #: origin of the rod with the worst value, mm, from which its place is measured
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    notes: tuple[str, ...] = ()  #: more lines beside the legend
    mesh_only: bool = False  #: show the rod and its elements; there are no results
    field: str = VON_MISES  #: the array that the colours show
    error_percent: float | None = None  #: error bar of the peak
    marks: tuple[tuple[str, tuple[float, float, float]], ...] = ()  #: names and places, mm, of sharp edges
    units: UnitSystem = field_of_dataclass(default_factory=system)  #: that are shown


def described(vtu: Path, png: Path, field: str = VON_MISES) -> Picture:
    """Return the picture of a result file in the words of the summary beside it, if there is one."""
    try:
        return replace(described_by(read_summary(vtu.parent), vtu, field), png=png)
    except (OSError, ValueError, LookupError):
        title = f"{vtu.stem}: mode {_number(field)}" if field.startswith(MODE) else vtu.stem
        return Picture(vtu=vtu, png=png, title=title, field=field)


def described_by(summary: Summary, vtu: Path, field: str | None = None) -> Picture:
    """Return the picture of a case, envelope or buckling mode. Raises `LookupError`: not in the summary."""
    kinds = {"envelope": _envelope, "buckling": _buckling, "plastic": _left, "overload": _left}
    return kinds.get(vtu.stem, _case)(summary, vtu, field)


def _case(summary: Summary, vtu: Path, field: str | None) -> Picture:
    result = summary.results[vtu.stem]
    angle = summary.loads[vtu.stem].crank_deg
    heading = [vtu.stem, _speed(summary), f"crank angle {angle:.1f}°" if angle is not None else ""]
    note = f"smallest safety factor against yielding {result.min_safety_factor:.3g}"
    picture = _picture(summary, vtu, heading, note=note, field=field or VON_MISES)
    if field not in {None, VON_MISES}:
        return picture
    edges, notes = result.sharp_edges or (), list(picture.notes)
    if edges:
        stress = quantity(edges[0].structural_von_mises_MPa, ".4g", "MPa")
        notes.append(f"sharp edge {edges[0].name}: structural stress {stress}")
    return replace(
        picture,
        marks=tuple((edge.name, edge.at_mm) for edge in edges),
        notes=tuple(notes),
        peak=result.max_von_mises_MPa,
        at=result.at_mm,
        error_percent=result.error_percent,
    )


def _envelope(summary: Summary, vtu: Path, field: str | None) -> Picture:
    envelope = summary.envelope
    if envelope is None:
        raise LookupError("envelope")
    fatigue = envelope.min_fatigue_safety_factor
    factors = f"yielding {envelope.min_safety_factor:.3g}"
    factors += f", fatigue {fatigue:.3g}" if fatigue is not None else ""
    note, heading = f"smallest safety factors: {factors}", ["whole crank cycle", _speed(summary)]
    tired = summary.survival.mode == "fatigue" and fatigue is not None
    usual = "fatigue_safety_factor" if tired else VON_MISES
    return _picture(summary, vtu, heading, note=note, field=field or usual)


def _buckling(summary: Summary, vtu: Path, field: str | None) -> Picture:
    field = field or f"{MODE}1"
    buckling = summary.buckling
    if buckling.modes is None or buckling.shapes_of is None:
        raise LookupError("buckling")
    mode = buckling.modes[buckling.shapes_of][_number(field) - 1]
    which = f"mode {_number(field)} at {mode.factor:.4g} times the load"
    heading = [f"buckling under {buckling.shapes_of}", which, _speed(summary)]
    return _picture(summary, vtu, heading, note=f"moves {mode.moves}", field=field)


def _left(summary: Summary, vtu: Path, field: str | None) -> Picture:
    found = summary.plastic if vtu.stem == "plastic" else summary.overload
    if found is None:
        raise LookupError(vtu.stem)
    after = "running" if vtu.stem == "plastic" else "the overload"
    after = "95 % of the force at which the shank bends" if found.state == "bends" else after
    note = f"largest plastic strain at a Gauss point {100 * found.max_plastic_strain:.2g} %"
    heading = [f"without load, after {after}", _speed(summary)]
    return _picture(summary, vtu, heading, note=note, field=field or "plastic_strain_percent")


def _picture(summary: Summary, vtu: Path, heading: list[str], *, note: str, field: str) -> Picture:
    title = f"{summary.study}: " + ", ".join(part for part in heading if part)
    notes = (note,) if summary.trusted else (note, "NOT TO BE TRUSTED: a check failed")
    return Picture(vtu=vtu, png=vtu.with_suffix(".png"), title=title, notes=notes, field=field)


def _speed(summary: Summary) -> str:
    return f"{summary.rpm:g} rpm" if summary.rpm else ""


def _number(field: str) -> int:
    return int(field.removeprefix(MODE))
