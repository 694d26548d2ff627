"""The job behind `fea limits`: the largest speed and peak pressure of a rod, and a map of both, as files."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fea.analysis.adapt import adapt_mesh
from fea.analysis.result import run_result
from fea.apps.limits.describe import Bars, figures_of, words
from fea.apps.limits.explore import Found, explore, limited_speeds
from fea.apps.limits.figures import LimitFigures, LimitsFigures
from fea.apps.limits.limit_map import ELASTIC, Limit, ending, least_of
from fea.apps.limits.states import ONSETS, Mode
from fea.base.units import BAR, DEG
from fea.machine.clock import Clock
from fea.output.folder import REPORT, SUMMARY, require_replaceable, run_folder
from fea.output.json_file import json_text
from fea.output.plots.limits import MapLine, MapPlot, plot_limits
from fea.output.report.limits_page import write_limits_page
from fea.output.stored_run import Run
from fea.output.text import write_text
from fea.study.study import Study, load_study
from geometry.arrays import Floats
from geometry.errors import require_positive
from loads.gas import LARGEST_PEAK

STUDY, TABLE, MAP, LIFE = "study.toml", "limits.csv", "limits.png", "life.csv"
FILES = (STUDY, SUMMARY, TABLE, MAP, REPORT)
_COLUMNS, _LINES = 160, 140  # of the map
_EVERY = 8  # of these in the table of life
# How the answer begins that is told before the map is made.
FIRST = "answer: "


def limits(
    study: Study | str | Path,
    folder: Path | None = None,
    listener: Callable[[str], None] | None = None,
    *,
    at_rpm: float | None = None,
    duty: bool = False,
) -> LimitsFigures:
    """Find how fast a rod can turn and how much peak pressure it stands.

    Parameters
    ----------
    study
        A study, a shipped one by name, or the path of a TOML file.
    folder
        Where the files go; None for none.
    listener
        Is told the name of each stage as it begins.
    at_rpm
        Speed at which the largest peak pressure is found; default: that of the study, the highest.
    duty
        Whether hours of life are found too; also with [duty] in the study.

    Raises
    ------
    InvalidValue
        There is no engine, or a value of the study breaks a rule.
    OccupiedError, StorageError
        The folder cannot take the files.
    GeometryError, MeshError, UnderconstrainedError, SingularMatrixError, ContactError
        The rod cannot be drawn, meshed or solved.
    """
    study = study if isinstance(study, Study) else load_study(study)
    speeds = limited_speeds(study)
    if at_rpm is not None:
        require_positive("at_rpm", at_rpm)
    if folder is not None:
        require_replaceable(folder)
    clock = Clock(listener)
    lasting = speeds if duty or study.duty is not None else []
    asked, study = study, replace(study, duty=None, analysis=replace(study.analysis, cycle=True))
    adapted = adapt_mesh(study, [speeds[-1]], clock)
    tell = listener or (lambda _text: None)

    def answered(first: Found) -> None:
        tell(FIRST + words(first))

    with clock("limits"):
        found = explore(adapted, speeds[-1], at_rpm, tell, answered, lasting=lasting)
    files = FILES if found.life is None else (*FILES, LIFE)
    figures = replace(figures_of(study, found, adapted, clock), files=files)
    if folder is not None:
        run = replace(run_result(study, adapted, found.static), study=asked)
        with run_folder(folder) as part:
            write_files(part, run, found, figures, speeds)
    return figures


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
        mode.value: [None if one is None else _place(one, bars) for one in limits]
        for mode, limits in found.of_rays.limits.items()
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


def _row(at: LimitFigures) -> str:
    place = at.at_mm or (None, None, None)
    values = (at.rpm, at.peak_pressure_bar, at.gas_scale, at.bar, at.interpolated, *place, at.crank_deg)
    return ",".join([at.mode, *("" if value is None else f"{value:.7g}" for value in values)])


def _plot(found: Found, figures: LimitsFigures, speeds: list[float]) -> tuple[MapPlot, dict[str, Floats]]:
    """The map, and the factors at its points over the required one."""
    operation, of_rays, bars = found.operation, found.of_rays, Bars(found)
    every = [limit for line in of_rays.limits.values() for limit in line if limit is not None]
    rpm = np.linspace(0.0, 1.08 * max([limit.rpm for limit in every] + speeds), _COLUMNS)[1:]
    top = 1.15 * max([limit.peak for limit in every] + [operation.peak(each) for each in speeds])
    peak = np.linspace(0.0, min(top, LARGEST_PEAK), _LINES)
    scale = np.stack([operation.scale(each, peak) if operation.burns else 0 * peak for each in rpm], axis=1)
    factors = of_rays.factors(np.broadcast_to(rpm, scale.shape), np.maximum(scale, 0.0))
    yielding = figures.required_safety_factor / factors.get(Mode.YIELD, np.full_like(scale, np.inf))
    hours = None
    if found.life is not None:
        hours = found.life.hours(np.broadcast_to(rpm, scale.shape), np.maximum(scale, 0.0))
        hours[yielding > ELASTIC] = math.nan
    full = rpm[rpm >= operation.idle]
    today = [operation.peak(each, operation.today(each)) / BAR for each in full.tolist()]
    closed = figures.closed_throttle
    shown = MapPlot(
        title=f"{figures.study}: limits with a safety factor of {figures.required_safety_factor:g}",
        rpm=rpm,
        peak=peak / BAR,
        factor=least_of(ending(factors), scale),
        yielding=yielding,
        elastic=ELASTIC,
        lines={mode.value: _line(line, bars) for mode, line in of_rays.limits.items()},
        full_load=(full, np.array(today)),
        full_load_name="the study's load" if operation.full_load is None else "full load",
        points=[(each, operation.peak(each, operation.today(each)) / BAR) for each in speeds],
        closed_throttle=None if closed is None else (closed.value, closed.peak_pressure_bar),
        boost=_boosts(found, float(peak[-1])),
        hours=hours,
    )
    return shown, {mode.value: values for mode, values in factors.items()}


def _line(limits: tuple[Limit | None, ...], bars: Bars) -> MapLine:
    nan = math.nan
    rows = [
        (nan, nan, nan) if one is None else (one.rpm, one.peak / BAR, (bars.percent(one) or nan) / 100)
        for one in limits
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
