"""The map of limits: speed against peak pressure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fea.output.plots.figure import label_axes, new_figure, save
from fea.output.units import in_heading, in_unit
from geometry.arrays import Floats


@dataclass(frozen=True, kw_only=True)
class MapLine:
    """The limit of one mode: points (n,) with the bar of the load there, relative; NaN interrupts it."""

    rpm: Floats
    peak: Floats  #: bar
    bar: Floats


@dataclass(frozen=True, kw_only=True)
class MapPlot:
    """What the map shows."""

    title: str
    rpm: Floats  #: (n,) of the columns
    peak: Floats  #: (m,) of the rows, bar
    factor: Floats  #: (m, n) the least factor over that required
    #: (m, n) largest of the loads over that at yield: beyond `elastic` nothing is known; None without gas
    yielding: Floats
    elastic: float
    lines: Mapping[str, MapLine]
    full_load: tuple[Floats, Floats]  #: rpm, bar
    full_load_name: str
    points: Sequence[tuple[float, float]]  #: operating points: rpm, bar
    closed_throttle: tuple[float, float] | None  #: rpm, bar
    boost: Sequence[tuple[float, float]]  #: peak pressures, bar, of round pressures of boost, bar
    #: (m, n) of life: infinite without an end, NaN where it is not known; None if it was not asked for
    hours: Floats | None = None


def plot_limits(path: Path, shown: MapPlot) -> tuple[float, ...]:
    """Draw the map; left, right, top and bottom end of its axes, in shares of the picture from the top left.

    Raises `PictureError`: the file could not be written.
    """
    figure = new_figure(9, 6.6)
    axes = figure.subplots()
    axes.contourf(shown.rpm, shown.peak, shown.factor, levels=[1.0, np.inf], colors=["#d9efd9"])
    beyond = np.where(shown.yielding > shown.elastic, 1.0, 0.0)
    axes.contourf(shown.rpm, shown.peak, beyond, levels=[0.5, 1.5], colors=["0.85"])
    for number, (mode, line) in enumerate(shown.lines.items()):
        color = f"C{number}"
        axes.plot(line.rpm, line.peak, "-", color=color, lw=1.6, label=mode, zorder=3)
        wide = np.isfinite(line.bar) & np.isfinite(line.rpm)
        if wide.any():  # along a ray speed squared and pressure grow alike
            inner, outer = 1 - line.bar[wide], 1 + line.bar[wide]
            rpm = np.concatenate([line.rpm[wide] * np.sqrt(inner), (line.rpm[wide] * np.sqrt(outer))[::-1]])
            peak = np.concatenate([line.peak[wide] * inner, (line.peak[wide] * outer)[::-1]])
            axes.fill(rpm, peak, color=color, alpha=0.18, lw=0, zorder=2)
    axes.plot(*shown.full_load, "--", color="0.25", lw=1.3, label=shown.full_load_name, zorder=3)
    axes.plot(*np.transpose(shown.points), "o", color="0.1", ms=6, label="operating points", zorder=4)
    if shown.closed_throttle is not None:
        axes.plot(
            *shown.closed_throttle, "v", color="0.1", mfc="w", ms=8, label="limit, throttle closed", zorder=4
        )
    if shown.hours is not None:
        known = np.where(np.isfinite(shown.hours), shown.hours, np.nan)
        lines = axes.contour(
            shown.rpm, shown.peak, np.log10(known), levels=[0, 1, 2, 3], colors="0.35", linewidths=0.8
        )
        axes.clabel(lines, fmt=lambda at: f"{10**at:.0f} h", fontsize=8)
    axes.set_xlim(shown.rpm[0], shown.rpm[-1])
    axes.set_ylim(0, shown.peak[-1])
    label_axes(axes, "engine speed, rpm", "peak pressure (absolute), bar")
    axes.set_title(shown.title, fontsize=11)
    axes.grid(alpha=0.3)
    if shown.boost:
        right = axes.twinx()
        right.set_ylim(0, shown.peak[-1])
        right.set_yticks(
            [peak for _, peak in shown.boost], [f"{in_unit(boost, 'bar'):.3g}" for boost, _ in shown.boost]
        )
        right.set_ylabel(in_heading("boost at the study's speed, bar"))
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    save(figure, path, dpi=160)
    box = axes.get_position()
    return tuple(round(float(end), 5) for end in (box.x0, box.x1, 1 - box.y1, 1 - box.y0))
