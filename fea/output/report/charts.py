"""Line charts over the crank angle as SVG, in colours that the page sets."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fea.output.pictures.scale import round_up
from fea.output.units import scale, unit
from geometry.arrays import Floats

# Of the drawing, which is scaled to the width of the page.
WIDTH, HEIGHT = 600, 230
LEFT, RIGHT, TOP, BOTTOM = 58, 590, 26, 198
LAST = 720
_STEPS = 5
_EVERY = 2  # degrees from one corner of a line to the next
_DEAD_CENTRES = ((0, "TDC", "start"), (180, "BDC", "middle"), (360, "firing TDC", "middle"),
                 (540, "BDC", "middle"), (720, "TDC", "end"))  # fmt: skip


@dataclass(frozen=True)
class Chart:
    """A chart for the template."""

    #: id, title, unit: its name on the page, what is drawn, and in which unit
    id: str
    title: str
    unit: str
    description: str  #: in words, for who does not see it
    names: tuple[str, ...]  #: of the lines; empty where there is one that needs no name
    lines: tuple[str, ...]  #: the points of each line as SVG has them
    ticks: tuple[tuple[float, str], ...]  #: height and label of the horizontal lines
    angles: tuple[tuple[float, str], ...]  #: place and label of the ticks of the crank angle
    #: Place, row and name of the load cases; TDC and BDC: place, name and anchor
    marks: tuple[tuple[float, int, str], ...]
    centres: tuple[tuple[float, str, str], ...]  #: dead centres: place, name and how it is aligned
    series: tuple[tuple[float, ...], ...]  #: (n_lines, 721) values at every degree, for the slider

    @property
    def zero(self) -> float | None:
        """Height of the line of zero."""
        return next((y for y, label in self.ticks if label == "0"), None)

    def moving(self) -> dict[str, Any]:
        """What the page needs to show the crank angle of the slider."""
        return {
            "id": self.id,
            "left": LEFT,
            "width": RIGHT - LEFT,
            "unit": self.unit,
            "series": [list(values) for values in self.series],
        }


class Heading(NamedTuple):
    """The id of a chart on the page, its title and its unit."""

    id: str
    title: str
    unit: str


def chart(
    heading: Heading, degrees: Floats, curves: Mapping[str, Floats], marks: Mapping[str, float]
) -> Chart:
    """Draw curves (n,), by name and in the unit of the heading, over crank angles (n,) in degrees.

    The marks are the angles of the load cases, by their names. A single curve needs no name (``""``).
    """
    curves = {name: scale(heading.unit) * np.asarray(curve, float) for name, curve in curves.items()}
    heading = heading._replace(unit=unit(heading.unit))
    values = np.stack(list(curves.values()))
    low, high = min(0.0, float(values.min())), max(0.0, float(values.max()))
    step = round_up((high - low or 1.0) / _STEPS)
    first, last = int(np.floor(low / step + 1e-9)), int(np.ceil(high / step - 1e-9))
    bottom, top = step * first, step * max(last, first + 1)

    def x(angle: float) -> float:
        return round(LEFT + (RIGHT - LEFT) * angle / LAST, 1)

    def y(value: float) -> float:
        return round(BOTTOM - (BOTTOM - TOP) * (value - bottom) / (top - bottom), 1)

    some = slice(None, None, _EVERY)
    return Chart(
        id=heading.id,
        title=heading.title,
        unit=heading.unit,
        description=_described(degrees, curves, heading.unit),
        names=tuple(key for key in curves if key),
        lines=tuple(
            " ".join(f"{x(a):g},{y(v):g}" for a, v in zip(degrees[some], row[some], strict=True))
            for row in values
        ),
        ticks=tuple(
            (y(step * k), f"{step * k:.6g}".replace("-", "−")) for k in range(first, max(last, first + 1) + 1)
        ),
        angles=tuple((x(angle), f"{angle}°") for angle in range(0, LAST + 1, 90)),
        marks=_marks({case: x(angle) for case, angle in marks.items()}),
        centres=tuple((x(angle), label, anchor) for angle, label, anchor in _DEAD_CENTRES),
        series=tuple(tuple(float(f"{value:.4g}") for value in row) for row in values),
    )


def _described(degrees: Floats, curves: Mapping[str, Floats], unit: str) -> str:
    said = []
    for name, curve in curves.items():
        ends = [(float(curve[k]), float(degrees[k])) for k in (int(np.argmin(curve)), int(np.argmax(curve)))]
        low, high = (f"{value:.4g} {unit} at {angle:.0f}°" for value, angle in ends)
        said.append(f"{f'{name}: ' if name else ''}from {low} to {high}".replace("-", "−"))
    return "; ".join(said)


def _marks(places: Mapping[str, float]) -> tuple[tuple[float, int, str], ...]:
    """Marks in rows, so that the names of neighbours do not touch."""
    ends: list[float] = []
    found = []
    for name, place in sorted(places.items(), key=lambda item: item[1]):
        half = 3.1 * len(name)
        row = next((k for k, end in enumerate(ends) if place - half > end), len(ends))
        ends[row : row + 1] = [place + half + 4]
        found.append((place, row, name))
    return tuple(found)


def force_charts(forces: Mapping[str, Any], marks: Mapping[str, float]) -> list[Chart]:
    """Return the charts of the forces over the cycle, from the columns of ``loads.csv``."""
    degrees = np.asarray(forces["crank_deg"], float)
    kilo = {name: 1e-3 * np.asarray(forces[name], float) for name in forces if name.endswith("_N")}
    drawn: Sequence[tuple[Heading, dict[str, Floats]]] = (
        (Heading("chart-axial", "Force along the rod (tension positive)", "kN"),
         {"piston pin": kilo["pin_axial_N"], "crank pin": kilo["crank_axial_N"]}),
        (Heading("chart-transverse", "Force across the rod", "kN"),
         {"piston pin": kilo["pin_transverse_N"], "crank pin": kilo["crank_transverse_N"]}),
        (Heading("chart-gas", "Gas force and side force on the piston", "kN"),
         {"gas": kilo["gas_N"], "cylinder wall": kilo["wall_N"]}),
        (Heading("chart-torque", "Torque on the crank", "N·m"), {"": np.asarray(forces["torque_Nm"], float)}),
    )  # fmt: skip
    return [chart(heading, degrees, curves, marks) for heading, curves in drawn]
