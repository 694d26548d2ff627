"""Plots of the crank cycle for a report."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fea.analysis.forces import ForceReport
from fea.analysis.many_speeds import SpeedMap, rounded
from fea.output.plots.figure import new_figure, save
from fea.output.units import scale, unit

# Column, title, unit, and factor from the column's unit to that unit.
_PANELS: tuple[tuple[str, str, str, float], ...] = (
    ("gas_N", "Gas force on the piston", "kN", 1e-3),
    ("piston_acceleration_m_s2", "Piston acceleration (towards the head)", "km/s²", 1e-3),
    ("pin_axial_N", "Force along the rod, piston pin (tension +)", "kN", 1e-3),
    ("crank_axial_N", "Force along the rod, crank pin (tension +)", "kN", 1e-3),
    ("wall_N", "Wall force on the piston", "kN", 1e-3),
    ("crank_transverse_N", "Transverse force, crank pin", "kN", 1e-3),
    ("torque_Nm", "Torque on the crank", "N·m", 1.0),
    ("shaking_x_N", "Shaking force along the cylinder", "kN", 1e-3),
)
_FIRING = "TDC\nfiring"
_DEAD_CENTRES = {
    720: ((0, "TDC"), (180, "BDC"), (360, _FIRING), (540, "BDC"), (720, "TDC")),
    360: ((0, _FIRING), (180, "BDC"), (360, _FIRING)),
}
_MOST_LINES = 12  # with more speeds than this, a colour scale replaces the legend
_PALEST = 0.85
_BARE = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}  # ground of a text


def plot_forces(path: Path, reports: Sequence[ForceReport], study: str) -> None:
    """Plot forces and torque of every speed over the crank angle.

    If all cylinders were computed, torque and shaking force are those of the whole engine, with those of the
    first cylinder as dashed lines. Raises `PictureError`: the file could not be written.
    """
    figure = new_figure(11, 13)
    axes = np.ravel(figure.subplots(4, 2, sharex=True))
    for panel, (column, heading, name, factor) in zip(axes, _PANELS, strict=True):
        _draw(panel, reports, column, factor * scale(name))
        _decorate(panel, heading, unit(name), reports[0].cycle_degrees)
    _draw_samples(axes[0], reports)
    for panel in axes[-2:]:
        panel.set_xlabel("crank angle, °")
    if len(reports) <= _MOST_LINES:
        axes[0].legend(frameon=False, fontsize=8)
    else:
        _add_scale(figure, axes, reports)
    parts = "one cylinder"
    if reports[0].engine is not None:
        parts = "first cylinder; torque and shaking force of the whole engine (dashed: of the first cylinder)"
    figure.suptitle(f"{study}: {parts}")
    save(figure, path, 120)


def _draw_samples(panel: Any, reports: Sequence[ForceReport]) -> None:
    traces = [report.samples for report in reports if report.samples is not None]
    for i, trace in enumerate(traces):
        force = trace.bar * trace.newtons_per_bar * 1e-3 * scale("kN")
        label = f"{trace.source}, as read" if i == 0 else None
        panel.plot(trace.degrees, force, ".", color="tab:orange", ms=5, zorder=1, label=label)
    if traces:
        per_bar = traces[0].newtons_per_bar * 1e-3 * scale("kN") / scale("bar")
        right = panel.secondary_yaxis("right", functions=(lambda kn: kn / per_bar, lambda bar: bar * per_bar))
        right.set_ylabel(f"{unit('bar')} gauge")


def _add_scale(figure: Any, axes: Any, reports: Sequence[ForceReport]) -> None:
    from matplotlib import colormaps  # noqa: PLC0415
    from matplotlib.cm import ScalarMappable  # noqa: PLC0415
    from matplotlib.colors import ListedColormap, Normalize  # noqa: PLC0415

    rpm = [report.rpm for report in reports]
    shades = ListedColormap(colormaps["viridis"](np.linspace(0, _PALEST, 256)))
    scale = ScalarMappable(Normalize(min(rpm), max(rpm)), shades)
    figure.colorbar(scale, ax=axes.tolist(), location="bottom", label="speed, rpm", aspect=60, pad=0.02)


def _draw(panel: Any, reports: Sequence[ForceReport], column: str, factor: float) -> None:
    from matplotlib import colormaps  # noqa: PLC0415

    rpm = np.array([report.rpm for report in reports], dtype=float)
    shades = colormaps["viridis"](np.asarray(_PALEST * (rpm - rpm.min()) / (np.ptp(rpm) or 1.0)))
    for report, shade in zip(reports, shades, strict=True):
        engine = report.engine
        summed = engine is not None and not np.isnan(np.asarray(engine[column])).all()
        if engine is not None and summed:
            _line(panel, engine, column, factor, color=shade, label=f"{report.rpm:g} rpm")
        style = {"ls": "--", "lw": 0.8, "alpha": 0.7} if summed else {"label": f"{report.rpm:g} rpm"}
        _line(panel, report.first, column, factor, color=shade, **style)


def _line(panel: Any, table: Any, column: str, factor: float, **style: Any) -> None:
    panel.plot(np.asarray(table["crank_deg"]), np.asarray(table[column]) * factor, **({"lw": 1.4} | style))


def _decorate(panel: Any, heading: str, name: str, last: int) -> None:
    panel.set_title(heading, fontsize=10)
    panel.set_ylabel(name)
    panel.set_xlim(0, last)
    panel.set_xticks(range(0, last + 1, last // 8))
    panel.grid(alpha=0.3)
    panel.axhline(0, color="0.5", lw=0.8)
    low, high = panel.get_ylim()
    panel.set_ylim(low, high + 0.12 * (high - low))
    for degrees, centre in _DEAD_CENTRES[last]:
        panel.axvline(degrees, color="0.5", lw=0.8, ls=":")
        side = {0: "left", last: "right"}.get(degrees, "center")
        inwards = {"left": last / 120, "right": -last / 120}.get(side, 0)
        style = {"ha": side, "va": "top", "fontsize": 7, "color": "0.35", "bbox": _BARE}
        panel.text(degrees + inwards, 0.99, centre, transform=panel.get_xaxis_transform(), **style)


_COLOURS = {"yield": "C0", "fatigue": "C3", "crossland": "C2"}
_HIGHEST = 5.0  # upper end of the plot: larger factors are safe


def plot_speed_map(path: Path, study: str, speeds: SpeedMap) -> None:
    """Draw the least factors against speed, and where they fall below 1. Raises `PictureError`."""
    figure = new_figure(9, 5)
    panel = figure.subplots()
    rpm = speeds.columns["rpm"]
    for mode, colour in _COLOURS.items():
        factor = speeds.columns[f"{mode}_safety_factor"]
        if np.isnan(factor).all():
            continue
        critical = speeds.critical.get(mode)
        label = mode if critical is None else f"{mode}: below 1 from {rounded(critical)} rpm"
        panel.plot(rpm, factor, color=colour, marker=".", label=label)
        if critical is not None:
            panel.axvline(critical, color=colour, lw=0.9, ls=":")
    panel.axhline(1, color="0.3", lw=1)
    panel.set_ylim(0, min(_HIGHEST, panel.get_ylim()[1]))
    panel.set_xlabel("engine speed, rpm")
    panel.set_ylabel("smallest safety factor of the cycle")
    panel.set_title(study, fontsize=11)
    panel.grid(alpha=0.3)
    panel.legend(frameon=False)
    save(figure, path)
