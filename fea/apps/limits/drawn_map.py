"""The map of limits: a picture, and a page that shows the factors under the pointer, and where on the rod."""

import base64
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fea.apps.limits.explore import RodLimits
from fea.apps.limits.factors import ONSETS, PLASTIC, FailureMode
from fea.apps.limits.figures import LimitsFigures
from fea.apps.limits.limit_map import ELASTIC, LimitPoint, ending, least_of
from fea.base.units import BAR, DEG
from fea.judge.cycle_life import LONGEST
from fea.output.folder import write_text
from fea.output.html import embedded_json, html_page, page_file
from fea.output.json_file import JsonObject
from fea.output.plots.figure import label_axes, new_figure, save
from fea.output.report.page import viewer
from fea.output.report.scene import scene
from fea.output.stored_run import Run
from fea.output.units import in_heading, in_rows, scale, unit
from geometry.arrays import Floats
from loads.gas import LARGEST_PEAK

_COLUMNS, _LINES = 160, 140  # of the map
# What lies further out than so many times the limits of elastic stress is left out.
_SHOWN = 1.3
# Larger factors are written as this one: such a mode does not limit the rod.
_MOST = 20.0
# The page holds one in so many columns and rows of the map, and interpolates between them.
_EVERY = 4


class DrawnMap:
    """The limits of a rod on a grid of speeds (n,), rpm, and peak pressures (m,), bar.

    `speeds`: of the study, rpm. Attributes: `hours` (m, n) of life: infinite if unlimited, NaN where it is
    not known; None if it was not asked for.
    """

    def __init__(self, found: RodLimits, figures: LimitsFigures, speeds: Sequence[float]) -> None:
        self._found, self._figures, self._speeds = found, figures, speeds
        engine, of_rays = found.engine, found.of_rays
        elastic = [limit for limit in of_rays.points if limit.mode not in PLASTIC]
        rpm = max([*(limit.rpm for limit in elastic), *speeds])
        peak = max([*(limit.peak for limit in elastic), *(engine.peak(each) for each in speeds)])
        near = [limit for limit in of_rays.points if limit.rpm < _SHOWN * rpm and limit.peak < _SHOWN * peak]
        rpm, peak = max([rpm, *(limit.rpm for limit in near)]), max([peak, *(limit.peak for limit in near)])
        self.rpm = np.linspace(0.0, 1.08 * rpm, _COLUMNS)[1:]
        peaks = np.linspace(0.0, min(1.15 * peak, LARGEST_PEAK), _LINES)
        self.peak = peaks / BAR
        gas = [engine.scale(each, peaks) if engine.burns else 0 * peaks for each in self.rpm]
        points = np.broadcast_to(self.rpm, (_LINES, len(gas))), np.maximum(np.stack(gas, axis=1), 0.0)
        self._points = points
        self._factors = of_rays.factors(*points)  # over that required
        yielding = self._factors.get(FailureMode.YIELD, np.full(points[1].shape, np.inf))
        # The largest of the loads over that at yield: beyond `ELASTIC` nothing is known.
        self._yielding = figures.required_safety_factor / yielding
        known = self._yielding <= ELASTIC
        self.hours = None if found.life is None else np.where(known, found.life.hours(*points), np.nan)
        required = figures.required_safety_factor
        self._title = f"{figures.study}: limits with a safety factor of {required:g}"
        self._line = ", hours on an assumed S–N line" if found.life is not None and found.life.assumed else ""
        self._load = "the study's load" if engine.full_load is None else "full load"

    def draw(self, path: Path) -> tuple[float, ...]:
        """Draw the map; return the ends of its axes: left, right, top, bottom, in shares from the top left.

        Raises `PictureError`: the file could not be written.
        """
        figure = new_figure(9, 6.6)
        axes = figure.subplots()
        least = least_of(ending(self._factors), self._yielding)
        axes.contourf(self.rpm, self.peak, least, levels=[1.0, np.inf], colors=["#d9efd9"])
        beyond = np.where(self._yielding > ELASTIC, 1.0, 0.0)
        axes.contourf(self.rpm, self.peak, beyond, levels=[0.5, 1.5], colors=["0.85"])
        self._draw_limits(axes)
        self._draw_operation(axes)
        if self.hours is not None:
            known = np.log10(np.where(np.isfinite(self.hours), self.hours, np.nan))
            style: dict[str, Any] = {"levels": [0, 1, 2, 3], "colors": "0.35", "linewidths": 0.8}
            lines = axes.contour(self.rpm, self.peak, known, **style)
            axes.clabel(lines, fmt=lambda at: f"{10**at:.0f} h", fontsize=8)
            self._draw_border(axes)
        axes.set_xlim(self.rpm[0], self.rpm[-1])
        axes.set_ylim(0, self.peak[-1])
        label_axes(axes, "engine speed, rpm", "peak pressure (absolute), bar")
        axes.set_title(self._title + self._line, fontsize=11)
        axes.grid(alpha=0.3)
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
        save(figure, path, dpi=160)
        box = axes.get_position()
        return tuple(round(float(end), 5) for end in (box.x0, box.x1, 1 - box.y1, 1 - box.y0))

    @property
    def _endless_below_fatigue(self) -> bool:
        return self._found.life is not None and bool((self._found.life.undamaged == 1).all())

    def _draw_border(self, axes: Any) -> None:
        """Draw up to where life is unlimited or, of metals without an endurance limit, beyond 10⁸ cycles."""
        life = self._found.life
        if life is None or self.hours is None or self._endless_below_fatigue:
            return
        if life.undamaged.all():
            field, level, words = life.of_unlimited(*self._points), 1.0, "unlimited below"
        else:
            field, level = np.nan_to_num(self.hours * life.per_hour * self.rpm), LONGEST
            words = "10⁸ cycles"
        border = axes.contour(self.rpm, self.peak, field, levels=[level], colors="0.35", linestyles="--")
        axes.clabel(border, fmt=lambda _: words, fontsize=8)

    def _draw_limits(self, axes: Any) -> None:
        """Draw a line for each mode, with its error bar."""
        for number, (mode, line) in enumerate(self._found.of_rays.limits.items()):
            color, name = f"C{number}", f"{mode.value}{', λ = 1' if mode is FailureMode.FILM else ''}"
            name += ", unlimited life below" * (mode is FailureMode.FATIGUE and self._endless_below_fatigue)
            rpm, peak, bar = np.array([self._point(limit) for limit in line]).T
            axes.plot(rpm, peak, "-", color=color, lw=1.6, label=name, zorder=3)
            wide = np.isfinite(bar) & np.isfinite(rpm)
            if wide.any():  # along a ray speed squared and pressure grow alike
                ends = np.concatenate([1 - bar[wide], (1 + bar[wide])[::-1]])
                rpm, peak = (np.concatenate([of[wide], of[wide][::-1]]) for of in (rpm, peak))
                axes.fill(rpm * np.sqrt(ends), peak * ends, color=color, alpha=0.18, lw=0, zorder=2)

    def _point(self, limit: LimitPoint | None) -> tuple[float, float, float]:
        """Speed, peak pressure, bar, and relative error bar of the load; NaN interrupts a line."""
        if limit is None:
            return math.nan, math.nan, math.nan
        return limit.rpm, limit.peak / BAR, (self._found.bar_percent(limit) or math.nan) / 100

    def _draw_operation(self, axes: Any) -> None:
        """Draw full load, the operating points, the limit with the throttle closed, and a scale of boost."""
        engine, closed = self._found.engine, self._figures.closed_throttle
        if engine.burns:
            right = axes.secondary_yaxis("right", functions=(self._boost, self._peak))
            right.set_ylabel(in_heading("boost at the study's speed, bar"))

        def peaks(speeds: Sequence[float]) -> list[float]:
            return [engine.peak(rpm, engine.full_load_scale(rpm)) / BAR for rpm in speeds]

        full = self.rpm[self.rpm >= engine.idle].tolist()
        axes.plot(full, peaks(full), "--", color="0.25", lw=1.3, label=self._load, zorder=3)
        axes.plot(
            self._speeds, peaks(self._speeds), "o", color="0.1", ms=6, label="operating points", zorder=4
        )
        if closed is not None:
            at, label = (closed.value, closed.peak_pressure_bar), "limit, throttle closed"
            axes.plot(*at, "v", color="0.1", mfc="w", ms=8, label=label, zorder=4)

    def _boost(self, peak: Floats) -> Floats:
        """Boost, as it is shown, at the study's speed and peak pressures, bar."""
        engine = self._found.engine
        return scale("bar") * engine.boost(engine.scale(self._found.rpm, peak * BAR))

    def _peak(self, boost: Floats) -> Floats:
        """Peak pressures, bar: the inverse of `_boost`, which is linear."""
        none, atmospheric = self._boost(np.zeros(1)), self._boost(np.ones(1))
        return (boost - none) / (atmospheric - none)

    def write_page(self, path: Path, run: Run, picture: bytes, box: Sequence[float]) -> None:
        """Write the page, which shows the load cases of a run, and the map with the ends of its axes.

        Raises `StorageError`: the file could not be written.
        """
        bar = scale("bar")
        rows, columns = ([*range(0, len(axis), _EVERY), len(axis) - 1] for axis in (self.peak, self.rpm))
        some = np.ix_(rows, columns)
        data: JsonObject = {
            "box": box,
            "rpm": _rounded(self.rpm[columns]),
            "peak": _rounded(bar * self.peak[rows]),
            "unit": unit("bar"),
            "onsets": sorted(ONSETS),
            "factors": {
                mode.value: [*map(_rounded, np.minimum(factors[some], _MOST))]
                for mode, factors in self._factors.items()
            },
            "lines": {
                mode.value: [self._json(limit, bar) for limit in line if limit is not None]
                for mode, line in self._found.of_rays.limits.items()
            },
        }
        if self.hours is not None:
            hours = np.clip(np.nan_to_num(self.hours, nan=0.0), 1e-3, 1e6)[some]
            data |= {"hours": [*map(_rounded, hours)], "line": self._line.partition("hours ")[2]}
        of_rod, script = viewer(run, scene(run), ("limits_map.js",))
        page = html_page(
            "report",
            "limits_map.html.jinja",
            page_file("report", "report.css") + page_file("report", "limits_map.css"),
            script,
            **of_rod,
            title=self._title,
            rpm=run.summary.rpm,
            text=self._figures.text,
            head=[in_heading(each) for each in self._figures.table_head],
            table=list(in_rows(self._figures.table_head, self._figures.table)),
            notes=[str(note) for note in (*self._figures.notes, *self._figures.left_out)],
            load=self._load,
            picture=base64.b64encode(picture).decode(),
            data=embedded_json(data),
        )
        write_text(path, page)

    def _json(self, limit: LimitPoint, bar: float) -> JsonObject:
        """A limit with its place, mm, and crank angle, °; `bar` converts pressures."""
        angle = limit.worst.crank_angle
        of_rod = {"name": self._found.place(limit), "at": limit.worst.at, "angle": angle and angle / DEG}
        return {"rpm": limit.rpm, "peak": bar * (limit.peak / BAR), **of_rod}


def _rounded(values: Floats) -> list[float]:
    return [float(f"{value:.4g}") for value in values]
