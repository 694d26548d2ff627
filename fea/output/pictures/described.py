"""What a picture of a result says, in the words of the summary beside it."""

from dataclasses import dataclass, replace
from pathlib import Path

from fea.analysis.figures import Summary
from fea.output.json_file import read_summary
from fea.output.pictures.shown import MODE, VON_MISES


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A picture to be drawn.

    Attributes
    ----------
    vtu, png
        The result file to show and the picture to write.
    title
        What is shown, at which speed and crank angle.
    peak
        The worst value that counts; None for the worst in the file.
    at
        Where it is, (x, y, z) in mm; None for where the file's largest is.
    notes
        More lines beside the legend.
    mesh_only
        Show the rod and its elements; there are no results.
    field
        The array that the colours show.
    error_percent
        Error bar of the peak, where there is one.
    marks
        Names and places, mm, of sharp edges.
    """

    vtu: Path
    png: Path
    title: str
    peak: float | None = None
    at: tuple[float, float, float] | None = None
    notes: tuple[str, ...] = ()
    mesh_only: bool = False
    field: str = VON_MISES
    error_percent: float | None = None
    marks: tuple[tuple[str, tuple[float, float, float]], ...] = ()


def described(vtu: Path, png: Path, field: str = VON_MISES) -> Picture:
    """Return the picture of a result file in the words of the summary beside it, if there is one."""
    try:
        return replace(described_by(read_summary(vtu.parent), vtu, field), png=png)
    except (OSError, ValueError, LookupError):
        title = f"{vtu.stem}: mode {_number(field)}" if field.startswith(MODE) else vtu.stem
        return Picture(vtu=vtu, png=png, title=title, field=field)


def described_by(summary: Summary, vtu: Path, field: str | None = None) -> Picture:
    """Return the picture of a result of a run: a load case, the envelope or a buckling mode.

    Raises
    ------
    LookupError
        The summary says nothing of this result.
    """
    kinds = {"envelope": _envelope, "buckling": _buckling}
    return kinds.get(vtu.stem, _case)(summary, vtu, field)


def _case(summary: Summary, vtu: Path, field: str | None) -> Picture:
    result = summary.results[vtu.stem]
    angle = summary.loads[vtu.stem].crank_deg
    stress = field in {None, VON_MISES}
    heading = [vtu.stem, _speed(summary), f"crank angle {angle:.1f}°" if angle is not None else ""]
    note = f"smallest safety factor against yielding {result.min_safety_factor:.3g}"
    picture = _picture(summary, vtu, heading, note=note, field=field or VON_MISES)
    if not stress:
        return picture
    edges = result.sharp_edges or ()
    marks = tuple((edge.name, edge.at_mm) for edge in edges)
    said = tuple(
        f"sharp edge {edge.name}: structural stress {edge.structural_von_mises_MPa:.4g} MPa"
        for edge in edges[:1]
    )
    picture = replace(picture, marks=marks, notes=(*picture.notes, *said))
    return replace(
        picture, peak=result.max_von_mises_MPa, at=result.at_mm, error_percent=result.error_percent
    )


def _envelope(summary: Summary, vtu: Path, field: str | None) -> Picture:
    found = summary.envelope
    if found is None:
        raise LookupError("envelope")
    fatigue = found.min_fatigue_safety_factor
    factors = f"yielding {found.min_safety_factor:.3g}"
    factors += f", fatigue {fatigue:.3g}" if fatigue is not None else ""
    note, heading = f"smallest safety factors: {factors}", ["whole crank cycle", _speed(summary)]
    return _picture(summary, vtu, heading, note=note, field=field or VON_MISES)


def _buckling(summary: Summary, vtu: Path, field: str | None) -> Picture:
    field = field or f"{MODE}1"
    found = summary.buckling
    if found.modes is None or found.shapes_of is None:
        raise LookupError("buckling")
    mode = found.modes[found.shapes_of][_number(field) - 1]
    heading = [
        f"buckling under {found.shapes_of}",
        f"mode {_number(field)} at {mode.factor:.4g} times the load",
        _speed(summary),
    ]
    return _picture(summary, vtu, heading, note=f"moves {mode.moves}", field=field)


def _picture(summary: Summary, vtu: Path, heading: list[str], *, note: str, field: str) -> Picture:
    title = f"{summary.study}: " + ", ".join(part for part in heading if part)
    notes = (note,) if summary.trusted else (note, "NOT TO BE TRUSTED: a check failed")
    return Picture(vtu=vtu, png=vtu.with_suffix(".png"), title=title, notes=notes, field=field)


def _speed(summary: Summary) -> str:
    return f"{summary.rpm:g} rpm" if summary.rpm else ""


def _number(field: str) -> int:
    return int(field.removeprefix(MODE))
