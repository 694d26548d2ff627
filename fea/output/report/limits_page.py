"""The map of limits as one HTML page, which tells the factors under the pointer, and where on the rod."""

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fea.output.html import html_page, page_file
from fea.output.plots.limits import MapPlot
from fea.output.report.coding import embedded_json
from fea.output.report.page import viewer
from fea.output.report.scene import scene
from fea.output.stored_run import Run
from fea.output.text import write_text
from fea.output.units import in_heading, in_rows, scale, unit
from geometry.arrays import Floats

TABLE_HEAD = ("rpm", "safe peak pressure, bar", "ended by")
# Larger factors are written as this one: such a mode does not limit the rod.
_MOST = 20.0
# The page holds one in so many columns and rows of the map, and interpolates between them.
_EVERY = 4


def write_limits_page(
    path: Path,
    shown: MapPlot,
    run: Run,
    *,
    picture: bytes,
    box: Sequence[float],
    text: str,
    factors: Mapping[str, Floats],
    places: Mapping[str, Sequence[Mapping[str, Any] | None]],
    table: Sequence[Sequence[str]],
    notes: Sequence[str],
    onsets: Sequence[str] = (),
) -> None:
    """Write the page. Raises `StorageError`: the file could not be written.

    `run`: the load cases of the rod in three dimensions; `picture`, `box`: PNG of the map, and the ends of
    its axes (see `plot_limits`); `text`: the answer in words; `factors` (m, n) over that required by mode, at
    the points of the map; `places`: `name`, `at`, mm, and crank `angle`, °, of each point of a mode's line;
    `table`: ranges of safe peak pressures; `onsets`: modes that do not end a rod.
    """
    bar = scale("bar")
    rows, columns = (np.arange(0, len(own), _EVERY) for own in (shown.peak, shown.rpm))
    rows, columns = np.append(rows, len(shown.peak) - 1), np.append(columns, len(shown.rpm) - 1)
    data: dict[str, Any] = {
        "box": box,
        "rpm": _rounded(shown.rpm[columns]),
        "peak": _rounded(bar * shown.peak[rows]),
        "unit": unit("bar"),
        "onsets": onsets,
        "factors": {
            mode: [_rounded(np.minimum(row, _MOST)) for row in own[np.ix_(rows, columns)]]
            for mode, own in factors.items()
        },
        "lines": {
            mode: [
                {"rpm": float(rpm), "peak": float(bar * peak), **(place or {})}
                for rpm, peak, place in zip(line.rpm, line.peak, places[mode], strict=True)
                if np.isfinite(rpm)
            ]
            for mode, line in shown.lines.items()
        },
    }
    if shown.hours is not None:
        hours = np.clip(np.nan_to_num(shown.hours, nan=0.0), 1e-3, 1e6)[np.ix_(rows, columns)]
        data["hours"] = [_rounded(row) for row in hours]
    drawn = scene(run)
    of_rod, script = viewer(run, drawn, ("limits_map.js",))
    page = html_page(
        "report",
        "limits_map.html.jinja",
        page_file("report", "report.css") + page_file("report", "limits_map.css"),
        script,
        **of_rod,
        title=shown.title,
        rpm=run.summary.rpm,
        text=text,
        head=[in_heading(each) for each in TABLE_HEAD],
        table=list(in_rows(TABLE_HEAD, table)),
        notes=notes,
        load=shown.full_load_name,
        picture=base64.b64encode(picture).decode(),
        data=embedded_json(data),
    )
    write_text(path, page)


def _rounded(values: Floats) -> list[float]:
    return [float(f"{value:.4g}") for value in values]
