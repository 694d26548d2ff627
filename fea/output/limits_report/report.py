"""The map of limits as one HTML page, which tells the factors under the pointer."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fea.output.html import html_page, page_file
from fea.output.plots.limits import MapPlot
from fea.output.report.coding import embedded_json
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
    *,
    text: str,
    factors: Mapping[str, Floats],
    places: Mapping[str, Sequence[str]],
    table: Sequence[Sequence[str]],
    notes: Sequence[str],
    onsets: Sequence[str] = (),
) -> None:
    """Write the page.

    `text`: the answer in words; `factors` (m, n) over that required by mode, at the points of the map;
    `places`: where each point of a mode's line is, in words; `table`: ranges of safe peak pressures;
    `onsets`: modes that do not end a rod.

    Raises
    ------
    StorageError
        The file could not be written.
    """
    bar = scale("bar")
    both = np.array([1.0, bar])  # of a speed and a pressure
    data: dict[str, Any] = {
        "rpm": _rounded(shown.rpm[::_EVERY]),
        "peak": _rounded(bar * shown.peak[::_EVERY]),
        "unit": unit("bar"),
        "elastic": shown.elastic,
        "onsets": onsets,
        "factors": {
            mode: [_rounded(np.minimum(row, _MOST)) for row in own[::_EVERY, ::_EVERY]]
            for mode, own in factors.items()
        },
        "lines": {
            mode: [
                [*_rounded(both * point), place]
                for *point, place in zip(line.rpm, line.peak, places[mode], strict=True)
                if np.isfinite(point[0])
            ]
            for mode, line in shown.lines.items()
        },
        "load": [_rounded(own) for own in both[:, None] * shown.full_load],
        "points": [_rounded(both * each) for each in shown.points],
        "closed": None if shown.closed_throttle is None else _rounded(both * shown.closed_throttle),
    }
    room = "limits_report"
    page = html_page(
        room,
        "limits.html.jinja",
        page_file(room, "limits.css"),
        page_file(room, "limits.js"),
        title=shown.title,
        text=text,
        head=[in_heading(each) for each in TABLE_HEAD],
        table=list(in_rows(TABLE_HEAD, table)),
        notes=notes,
        load=shown.full_load_name,
        data=embedded_json(data),
    )
    write_text(path, page)


def _rounded(values: Floats) -> list[float]:
    return [float(f"{value:.4g}") for value in values]
