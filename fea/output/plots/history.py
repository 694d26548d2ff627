"""Plot stress over crank angle at the worst places, with Pillow: matplotlib takes long to load."""

from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from fea.analysis.result import RunResult
from fea.base.units import DEG
from fea.output.pictures.scale import round_up
from fea.output.target import PictureError, reported
from fea.output.units import heading, place, scale
from geometry.arrays import Floats

_SIZE, _FINER = (1100, 660), 3  # pixels, and the factor of oversampling
_LEFT, _TOP, _RIGHT, _BOTTOM = 88, 132, 1078, 572  # of the panel
_TEXT, _SMALL, _TITLE = 14, 12, 17
_INK, _GREY, _GRID, _PAPER = "#1a1a1a", "#7a7a7a", "#e4e4e4", "white"
# Colours that can also be distinguished by people with colour blindness (Wong 2011).
_COLOURS = ("#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9")
_LAST = 720  # degrees
_STEPS = 7  # largest number of steps of the stress axis
_LEVEL = 16  # pixels between two rows of case names
_SIGN = (
    "sign: at the largest stress of a curve, + for tension and − for compression; elsewhere, the same sign "
    "if the deviatoric stress points the same way"
)


def plot_stress_history(path: Path, run: RunResult) -> None:
    """Draw the stress over the crank cycle at the most stressed places; errors as for `plot_histories`."""
    if run.cycle is None:
        raise ValueError("a stress history needs the crank cycle")
    loads = {name: case.load for name, case in run.cases.items()}
    plot_histories(
        path,
        run.summary.title,
        run.cycle.angles,
        [(spot.place.tolist(), spot.signed) for spot in run.cycle.spots],
        {name: float(load.crank_angle) for name, load in loads.items() if load.in_cycle},
    )


def plot_histories(
    path: Path,
    title: str,
    angles: Floats,
    histories: Sequence[tuple[Sequence[float], Floats]],
    marks: Mapping[str, float],
) -> None:
    """Draw one curve per place: (x, y, z), mm, and signed von Mises stress (n,), MPa, over (n,) angles, rad.

    `marks` are crank angles to mark, rad, by the name of their case. Raises `PictureError`: the file could
    not be written.
    """
    histories = [(at, scale("MPa") * np.asarray(signed)) for at, signed in histories]
    panel = _Panel(np.array([signed for _, signed in histories]))
    panel.text((_SIZE[0] / 2, 18), f"{title}: most stressed places", _TITLE, "mm")
    panel.axes()
    panel.mark({name: angle / DEG for name, angle in marks.items()})
    for number, (at, signed) in enumerate(histories):
        colour = _COLOURS[number % len(_COLOURS)]
        panel.curve(angles / DEG, signed, colour)
        panel.name(number, place(at).replace("-", "−"), colour)
    with reported(path, "Choose another directory.", kind=PictureError):
        panel.picture().save(path, format="PNG", compress_level=2)


class _Panel:
    """Axes for some curves of stress (n_curves, n), in the unit that is shown."""

    def __init__(self, stress: Floats) -> None:
        low, high = min(0.0, float(stress.min())), max(0.0, float(stress.max()))
        room = 0.05 * (high - low) or 1.0
        self._low, self._high = low - room, high + room
        self._image = Image.new("RGB", (_FINER * _SIZE[0], _FINER * _SIZE[1]), _PAPER)
        self._pen = ImageDraw.Draw(self._image)

    def picture(self) -> Image.Image:
        return self._image.reduce(_FINER)

    def axes(self) -> None:
        for degrees in range(0, _LAST + 1, 90):
            x = self._x(degrees)
            self._line([(x, _TOP), (x, _BOTTOM)], _GRID, 1)
            self._line([(x, _BOTTOM), (x, _BOTTOM + 5)], _INK, 1)
            self.text((x, _BOTTOM + 9), f"{degrees}", _TEXT, "ma")
        step = round_up((self._high - self._low) / _STEPS)
        for stress in (step * np.arange(np.ceil(self._low / step), self._high / step)).tolist():
            y = self._y(stress)
            self._line([(_LEFT, y), (_RIGHT, y)], _GREY if stress == 0 else _GRID, 1)
            self._line([(_LEFT - 5, y), (_LEFT, y)], _INK, 1)
            self.text((_LEFT - 9, y), f"{stress:g}".replace("-", "−"), _TEXT, "rm")
        corners = [(_LEFT, _TOP), (_RIGHT, _TOP), (_RIGHT, _BOTTOM), (_LEFT, _BOTTOM), (_LEFT, _TOP)]
        self._line(corners, _INK, 1)
        self.text(((_LEFT + _RIGHT) / 2, _BOTTOM + 42), "crank angle, ° (firing TDC at 360°)", _TEXT, "mm")
        self.text((_LEFT, _SIZE[1] - 20), _SIGN, _SMALL, "lm", _GREY)
        self._upwards(heading("signed von Mises stress", "MPa"))

    def mark(self, marks: Mapping[str, float]) -> None:
        """Mark crank angles, degrees, with names above the panel in as many rows as avoid overlaps."""
        ends: list[float] = []  # right end of the free space in each row
        for name, degrees in sorted(marks.items(), key=lambda item: -item[1]):
            x = self._x(degrees)
            width = _font(_SMALL).getlength(name) + 12
            level = next((row for row, end in enumerate(ends) if x + width < end), len(ends))
            top, fits = _TOP - 4 - _LEVEL * level, x + width < _SIZE[0]
            ends[: level + 1] = [x if fits else x - width] * (level + 1)
            for y in range(top - 8, _BOTTOM, 5):
                self._line([(x, y), (x, y + 2)], _GREY, 1)
            self.text((x + 4 if fits else x - 4, top), name, _SMALL, "ls" if fits else "rs", _GREY)

    def curve(self, degrees: Floats, stress: Floats, colour: str) -> None:
        """Draw stress over crank angles."""
        pairs = zip(degrees.tolist(), stress.tolist(), strict=True)
        self._line([(self._x(angle), self._y(value)) for angle, value in pairs], colour, 2)

    def name(self, number: int, label: str, colour: str) -> None:
        row, column = divmod(number, 3)
        x, y = _LEFT + 330 * column, 44 + 22 * row
        self._line([(x, y), (x + 28, y)], colour, 2)
        self.text((x + 36, y), label, _TEXT, "lm")

    def text(self, place: tuple[float, float], said: str, size: int, anchor: str, colour: str = _INK) -> None:
        """Write at a place in pixels, with an anchor of Pillow."""
        at = (_FINER * place[0], _FINER * place[1])
        self._pen.text(at, said, fill=colour, font=_font(_FINER * size), anchor=anchor)

    def _upwards(self, words: str) -> None:
        band = Image.new("RGB", (_FINER * (_BOTTOM - _TOP), _FINER * 24), _PAPER)
        middle = (band.width / 2, band.height / 2)
        ImageDraw.Draw(band).text(middle, words, fill=_INK, font=_font(_FINER * _TEXT), anchor="mm")
        self._image.paste(band.transpose(Image.Transpose.ROTATE_90), (_FINER * 6, _FINER * _TOP))

    def _line(self, points: Sequence[tuple[float, float]], colour: str, width: int) -> None:
        finer = [(_FINER * x, _FINER * y) for x, y in points]
        self._pen.line(finer, fill=colour, width=_FINER * width)

    def _x(self, degrees: float) -> float:
        return _LEFT + degrees / _LAST * (_RIGHT - _LEFT)

    def _y(self, stress: float) -> float:
        return _BOTTOM - (stress - self._low) / (self._high - self._low) * (_BOTTOM - _TOP)


def _font(size: int) -> ImageFont.FreeTypeFont:
    """Return the font that comes with matplotlib, without loading matplotlib."""
    library = find_spec("matplotlib")
    if library is None or library.origin is None:
        raise PictureError("no font was found, because matplotlib is not installed: pip install matplotlib.")
    fonts = Path(library.origin).parent / "mpl-data" / "fonts" / "ttf"
    return ImageFont.truetype(str(fonts / "DejaVuSans.ttf"), size)
