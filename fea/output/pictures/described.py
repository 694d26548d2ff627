"""What a picture of a result says, in the words of the summary beside it."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from fea.output.pictures.shown import MODE, VON_MISES


@dataclass(frozen=True)
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


def described(vtu: Path, png: Path, field: str = VON_MISES) -> Picture:
    """Return the picture of a result file in the words of the summary beside it, if there is one."""
    try:
        summary = json.loads((vtu.parent / "summary.json").read_text(encoding="utf-8"))
        return replace(described_by(summary, vtu, field), png=png)
    except (OSError, ValueError, KeyError, TypeError, IndexError):
        title = f"{vtu.stem}: mode {_number(field)}" if field.startswith(MODE) else vtu.stem
        return Picture(vtu, png, title, field=field)


def described_by(summary: Mapping[str, Any], vtu: Path, field: str | None = None) -> Picture:
    """Return the picture of a result of a run: a load case, the envelope or a mode of buckling."""
    kinds = {"envelope": _envelope, "buckling": _buckling}
    return kinds.get(vtu.stem, _case)(summary, vtu, field)


def _case(summary: Mapping[str, Any], vtu: Path, field: str | None) -> Picture:
    result = summary["results"][vtu.stem]
    angle = summary["loads"][vtu.stem].get("crank_deg")
    safety, at = result.get("min_safety_factor"), result.get("at_mm")
    known = field in {None, VON_MISES} and at
    return _picture(
        summary,
        vtu,
        [vtu.stem, _speed(summary), f"crank angle {angle:.1f}°" if angle is not None else ""],
        note=f"smallest safety factor against yield {safety:.3g}" if safety is not None else "",
        peak=result.get("max_von_mises_MPa") if field in {None, VON_MISES} else None,
        at=tuple(at) if known else None,
        error_percent=result.get("error_percent") if known else None,
        field=field or VON_MISES,
    )


def _envelope(summary: Mapping[str, Any], vtu: Path, field: str | None) -> Picture:
    found = summary["envelope"]
    fatigue = found.get("min_fatigue_safety_factor")
    factors = f"yield {found['min_safety_factor']:.3g}"
    factors += f", fatigue {fatigue:.3g}" if fatigue is not None else ""
    note = f"smallest safety factors: {factors}"
    return _picture(summary, vtu, ["whole crank cycle", _speed(summary)], note=note, field=field or VON_MISES)


def _buckling(summary: Mapping[str, Any], vtu: Path, field: str | None) -> Picture:
    field = field or f"{MODE}1"
    found = summary["buckling"]
    mode = found["modes"][found["shapes_of"]][_number(field) - 1]
    heading = [
        f"buckling under {found['shapes_of']}",
        f"mode {_number(field)} at {mode['factor']:.4g} times the load",
        _speed(summary),
    ]
    return _picture(summary, vtu, heading, note=f"moves {mode['moves']}", field=field)


def _picture(
    summary: Mapping[str, Any], vtu: Path, heading: list[str], *, note: str, field: str, **worst: Any
) -> Picture:
    title = f"{summary['study']}: " + ", ".join(part for part in heading if part)
    notes = [note, "" if summary.get("trusted", True) else "NOT TO BE TRUSTED: a check failed"]
    said = tuple(part for part in notes if part)
    return Picture(vtu, vtu.with_suffix(".png"), title, notes=said, field=field, **worst)


def _speed(summary: Mapping[str, Any]) -> str:
    speed = summary.get("rpm")
    return f"{speed:g} rpm" if speed else ""


def _number(field: str) -> int:
    return int(field.removeprefix(MODE))
