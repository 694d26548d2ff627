"""A page of an animation: the picture of the engine, the legend and the figures of the instant."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from fea.output.pictures.bands import Bands
from fea.output.pictures.strokes import INK, PAPER

MARGIN, BAR, LINE = 16, 24, 24  # pixels
FAINT = "#606060"  # pale but legible
COLUMN = 224  # width of the text beside the picture


@dataclass(frozen=True)
class Page:
    """The content that is the same on every page.

    Attributes
    ----------
    title
        Lines at the top.
    peak
        Largest von Mises stress of the whole cycle, MPa, so that the colours are the same on every page.
    factor
        Magnification of the displacements.
    size
        Width and height of the picture, pixels.
    """

    title: Sequence[str]
    peak: float
    factor: float
    size: tuple[int, int]

    def drawn(self, image: npt.NDArray[np.uint8], crank_deg: float, stress: float) -> Image.Image:
        """Return a page.

        Parameters
        ----------
        image
            (height, width, 3) the engine.
        crank_deg
            Crank angle, degrees.
        stress
            Largest von Mises stress at this instant, MPa.
        """
        page = self._blank.copy()
        page.paste(Image.fromarray(image), (0, 0))
        pen, left = ImageDraw.Draw(page), self.size[0]
        top = MARGIN + (len(self.title) + 1) * LINE
        self._write(pen, (left, top), f"crank angle {crank_deg:.0f}°", 20)
        self._write(pen, (left, top + LINE), f"largest stress {stress:.0f} MPa", 15)
        return page

    @cached_property
    def _blank(self) -> Image.Image:
        width, height = self.size
        page = Image.new("RGB", (width + COLUMN, height), PAPER)
        pen = ImageDraw.Draw(page)
        for number, line in enumerate(self.title):
            self._write(pen, (width, MARGIN + number * LINE), line, 18 if number == 0 else 16)
        bands = Bands.up_to(self.peak)
        limits, colours = bands.limits, bands.colours
        top = height // 2 - len(colours) * BAR // 2 + LINE
        self._write(pen, (width, top - 1.6 * LINE), "von Mises stress, MPa", 16)
        bottom = top + len(colours) * BAR
        for number, colour in enumerate(colours):
            low = bottom - number * BAR
            pen.rectangle((width, low - BAR, width + 2 * BAR, low), fill=tuple(colour.tolist()), outline=INK)
        for number, limit in enumerate(limits):
            self._write(pen, (width + 2.4 * BAR, bottom - number * BAR - 9), f"{limit:g}", 15)
        notes = [f"displacement × {self.factor:g}", "grey: crank-pin circle,", "cylinder axis"]
        for number, line in enumerate(notes):
            self._write(pen, (width, height - MARGIN - (len(notes) - number) * LINE), line, 14)
        return page

    @staticmethod
    def _write(pen: ImageDraw.ImageDraw, place: tuple[float, float], text: str, size: int) -> None:
        font = ImageFont.truetype(str(Path(mpl.get_data_path(), "fonts", "ttf", "DejaVuSans.ttf")), size)
        pen.text(place, text, fill=INK if size > 14 else FAINT, font=font)
