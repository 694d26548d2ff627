"""The files of `fea limits`, and the data of its map."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from fea.apps.limits.describe import Bars
from fea.apps.limits.explore import Found
from fea.apps.limits.figures import LimitFigures, LimitsFigures
from fea.apps.limits.limit_map import ELASTIC, Limit, ending, least_of
from fea.apps.limits.states import ONSETS, Mode
from fea.base.units import BAR, DEG
from fea.output.folder import REPORT, SUMMARY
from fea.output.json_file import json_text
from fea.output.plots.limits import MapLine, MapPlot, plot_limits
from fea.output.report.limits_page import write_limits_page
from fea.output.stored_run import Run
from fea.output.text import write_text
from geometry.arrays import Floats
from loads.gas import LARGEST_PEAK

STUDY, TABLE, MAP, LIFE = "study.toml", "limits.csv", "limits.png", "life.csv"
FILES = (STUDY, SUMMARY, TABLE, MAP, REPORT)
_COLUMNS, _LINES = 160, 140  # of the map
_EVERY = 8  # of these in the table of life


def write_files(folder: Path, run: Run, found: Found, figures: LimitsFigures, speeds: list[float]) -> None:
    """Write the files; `run`: that of the highest speed."""
    write_text(folder / STUDY, run.study.text())
    write_text(folder / SUMMARY, json_text(figures))
    head = "mode,rpm,peak_pressure_bar,gas_scale,bar_percent,interpolated,x_mm,y_mm,z_mm,crank_deg"
    lines = [head, *map(_row, figures.limits)]
    write_text(folder / TABLE, "\n".join(lines) + "\n")
    shown, factors = _plot(found, figures, speeds)
    if shown.hours is not None:
        rows, columns = (range(0, count, _EVERY) for count in shown.hours.shape)
        cells = [
            f"{shown.rpm[column]:.7g},{shown.peak[row]:.7g},{shown.hours[row, column]:.4g}"
            for column in columns
            for row in rows
        ]
        write_text(folder / LIFE, "\n".join(["rpm,peak_pressure_bar,hours", *cells]) + "\n")
    box = plot_limits(folder / MAP, shown)
    bars = Bars(found)
    places = {
        mode.value: [None if one is None else _place(one, bars) for one in own]
        for mode, own in found.of_rays.limits.items()
    }
    notes = [str(note) for note in (*figures.notes, *figures.left_out)]
    write_limits_page(
        folder / REPORT,
        shown,
        run,
        picture=(folder / MAP).read_bytes(),
        box=box,
        text=figures.text,
        factors=factors,
        places=places,
        table=figures.table,
        notes=notes,
        onsets=sorted(ONSETS),
    )


def _place(limit: Limit, bars: Bars) -> dict[str, Any]:
    angle = limit.worst.crank_angle
    return {"name": bars.place(limit), "at": limit.worst.at, "angle": angle and angle / DEG}


def _row(own: LimitFigures) -> str:
    place = own.at_mm or (None, None, None)
    values = (own.rpm, own.peak_pressure_bar, own.gas_scale, own.bar, own.interpolated, *place, own.crank_deg)
    return ",".join([own.mode, *("" if value is None else f"{value:.7g}" for value in values)])


def _plot(found: Found, figures: LimitsFigures, speeds: list[float]) -> tuple[MapPlot, dict[str, Floats]]:
    """The map, and the factors at its points over the required one."""
    operation, of_rays, bars = found.operation, found.of_rays, Bars(found)
    every = [limit for own in of_rays.limits.values() for limit in own if limit is not None]
    rpm = np.linspace(0.0, 1.08 * max([limit.rpm for limit in every] + speeds), _COLUMNS)[1:]
    top = 1.15 * max([limit.peak for limit in every] + [operation.peak(each) for each in speeds])
    peak = np.linspace(0.0, min(top, LARGEST_PEAK), _LINES)
    scale = (
        np.stack([[operation.scale(each, p) for p in peak] for each in rpm], axis=1)
        if operation.burns
        else np.zeros((len(peak), len(rpm)))
    )
    factors = of_rays.factors(np.broadcast_to(rpm, scale.shape), np.maximum(scale, 0.0))
    yielding = figures.required_safety_factor / factors.get(Mode.YIELD, np.full_like(scale, np.inf))
    hours = None
    if found.life is not None:
        hours = found.life.hours(np.broadcast_to(rpm, scale.shape), np.maximum(scale, 0.0))
        hours[yielding > ELASTIC] = math.nan
    full = rpm[rpm >= operation.idle]
    own_load = found.operation.full_load is None
    today = [operation.peak(each, operation.today(each)) / BAR for each in full.tolist()]
    closed = figures.closed_throttle
    shown = MapPlot(
        title=f"{figures.study}: limits with a safety factor of {figures.required_safety_factor:g}",
        rpm=rpm,
        peak=peak / BAR,
        factor=least_of(ending(factors), scale),
        yielding=yielding,
        elastic=ELASTIC,
        lines={mode.value: _line(own, bars) for mode, own in of_rays.limits.items()},
        full_load=(full, np.array(today)),
        full_load_name="today's load" if own_load else "full load",
        points=[(each, operation.peak(each, operation.today(each)) / BAR) for each in speeds],
        closed_throttle=None if closed is None else (closed.value, closed.peak_pressure_bar),
        boost=_boosts(found, float(peak[-1])),
        hours=hours,
    )
    return shown, {mode.value: own for mode, own in factors.items()}


def _line(own: tuple[Limit | None, ...], bars: Bars) -> MapLine:
    nan = math.nan
    rows = [
        (nan, nan, nan) if one is None else (one.rpm, one.peak / BAR, (bars.percent(one) or nan) / 100)
        for one in own
    ]
    rpm, peak, bar = np.array(rows).T
    return MapLine(rpm=rpm, peak=peak, bar=bar)


def _boosts(found: Found, top: float) -> list[tuple[float, float]]:
    """Round pressures of boost with their peak pressures at the study's speed, bar."""
    operation = found.operation
    if not operation.burns:
        return []
    none, one = operation.boost(0.0), operation.boost(1.0)
    ticks = []
    for boost in np.arange(math.ceil(2 * none) / 2, 100, 0.5).tolist():
        peak = operation.peak(found.rpm, (boost - none) / (one - none))
        if peak > top:
            break
        if peak >= 0:
            ticks.append((boost, peak / BAR))
    return ticks[:: max(1, len(ticks) // 8)]
