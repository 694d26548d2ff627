"""The report of a sweep: one HTML page with its drawings, each point linked to its study."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fea.apps.sweep.journal import Journal, State, failures
from fea.apps.sweep.statistics import FACTOR, MASS, Samples, Statistics, samples_of, statistics
from fea.apps.sweep.sweep_file import Sweep
from fea.output.html import embedded_json, html_page, page_file
from fea.output.pictures.scale import round_up
from fea.output.text import write_text
from fea.output.units import in_unit, named, unit
from geometry.arrays import Floats, Ints


def label(name: str) -> str:
    """Return the name of a key or a column with its unit: ``web thickness (mm)``.

    The table of a key is left out where it is that of the rod.
    """
    words, named_unit = named(name.removeprefix("rod."))
    words = words.replace(".", " ")
    return f"{words} ({unit(named_unit)})" if named_unit else {FACTOR: "least factor"}.get(words, words)


_STEPS = 4


@dataclass(frozen=True)
class Scatter:
    """A drawing for the template.

    `points` are places with the number of their design, ticks are places with labels; `limit` is the height
    of the line factor = 1, if it is in the picture.
    """

    x: str
    y: str
    points: tuple[tuple[float, float, int], ...]
    line: str
    x_ticks: tuple[tuple[float, str], ...]
    y_ticks: tuple[tuple[float, str], ...]
    limit: float | None
    size: tuple[float, float]


@dataclass(frozen=True)
class Axis:
    """Values along one axis of a drawing: what it shows, the values, and where it begins and ends."""

    name: str
    values: Floats
    first: float
    last: float

    @property
    def bounds(self) -> tuple[float, float]:
        """The bounds: the values' own, with some room."""
        known = self.values[np.isfinite(self.values)]
        low, high = float(known.min()), float(known.max())
        room = 0.05 * (high - low) or 0.05 * abs(high) or 1.0
        return low - room, high + room

    def place(self, value: float) -> float:
        """Return where a value lies."""
        low, high = self.bounds
        return round(self.first + (self.last - self.first) * (value - low) / (high - low), 1)

    @property
    def ticks(self) -> tuple[tuple[float, str], ...]:
        """Place and label of round values."""
        low, high = self.bounds
        step = round_up((high - low) / _STEPS)
        values = step * np.arange(np.ceil(low / step), np.floor(high / step) + 1)
        return tuple((self.place(value), f"{value:.5g}".replace("-", "−")) for value in values)


def scatter(x: Axis, y: Axis, numbers: Ints, line: Floats | None = None) -> Scatter:
    """Draw (n,) points of designs with these numbers, NaN where there is none, and a line (m, 2)."""
    known = np.flatnonzero(np.isfinite(x.values) & np.isfinite(y.values))
    points = tuple((x.place(x.values[n]), y.place(y.values[n]), int(numbers[n])) for n in known)
    low, high = y.bounds
    path = "" if line is None else " ".join(f"{x.place(a):g},{y.place(b):g}" for a, b in line)
    limit = y.place(1.0) if y.name.endswith("factor") and low < 1 < high else None
    size = (max(x.first, x.last), max(y.first, y.last))
    return Scatter(label(x.name), label(y.name), points, path, x.ticks, y.ticks, limit, size)


@dataclass(frozen=True, kw_only=True)
class Swept:
    """A sweep for the page."""

    title: str
    counts: str  #: what became of the rows, in words
    samples: Samples  #: the designs that are drawn
    studies: Sequence[str]  #: their study files
    statistics: Statistics
    failures: Sequence[tuple[int, str, int]] = ()  #: row, reason, count

    @cached_property
    def keys(self) -> dict[str, Floats]:
        """Values (n,) of the varied keys that are numbers, in the units that are shown."""
        return {key: _in_units(key, self.samples.column(key)) for key in self.samples.numeric}

    @cached_property
    def figures(self) -> dict[str, Floats]:
        """Mass and factors (n,), NaN where there is none."""
        return {name: _in_units(name, values) for name, values in self.samples.values.items()}


def _in_units(name: str, values: Floats) -> Floats:
    return in_unit(values, named(name)[1])


# More points than these are not told apart, and make a page slow.
_MOST_POINTS, _MOST_LINES = 2000, 500
_MOST_AXES = 6
# A mean over fewer rods than these shows their scatter rather than the effect of a key.
_BINS, _LEAST_IN_BIN = 8, 5
_WIDE = (60.0, 580.0, 300.0, 16.0)
_SMALL = (48.0, 230.0, 170.0, 8.0)


class Parallel(NamedTuple):
    """Parallel coordinates: place, anchor of the text, name and ends of each axis, a line for each design."""

    axes: tuple[tuple[float, str, str, str, str], ...]
    lines: tuple[tuple[str, int], ...]


def pareto(swept: Swept) -> Scatter | None:
    """Mass against the factor, with the front."""
    known = all(name in swept.figures for name in (MASS, FACTOR))
    if not known or not np.isfinite(swept.figures[FACTOR]).any():
        return None
    chosen = np.union1d(_some(swept, _MOST_POINTS), swept.samples.front).astype(int)
    left, right, bottom, top = _WIDE
    x = Axis(MASS, swept.figures[MASS][chosen], left, right)
    y = Axis(FACTOR, swept.figures[FACTOR][chosen], bottom, top)
    front = np.stack([swept.figures[name][swept.samples.front] for name in (MASS, FACTOR)], axis=1)
    return scatter(x, y, chosen, front)


def matrix(swept: Swept) -> list[Scatter]:
    """Every pair of the first keys, of mass and of the factor."""
    columns = _columns(swept)
    chosen, names = _some(swept, _MOST_LINES), list(columns)
    left, right, bottom, top = _SMALL
    if len(chosen) < 2:
        return []
    pairs = [(one, other) for k, other in enumerate(names) for one in names[:k]]
    return [
        scatter(
            Axis(one, columns[one][chosen], left, right),
            Axis(other, columns[other][chosen], bottom, top),
            chosen,
        )
        for one, other in pairs
    ]


def main_effects(swept: Swept) -> list[Scatter]:
    """The mean factor against each key: at each of its values, or over equal numbers of rods."""
    if FACTOR not in swept.figures:
        return []
    left, right, bottom, top = _SMALL
    known: Ints = np.flatnonzero(np.isfinite(swept.figures[FACTOR]))
    if not len(known):
        return []
    drawn = []
    for key, values in swept.keys.items():
        means = _means(values[known], swept.figures[FACTOR][known], alone=len(swept.keys) == 1)
        x, y = Axis(key, values[known], left, right), Axis(FACTOR, swept.figures[FACTOR][known], bottom, top)
        drawn.append(scatter(x, y, known, means))
    return drawn


def parallel(swept: Swept) -> Parallel | None:
    """A line for each design across its keys, mass and factor."""
    columns = _columns(swept)
    chosen = _some(swept, _MOST_LINES)
    if len(chosen) < 2:
        return None
    places = np.linspace(60.0, 940.0, len(columns))
    heights, axes = [], []
    for place, (name, values) in zip(places, columns.items(), strict=True):
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        heights.append(260 - 220 * (values[chosen] - low) / ((high - low) or 1.0))
        anchor = {60.0: "start", 940.0: "end"}.get(float(place), "middle")
        axes.append((round(float(place), 1), anchor, label(name), f"{low:.4g}", f"{high:.4g}"))
    lines = tuple(
        (" ".join(f"{x:.1f},{y:.1f}" for x, y in zip(places, row, strict=True)), int(n))
        for n, row in zip(chosen, np.array(heights).T, strict=True)
    )
    return Parallel(tuple(axes), lines)


def _columns(swept: Swept) -> dict[str, Floats]:
    outcome = {name: swept.figures[name] for name in (MASS, FACTOR) if name in swept.figures}
    keys = list(swept.keys.items())[: _MOST_AXES - len(outcome)]
    return dict(keys) | outcome


def _some(swept: Swept, most: int) -> Ints:
    known = np.flatnonzero(np.isfinite(swept.figures.get(FACTOR, np.full(len(swept.samples.rows), np.nan))))
    return np.asarray(known[np.linspace(0, len(known) - 1, min(len(known), most)).round().astype(int)])


def _means(x: Floats, y: Floats, *, alone: bool) -> Floats | None:
    """Return (m, 2) means of x and y; None for too few rods. `alone`: no other key varies."""
    distinct = np.unique(x)
    if alone or (len(distinct) <= _BINS and len(distinct) < len(x)):
        return np.array([(value, y[x == value].mean()) for value in distinct])
    bins = min(_BINS, len(x) // _LEAST_IN_BIN)
    if bins < 2:
        return None
    groups = np.array_split(np.argsort(x, kind="stable"), bins)
    return np.array([(x[group].mean(), y[group].mean()) for group in groups])


_COLUMNS = (
    ("first", "first-order index"), ("total", "total index"), ("regression", "standardised slope"),
)  # fmt: skip


def sweep_page(swept: Swept) -> str:
    """Return the report of a sweep as HTML."""
    factors = swept.figures.get("factor", ())
    # The studies, whose lines are mostly alike: each line once, and its numbers in each study.
    numbers: dict[str, int] = {}
    studies = [
        [numbers.setdefault(line, len(numbers)) for line in text.splitlines()] for text in swept.studies
    ]
    columns = {**swept.keys, **swept.figures}
    values = [
        {name: float(f"{column[n]:.6g}") for name, column in columns.items() if column[n] == column[n]}
        for n in range(len(swept.samples.rows))
    ]  # fmt: skip
    return html_page(
        "sweep_report",
        "sweep.html.jinja",
        page_file("report", "report.css") + page_file("sweep_report", "sweep.css"),
        page_file("sweep_report", "sweep.js"),
        swept=swept,
        columns=_COLUMNS,
        pareto=pareto(swept),
        matrix=matrix(swept),
        effects=main_effects(swept),
        parallel=parallel(swept),
        fails={n for n, factor in enumerate(factors) if factor < 1},
        data=embedded_json(
            {"rows": swept.samples.rows, "lines": list(numbers), "studies": studies, "values": values}
        ),
    )


# Designs that the page holds; beyond, evenly chosen ones.
_MOST = 1000


def report_sweep(path: Path, sweep: Sweep, journal: Journal) -> Statistics:
    """Write the report of a sweep, and return what it tells. Raises `StorageError`: it cannot be written."""
    samples = samples_of(journal.entries())
    figures = statistics(sweep, samples)
    known = np.flatnonzero(samples.complete)
    some = known[np.linspace(0, len(known) - 1, min(len(known), _MOST)).round().astype(int)]
    shown = samples.part(np.union1d(some, samples.front).astype(int).tolist())
    entries = [next(journal.entries(row)) for row in shown.rows]
    swept = Swept(
        title=sweep.name,
        counts=_counts(journal.counts(), samples, shown),
        samples=shown,
        studies=[sweep.base.study(entry.design, [entry.rpm]).text() for entry in entries],
        statistics=figures,
        failures=failures(journal.entries()),
    )
    write_text(path, sweep_page(swept))
    return figures


def _counts(counts: Mapping[State, int], samples: Samples, shown: Samples) -> str:
    states = ", ".join(f"{counts[state]} {state}" for state in State if counts[state])
    said = [f"Rows of the table: {states}."]
    if not len(shown.rows):
        return f"{said[0]} No rod has a result that can be trusted, so there is nothing to draw."
    if len(shown.rows) < len(samples.rows):
        said.append(f"{len(shown.rows)} of {len(samples.rows)} designs are drawn.")
    words = [key for key in samples.keys if any(isinstance(one[key], str | bool) for one in samples.designs)]
    if words:
        said.append(f"In the table alone, as they are not numbers: {', '.join(words)}.")
    return " ".join(said)
