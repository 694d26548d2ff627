"""The drawings of a sweep."""

from dataclasses import dataclass

import numpy as np

from fea.output.sweep_report.labels import label
from fea.output.sweep_report.scatter import Axis, Scatter, scatter
from fea.output.sweep_report.swept import Swept
from geometry.arrays import Floats, Ints

# More points than these are not told apart, and make a page slow.
_MOST_POINTS, _MOST_LINES = 2000, 500
_MOST_AXES = 6
# A mean over fewer rods than these shows their scatter rather than the effect of a key.
_BINS, _LEAST_IN_BIN = 8, 5
_WIDE = (60.0, 580.0, 300.0, 16.0)
_SMALL = (48.0, 230.0, 170.0, 8.0)
FACTOR, MASS = "factor", "mass_kg"


@dataclass(frozen=True)
class Parallel:
    """Parallel coordinates: place, anchor of the text, name and ends of each axis, a line for each design."""

    axes: tuple[tuple[float, str, str, str, str], ...]
    lines: tuple[tuple[str, int], ...]


def pareto(swept: Swept) -> Scatter | None:
    """Mass against the factor, with the front."""
    known = all(name in swept.figures for name in (MASS, FACTOR))
    if not known or not np.isfinite(swept.figures[FACTOR]).any():
        return None
    chosen = np.union1d(_some(swept, _MOST_POINTS), swept.front).astype(int)
    left, right, bottom, top = _WIDE
    x = Axis(MASS, swept.figures[MASS][chosen], left, right)
    y = Axis(FACTOR, swept.figures[FACTOR][chosen], bottom, top)
    front = np.stack([swept.figures[name][swept.front] for name in (MASS, FACTOR)], axis=1)
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
    """Numbers of designs with results, evenly chosen where there are many."""
    known = np.flatnonzero(np.isfinite(swept.figures.get(FACTOR, np.full(len(swept.rows), np.nan))))
    if len(known) <= most:
        return known
    return np.asarray(known[np.linspace(0, len(known) - 1, most).round().astype(int)])


def _means(x: Floats, y: Floats, *, alone: bool) -> Floats | None:
    """Return (m, 2) means of x and y; None where there are too few rods for them.

    `alone` says that no other key varies.
    """
    distinct = np.unique(x)
    if alone or (len(distinct) <= _BINS and len(distinct) < len(x)):
        return np.array([(value, y[x == value].mean()) for value in distinct])
    bins = min(_BINS, len(x) // _LEAST_IN_BIN)
    if bins < 2:
        return None
    groups = np.array_split(np.argsort(x, kind="stable"), bins)
    return np.array([(x[group].mean(), y[group].mean()) for group in groups])
