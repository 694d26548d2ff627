"""Draw an animation: a page for each instant, and the file of all."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
import pyvista
from PIL import Image, ImageDraw, ImageFont

from fea.base.units import DEG
from fea.output.pictures import strokes
from fea.output.pictures.drawing import SCALARS, add_surface, surface_of
from fea.output.pictures.scale import Bands
from fea.output.pictures.strokes import GREY, INK, PAPER, CameraFrame, View, add_lines, oversampled
from fea.output.pictures.surface import CycleAnimation

MARGIN, BAR, LINE = 16, 24, 24  # pixels
FAINT = "#606060"  # pale but legible
COLUMN = 224  # width of the text beside the picture


@dataclass(frozen=True)
class _Page:
    """The content that is the same on every page.

    `peak` is the largest von Mises stress of the whole cycle, in the `unit` of stress, so that colours mean
    the same everywhere; `factor` magnifies the displacements; `size` is that of the picture, pixels.
    """

    title: Sequence[str]
    peak: float
    factor: float
    size: tuple[int, int]
    unit: str = "MPa"

    def drawn(self, image: npt.NDArray[np.uint8], crank_deg: float, stress: float) -> Image.Image:
        """Return the page of an image (height, width, 3) with crank angle and largest stress."""
        page = self._blank.copy()
        page.paste(Image.fromarray(image), (0, 0))
        pen, left = ImageDraw.Draw(page), self.size[0]
        top = MARGIN + (len(self.title) + 1) * LINE
        self._write(pen, (left, top), f"crank angle {crank_deg:.0f}°", 20)
        self._write(pen, (left, top + LINE), f"largest stress {stress:.0f} {self.unit}", 15)
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
        self._write(pen, (width, top - 1.6 * LINE), f"von Mises stress, {self.unit}", 16)
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


FRAMES_PER_SECOND = 20
SIZE = (384, 608)  # pixels of the engine's part of the page; sides of a film are multiples of 16
PIECES = 2  # per side of a facet: a page is a quarter of the size of a picture
# Seen from the front and slightly from the side, with the cylinder upright.
TOWARDS = np.array([0.12, -0.24, 0.96])


def images(film: CycleAnimation) -> Iterator[npt.NDArray[np.uint8]]:
    """Draw the engine for every page, (height, width, 3)."""
    plotter = pyvista.Plotter(off_screen=True, window_size=oversampled(SIZE), lighting="none", border=False)
    plotter.set_background(PAPER)
    surface = surface_of(film.skin, film.deformed(0), film.von_mises[0].astype(float))
    rod = add_surface(plotter, surface, Bands.up_to(float(film.von_mises.max())))
    crank = _add_engine(plotter, film)
    _frame(film).aim(plotter)
    plotter.disable_anti_aliasing()
    for k in range(len(film.crank_angle)):
        surface.points = film.skin.refined(film.deformed(k))
        surface.point_data[SCALARS] = film.skin.refined(film.von_mises[k].astype(float))
        rod.user_matrix = film.placement(k)
        angle = film.crank_angle[k]
        turned = np.eye(4)
        turned[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        crank.user_matrix = turned
        plotter.renderer.ResetCameraClippingRange()
        image = np.asarray(strokes.photograph(plotter))
        strokes.require_rod(image)
        yield image
    plotter.close()


def _add_engine(plotter: Any, film: CycleAnimation) -> Any:
    r, offset = film.crank_radius, film.pin_offset
    axis = pyvista.Line((-r, offset, 0), (r + film.skin.points[:, 0].max(), offset, 0))
    plotter.add_mesh(axis, color=GREY, line_width=2, lighting=False)
    angle = np.linspace(0, 2 * np.pi, 91)
    circle = r * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    add_lines(plotter, circle[None], GREY, 1)
    return plotter.add_mesh(pyvista.Line((0, 0, 0), (r, 0, 0)), color=INK, line_width=6, lighting=False)


def _frame(film: CycleAnimation) -> CameraFrame:
    towards = TOWARDS / np.linalg.norm(TOWARDS)
    up = np.array([1.0, 0, 0]) - towards[0] * towards
    up /= np.linalg.norm(up)
    some = slice(None, None, max(1, len(film.skin.points) // 2000))
    swept = []
    for k in range(len(film.crank_angle)):
        placed = film.placement(k)
        swept.append(film.deformed(k)[some] @ placed[:3, :3].T + placed[:3, 3])
    view = View(towards, np.cross(up, towards), up)
    return CameraFrame.around(np.concatenate(swept), view, SIZE[0] / SIZE[1], width=0.94, height=0.94)


def write_gif(path: Path, pages: list[Image.Image]) -> None:
    """Write pages as a GIF that repeats forever, with one palette, so that nothing flickers."""
    few = pages[:: max(1, len(pages) // 8)]
    width, height = pages[0].size
    montage = Image.new("RGB", (width, height * len(few)))
    for number, page in enumerate(few):
        montage.paste(page, (0, number * height))
    palette = montage.quantize(255, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    indexed = [page.quantize(palette=palette, dither=Image.Dither.NONE) for page in pages]
    first, *rest = indexed
    lasting = 1000 // FRAMES_PER_SECOND
    first.save(path, save_all=True, append_images=rest, duration=lasting, loop=0, optimize=False)


def write_mp4(path: Path, pages: list[Image.Image]) -> None:
    """Write pages as an H.264 video."""
    import imageio_ffmpeg  # noqa: PLC0415 - an extra

    writer = imageio_ffmpeg.write_frames(
        str(path), pages[0].size, fps=FRAMES_PER_SECOND, quality=7, ffmpeg_log_level="error"
    )
    writer.send(None)
    for page in pages:
        writer.send(page.tobytes())
    writer.close()


def draw_film(film: CycleAnimation, target: Path) -> None:
    """Draw an animation and write its file, a .gif or .mp4."""
    film = replace(film, skin=replace(film.skin, pieces=PIECES))
    page = _Page(film.title, float(film.von_mises.max()), film.exaggeration, SIZE, film.unit)
    stress = film.von_mises.max(axis=1)
    pages = [
        page.drawn(image, film.crank_angle[k] / DEG, float(stress[k])) for k, image in enumerate(images(film))
    ]
    (write_gif if target.suffix == ".gif" else write_mp4)(target, pages)
