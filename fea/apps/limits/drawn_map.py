"""The map of limits: a picture, and a page that tells the factors under the pointer, and where on the rod."""

import base64
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fea.apps.limits.describe import Bars
from fea.apps.limits.explore import RodLimits
from fea.apps.limits.figures import LimitsFigures
from fea.apps.limits.limit_map import ELASTIC, Limit, ending, least_of
from fea.apps.limits.states import ONSETS, Mode
from fea.base.units import BAR, DEG
from fea.output.html import embedded_json, html_page, page_file
from fea.output.plots.figure import label_axes, new_figure, save
from fea.output.report.page import viewer
from fea.output.report.scene import scene
from fea.output.stored_run import Run
from fea.output.text import write_text
from fea.output.units import in_heading, in_rows, in_unit, scale, unit
from geometry.arrays import Floats
from loads.gas import LARGEST_PEAK

TABLE_HEAD = ("rpm", "safe peak pressure, bar", "ended by")
_COLUMNS, _LINES = 160, 140  # of the map
# Larger factors are written as this one: such a mode does not limit the rod.
_MOST = 20.0
# The page holds one in so many columns and rows of the map, and interpolates between them.
_EVERY = 4


@dataclass(frozen=True)
class DrawnMap:
    """What is known of a rod on a grid of speeds and peak pressures."""

    found: RodLimits
    figures: LimitsFigures
    speeds: Sequence[float]  #: of the study, rpm
    rpm: Floats  #: (n,) of the columns
    peak: Floats  #: (m,) of the rows, bar
    factors: Mapping[Mode, Floats]  #: (m, n) over that required
    yielding: Floats  #: (m, n) the largest of the loads over that at yield: beyond `ELASTIC` nothing is known
    #: (m, n) of life: infinite without an end, NaN where it is not known; None if it was not asked for
    hours: Floats | None

    @classmethod
    def of(cls, found: RodLimits, figures: LimitsFigures, speeds: Sequence[float]) -> "DrawnMap":
        """Evaluate the limits that were found over a grid that shows all of them."""
        operation, of_rays = found.operation, found.of_rays
        every = [limit for line in of_rays.limits.values() for limit in line if limit is not None]
        rpm = np.linspace(0.0, 1.08 * max([*(limit.rpm for limit in every), *speeds]), _COLUMNS)[1:]
        top = 1.15 * max([*(limit.peak for limit in every), *(operation.peak(each) for each in speeds)])
        peak = np.linspace(0.0, min(top, LARGEST_PEAK), _LINES)
        charge = np.stack(
            [operation.scale(each, peak) if operation.burns else 0 * peak for each in rpm], axis=1
        )
        at = np.broadcast_to(rpm, charge.shape), np.maximum(charge, 0.0)
        factors = of_rays.factors(*at)
        yielding = figures.required_safety_factor / factors.get(Mode.YIELD, np.full_like(charge, np.inf))
        hours = None if found.life is None else np.where(yielding > ELASTIC, np.nan, found.life.hours(*at))
        return cls(found, figures, speeds, rpm, peak / BAR, factors, yielding, hours)

    @property
    def title(self) -> str:
        """What is shown."""
        return f"{self.figures.study}: limits with a safety factor of {self.figures.required_safety_factor:g}"

    @property
    def load(self) -> str:
        """Name of the line of full load."""
        return "the study's load" if self.found.operation.full_load is None else "full load"

    def draw(self, path: Path) -> tuple[float, ...]:
        """Draw the map; return the ends of its axes: left, right, top, bottom, in shares from the top left.

        Raises `PictureError`: the file could not be written.
        """
        figure, bars = new_figure(9, 6.6), Bars(self.found)
        axes = figure.subplots()
        least = least_of(ending(self.factors), self.yielding)
        axes.contourf(self.rpm, self.peak, least, levels=[1.0, np.inf], colors=["#d9efd9"])
        beyond = np.where(self.yielding > ELASTIC, 1.0, 0.0)
        axes.contourf(self.rpm, self.peak, beyond, levels=[0.5, 1.5], colors=["0.85"])
        for number, (mode, line) in enumerate(self.found.of_rays.limits.items()):
            color, name = f"C{number}", f"{mode.value}{', λ = 1' if mode is Mode.FILM else ''}"
            rpm, peak, bar = np.array([_point(limit, bars) for limit in line]).T
            axes.plot(rpm, peak, "-", color=color, lw=1.6, label=name, zorder=3)
            wide = np.isfinite(bar) & np.isfinite(rpm)
            if wide.any():  # along a ray speed squared and pressure grow alike
                ends = np.concatenate([1 - bar[wide], (1 + bar[wide])[::-1]])
                rpm, peak = (np.concatenate([of[wide], of[wide][::-1]]) for of in (rpm, peak))
                axes.fill(rpm * np.sqrt(ends), peak * ends, color=color, alpha=0.18, lw=0, zorder=2)
        full, closed = self.rpm[self.rpm >= self.found.operation.idle], self.figures.closed_throttle
        axes.plot(
            full, [*map(self._today, full.tolist())], "--", color="0.25", lw=1.3, label=self.load, zorder=3
        )
        today = [*map(self._today, self.speeds)]
        axes.plot(self.speeds, today, "o", color="0.1", ms=6, label="operating points", zorder=4)
        if closed is not None:
            at, label = (closed.value, closed.peak_pressure_bar), "limit, throttle closed"
            axes.plot(*at, "v", color="0.1", mfc="w", ms=8, label=label, zorder=4)
        if self.hours is not None:
            known = np.log10(np.where(np.isfinite(self.hours), self.hours, np.nan))
            style: dict[str, Any] = {"levels": [0, 1, 2, 3], "colors": "0.35", "linewidths": 0.8}
            lines = axes.contour(self.rpm, self.peak, known, **style)
            axes.clabel(lines, fmt=lambda at: f"{10**at:.0f} h", fontsize=8)
        axes.set_xlim(self.rpm[0], self.rpm[-1])
        axes.set_ylim(0, self.peak[-1])
        label_axes(axes, "engine speed, rpm", "peak pressure (absolute), bar")
        axes.set_title(self.title, fontsize=11)
        axes.grid(alpha=0.3)
        if boosts := self._boosts():
            right = axes.twinx()
            right.set_ylim(0, self.peak[-1])
            right.set_yticks([*boosts.values()], [f"{in_unit(boost, 'bar'):.3g}" for boost in boosts])
            right.set_ylabel(in_heading("boost at the study's speed, bar"))
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
        save(figure, path, dpi=160)
        box = axes.get_position()
        return tuple(round(float(end), 5) for end in (box.x0, box.x1, 1 - box.y1, 1 - box.y0))

    def _today(self, rpm: float) -> float:
        """Peak pressure of full load at a speed, bar."""
        operation = self.found.operation
        return operation.peak(rpm, operation.today(rpm)) / BAR

    def _boosts(self) -> dict[float, float]:
        """Peak pressures at the study's speed by round pressures of boost, bar."""
        operation, ticks = self.found.operation, dict[float, float]()
        if operation.burns:
            none, one = operation.boost(0.0), operation.boost(1.0)
            for boost in np.arange(math.ceil(2 * none) / 2, 100, 0.5).tolist():
                ticks[boost] = operation.peak(self.found.rpm, (boost - none) / (one - none)) / BAR
        some = [boost for boost, peak in ticks.items() if 0 <= peak <= self.peak[-1]]
        return {boost: ticks[boost] for boost in some[:: max(1, len(some) // 8)]}

    def write_page(self, path: Path, run: Run, picture: bytes, box: Sequence[float]) -> None:
        """Write the page, which shows the load cases of a run, and the map with the ends of its axes.

        Raises `StorageError`: the file could not be written.
        """
        bar, bars = scale("bar"), Bars(self.found)
        rows, columns = ([*range(0, len(own), _EVERY), len(own) - 1] for own in (self.peak, self.rpm))
        some = np.ix_(rows, columns)
        data: dict[str, Any] = {
            "box": box,
            "rpm": _rounded(self.rpm[columns]),
            "peak": _rounded(bar * self.peak[rows]),
            "unit": unit("bar"),
            "onsets": sorted(ONSETS),
            "factors": {
                mode.value: [*map(_rounded, np.minimum(own[some], _MOST))]
                for mode, own in self.factors.items()
            },
            "lines": {
                mode.value: [_told(limit, bars, bar) for limit in line if limit is not None]
                for mode, line in self.found.of_rays.limits.items()
            },
        }
        if self.hours is not None:
            hours = np.clip(np.nan_to_num(self.hours, nan=0.0), 1e-3, 1e6)[some]
            data["hours"] = [*map(_rounded, hours)]
        of_rod, script = viewer(run, scene(run), ("limits_map.js",))
        page = html_page(
            "report",
            "limits_map.html.jinja",
            page_file("report", "report.css") + page_file("report", "limits_map.css"),
            script,
            **of_rod,
            title=self.title,
            rpm=run.summary.rpm,
            text=self.figures.text,
            head=[in_heading(each) for each in TABLE_HEAD],
            table=list(in_rows(TABLE_HEAD, self.figures.table)),
            notes=[str(note) for note in (*self.figures.notes, *self.figures.left_out)],
            load=self.load,
            picture=base64.b64encode(picture).decode(),
            data=embedded_json(data),
        )
        write_text(path, page)


def _point(limit: Limit | None, bars: Bars) -> tuple[float, float, float]:
    """Speed, peak pressure, bar, and relative error bar of the load; NaN interrupts a line."""
    if limit is None:
        return math.nan, math.nan, math.nan
    return limit.rpm, limit.peak / BAR, (bars.percent(limit) or math.nan) / 100


def _told(limit: Limit, bars: Bars, bar: float) -> dict[str, Any]:
    """A limit with its place, mm, and crank angle, °; `bar` converts pressures."""
    angle = limit.worst.crank_angle
    of_rod = {"name": bars.place(limit), "at": limit.worst.at, "angle": angle and angle / DEG}
    return {"rpm": limit.rpm, "peak": bar * (limit.peak / BAR), **of_rod}


def _rounded(values: Floats) -> list[float]:
    return [float(f"{value:.4g}") for value in values]
