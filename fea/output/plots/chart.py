"""Charts over the crank cycle: one layout, drawn by the report in SVG and here, with Pillow, as a picture.

matplotlib takes long to load.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from fea.analysis.result import RunResult
from fea.base.units import DEG
from fea.output.folder import PictureError, reported
from fea.output.json_file import JsonObject
from fea.output.life_tables import lettered
from fea.output.pictures.scale import round_up
from fea.output.plots.figure import crank_angle
from fea.output.units import place, scale, unit
from geometry.arrays import Floats

# Of the drawing, which is scaled to the width of the page or picture.
WIDTH, HEIGHT = 600, 230
LEFT, RIGHT, TOP, BOTTOM = 58, 590, 26, 198
LEVEL = 11  # between two rows of the names of load cases
_STEPS = 5
_EVERY = 3  # degrees from one corner of a line to the next
_LETTER = 6.2  # width of a letter of these names, with some to spare
# What rounding leaves of a force that is zero, kN or N·m: no engine has forces of a micronewton.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Chart:
    """A chart; places are those of the drawing."""

    #: id, title, unit: its name on the page, what is drawn, and in which unit
    id: str
    title: str
    unit: str
    description: str  #: in words, for those who do not see it
    names: tuple[str, ...]  #: of the curves; empty where there is one that needs no name
    curves: tuple[tuple[tuple[float, float], ...], ...]  #: the corners of each curve
    ticks: tuple[tuple[float, str], ...]  #: height and label of the horizontal lines
    #: Place, row and name of each load case, and whether the name fits on the right of its line
    marks: tuple[tuple[float, int, str, bool], ...]
    series: tuple[tuple[float, ...], ...]  #: (n_curves, last + 1) values at every degree, for the slider
    last: int = 720  #: crank angle at which the cycle ends, degrees; 360 of a two-stroke engine
    times: tuple[tuple[float, str], ...] = ()  #: places and labels of the vertical lines, not of crank angles

    @property
    def lines(self) -> list[str]:
        """The curves as SVG has them."""
        return [" ".join(f"{x:g},{y:g}" for x, y in curve) for curve in self.curves]

    @property
    def grid(self) -> list[tuple[float, str]]:
        """Places and labels of the vertical lines: crank angles, or times."""
        angles = range(0, self.last + 1, self.last // 8)
        return list(self.times) or [(across(angle, self.last), f"{angle}°") for angle in angles]

    @property
    def centres(self) -> list[tuple[float, str]]:
        """Places and names of the dead centres."""
        if self.times:
            return []
        names = ["TDC", "BDC", "firing TDC", "BDC", "TDC"] if self.last > 360 else ["firing TDC", "BDC"] * 2
        return [(across(180 * k, self.last), name) for k, name in enumerate(names[: self.last // 180 + 1])]

    def moving(self) -> JsonObject:
        """Return the data with which the page shows the crank angle of the slider."""
        series = [list(values) for values in self.series]
        return {
            "id": self.id,
            "left": LEFT,
            "width": RIGHT - LEFT,
            "unit": self.unit,
            "series": series,
            "last": self.last,
        }


def chart(
    heading: tuple[str, str, str], degrees: Floats, curves: Mapping[str, Floats], marks: Mapping[str, float]
) -> Chart:
    """Lay out curves (n,), by name and in the unit of the heading, over crank angles (n,) in degrees.

    The heading is the id of the chart on the page, its title and that unit. The marks are the angles of the
    load cases, by their names. A single curve needs no name (``""``).
    """
    (ident, title, given), end = heading, round(float(degrees[-1]))
    values = scale(given) * np.stack(list(curves.values()))
    values[np.abs(values) < _ROUNDING * scale(given)] = 0.0
    low, high = min(0.0, float(values.min())), max(0.0, float(values.max()))
    step = round_up((high - low or 1.0) / _STEPS)
    first, last = int(np.floor(low / step + 1e-9)), int(np.ceil(high / step - 1e-9))
    last = max(last, first + 1)

    def height(value: float) -> float:
        return round(BOTTOM - (BOTTOM - TOP) * (value / step - first) / (last - first), 1)

    corners = [
        tuple((across(a, end), height(v)) for a, v in zip(degrees[::_EVERY], row[::_EVERY], strict=True))
        for row in values
    ]
    return Chart(
        id=ident,
        title=title,
        unit=unit(given),
        description=_described(degrees, dict(zip(curves, values, strict=True)), unit(given)),
        names=tuple(name for name in curves if name),
        curves=tuple(corners),
        ticks=tuple((height(step * k), f"{step * k:.6g}".replace("-", "−")) for k in range(first, last + 1)),
        marks=_marks({case: across(angle, end) for case, angle in marks.items()}),
        series=tuple(tuple(float(f"{value:.4g}") for value in row) for row in values),
        last=end,
    )


def log_chart(heading: tuple[str, str, str], times: Floats, values: Floats) -> Chart:
    """Lay out a curve (n,), in the unit of the heading, over the times of a log, s, evenly spaced."""
    drawn = chart(heading, np.linspace(0.0, 720.0, _EVERY * len(times)), {"": np.repeat(values, _EVERY)}, {})
    step = round_up((span := float(times[-1] - times[0])) / _STEPS)
    labels = np.arange(np.ceil(times[0] / step), np.floor(times[-1] / step) + 1) * step
    places = tuple((across(720 * (at - times[0]) / span), f"{at:g} s") for at in labels.tolist())
    return replace(drawn, times=places, series=(), description=f"most at {times[values.argmax()]:.4g} s")


def across(degrees: float, last: int = 720) -> float:
    """Return the place of a crank angle in a cycle that ends at the last one."""
    return round(LEFT + (RIGHT - LEFT) * degrees / last, 1)


def _described(degrees: Floats, curves: Mapping[str, Floats], name: str) -> str:
    texts = []
    for words, curve in curves.items():
        ends = (int(curve.argmin()), int(curve.argmax()))
        low, high = (f"{curve[k]:.4g} {name} at {degrees[k]:.0f}°" for k in ends)
        texts.append(f"{f'{words}: ' if words else ''}from {low} to {high}".replace("-", "−"))
    return "; ".join(texts)


def _marks(places: Mapping[str, float]) -> tuple[tuple[float, int, str, bool], ...]:
    """Put names beside their lines, in as many rows as keep them off each other and off other lines."""
    ends: list[float] = []  # right end of the free space in each row
    marks = []
    for name, x in sorted(places.items(), key=lambda item: -item[1]):
        width = _LETTER * len(name) + 6
        row = next((k for k, end in enumerate(ends) if x + width < end), len(ends))
        fits = x + width < WIDTH
        ends[: row + 1] = [x if fits else x - width] * (row + 1)
        marks.append((x, row, name, fits))
    return tuple(marks)


_SCALE, _FINER = 11 / 6, 3  # pixels of the picture, and the factor of oversampling
_TEXT, _SMALL, _TITLE = 14, 12, 17
_INK, _GREY, _GRID, _PAPER = "#1a1a1a", "#7a7a7a", "#e4e4e4", "white"
# Colours that can also be distinguished by people with colour blindness (Wong 2011).
COLOURS = ("#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9")
_SIGN = (
    "sign: at the largest stress of a curve, + for tension and − for compression; elsewhere, the same sign "
    "if the deviatoric stress points the same way"
)


def plot_stress_history(path: Path, run: RunResult) -> None:
    """Draw the signed von Mises stress over the crank cycle at the most stressed places.

    Raises `ValueError`: the run has no cycle; `PictureError`: the file could not be written.
    """
    if run.cycle is None:
        raise ValueError("a stress history needs the crank cycle")
    spots, loads = run.cycle.spots, {name: case.load for name, case in run.cases.items()}
    letters = zip(lettered(len(spots)), spots, strict=True)
    curves = {f"{name} {place(spot.place.tolist())}".replace("-", "−"): spot.signed for name, spot in letters}
    marks = {name: float(load.crank_angle) / DEG for name, load in loads.items() if load.in_cycle}
    title = f"{run.summary.title}: signed von Mises stress at the most stressed places"
    save_picture(path, chart(("history", title, "MPa"), run.cycle.angles / DEG, curves, marks), _SIGN)


def save_picture(path: Path, drawn: Chart, remark: str) -> None:
    """Draw a chart into a file; raises `PictureError`: it could not be written."""
    with reported(path, "Choose another directory.", kind=PictureError):
        _picture(drawn, remark).save(path, format="PNG", compress_level=2)


def _picture(drawn: Chart, remark: str) -> Image.Image:
    """Draw a chart with its title and the names of its curves above it, and a remark below."""
    above = TOP + LEVEL * (1 + -(-len(drawn.names) // 3))
    pixel = _FINER * _SCALE
    size = (round(pixel * WIDTH), round(pixel * (above + HEIGHT + TOP)))
    image = Image.new("RGB", size, _PAPER)
    pen = ImageDraw.Draw(image)

    def line(points: Sequence[tuple[float, float]], colour: str, width: int = 1) -> None:
        pen.line([(pixel * x, pixel * (y + above)) for x, y in points], fill=colour, width=_FINER * width)

    def text(x: float, y: float, words: str, anchor: str, size: int = _TEXT) -> None:
        at, colour = (pixel * x, pixel * (y + above)), _GREY if size == _SMALL else _INK
        pen.text(at, words, fill=colour, font=font(_FINER * size), anchor=anchor)

    text(WIDTH / 2, LEVEL - above, f"{drawn.title}, {drawn.unit}", "mm", _TITLE)
    for x, degrees in drawn.grid:
        line([(x, TOP), (x, BOTTOM)], _GRID)
        text(x, BOTTOM + 5, degrees.rstrip("°"), "ma")
    for y, label in drawn.ticks:
        line([(LEFT, y), (RIGHT, y)], _GREY if label == "0" else _GRID)
        text(LEFT - 5, y, label, "rm")
    line([(LEFT, TOP), (RIGHT, TOP), (RIGHT, BOTTOM), (LEFT, BOTTOM), (LEFT, TOP)], _INK)
    text((LEFT + RIGHT) / 2, BOTTOM + 24, crank_angle(drawn.last), "mm")
    text(LEFT, BOTTOM + 46, remark, "lm", _SMALL)
    for x, row, name, fits in drawn.marks:
        top = TOP - 2 - LEVEL * row
        for y in np.arange(top - LEVEL / 2, BOTTOM, 3.0).tolist():
            line([(x, y), (x, y + 1)], _GREY)
        text(x + 2 if fits else x - 2, top, name, "ls" if fits else "rs", _SMALL)
    for k, curve in enumerate(drawn.curves):
        line(curve, COLOURS[k % len(COLOURS)], 2)
    for k, name in enumerate(drawn.names):
        x, y = LEFT + 180 * (k % 3), LEVEL * (2 + k // 3) - above
        line([(x, y), (x + 15, y)], COLOURS[k % len(COLOURS)], 2)
        text(x + 20, y, name, "lm")
    return image.reduce(_FINER)


def font(size: int) -> ImageFont.FreeTypeFont:
    """Return the font that comes with matplotlib, without loading matplotlib."""
    library = find_spec("matplotlib")
    if library is None or library.origin is None:
        raise PictureError("no font was found, because matplotlib is not installed: pip install matplotlib.")
    fonts = Path(library.origin).parent / "mpl-data" / "fonts" / "ttf"
    return ImageFont.truetype(str(fonts / "DejaVuSans.ttf"), size)
