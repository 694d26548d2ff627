"""Points in a plane as SVG: for the Pareto front, a matrix of scatters, and main effects."""

from dataclasses import dataclass

import numpy as np

from fea.output.pictures.scale import round_up
from fea.output.sweep_report.labels import label
from geometry.arrays import Floats, Ints

_STEPS = 4


@dataclass(frozen=True)
class Scatter:
    """A drawing for the template.

    Attributes
    ----------
    x, y
        What the axes show.
    points
        Place of each point and the number of its design.
    line
        Points of a line; empty where there is none.
    x_ticks, y_ticks
        Place and label.
    limit
        Height of the line factor = 1; None where it is not in the picture.
    size
        Width and height.
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
    """Draw points.

    Parameters
    ----------
    x, y
        With (n,) values, NaN where there is none.
    numbers
        (n,) of the designs.
    line
        (m, 2) of a line.
    """
    known = np.flatnonzero(np.isfinite(x.values) & np.isfinite(y.values))
    points = tuple((x.place(x.values[n]), y.place(y.values[n]), int(numbers[n])) for n in known)
    low, high = y.bounds
    path = "" if line is None else " ".join(f"{x.place(a):g},{y.place(b):g}" for a, b in line)
    limit = y.place(1.0) if y.name.endswith("factor") and low < 1 < high else None
    size = (max(x.first, x.last), max(y.first, y.last))
    return Scatter(label(x.name), label(y.name), points, path, x.ticks, y.ticks, limit, size)
