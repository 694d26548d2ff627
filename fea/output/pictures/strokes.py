"""The components of every picture: lines, text, a canvas, a file."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyvista
from PIL import Image

from fea.output.pictures.frame import Frame
from fea.output.pictures.surface import DrawnSurface, refined_line
from geometry.arrays import Floats

SIZE = (1600, 1000)  # pixels
# Everything is drawn this many times larger and then reduced, which leaves no jagged edges: where a processor
# draws, this takes half as long as VTK's own anti-aliasing.
OVERSAMPLED = 2
INK, GREY, PAPER = "#1a1a1a", "#a0a0a0", "white"
SHADING = {"ambient": 0.5, "diffuse": 0.52, "specular": 0.0, "culling": "back"}


def canvas(
    rows: tuple[float, ...],
    columns: tuple[float, ...],
    *,
    joined: tuple[int, ...] = (),
    axes: tuple[int, ...] = (),
) -> Any:
    """Return an empty plotter without a window; pictures of one layout share it, which saves time.

    `rows` and `columns` are fractions of its height and width, `joined` the rows that are one part, and
    `axes` those whose first part shows the directions of the axes.
    """
    plotter = _plotter(rows, columns, joined, axes)
    plotter.clear()
    return plotter


@cache
def _plotter(
    rows: tuple[float, ...], columns: tuple[float, ...], joined: tuple[int, ...], axes: tuple[int, ...]
) -> Any:
    plotter = pyvista.Plotter(
        off_screen=True,
        window_size=oversampled(SIZE),
        shape=(len(rows), len(columns)),
        row_weights=rows,
        col_weights=columns,
        groups=[(row, slice(None)) for row in joined] or None,
        border=False,
        lighting="none",
    )
    plotter.disable_anti_aliasing()
    plotter.set_background(PAPER)
    for row in axes:  # VTK would crash if they were made again for each picture
        plotter.subplot(row, 0)
        plotter.add_axes(line_width=3 * OVERSAMPLED, color=INK, viewport=(0.0, 0.0, 0.1, 0.24))
    return plotter


def oversampled(size: tuple[int, int]) -> tuple[int, int]:
    """Return the size of the window for a picture of this width and height."""
    return OVERSAMPLED * size[0], OVERSAMPLED * size[1]


def photograph(plotter: Any) -> Image.Image:
    """Render a plotter whose window is `oversampled` and return the picture."""
    plotter.suppress_rendering = False
    plotter.render()
    image = Image.fromarray(plotter.screenshot(return_img=True)).reduce(OVERSAMPLED)
    plotter.suppress_rendering = True  # each mesh that is added would render
    return image


def finish(plotter: Any, share: float) -> Image.Image:
    """Render a plotter of `canvas`, whose upper `share` shows a rod below a title, and return the picture.

    Raises `RuntimeError`: the picture is blank: some OpenGL libraries fail without an error.
    """
    image = photograph(plotter)
    require_rod(np.asarray(image)[int(0.1 * share * SIZE[1]) : int(share * SIZE[1])])
    return image


def save(image: Image.Image, png: Path) -> None:
    """Write a picture with a palette of 256 colours: a third of the size without a visible difference."""
    few = image.quantize(256, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    few.putpalette([255 if level > 250 else level for level in few.getpalette() or []])  # white stays white
    few.save(png, format="PNG", compress_level=4)  # twice as fast as 6, and a twentieth larger


def require_rod(image: npt.NDArray[np.uint8]) -> None:
    """Raise RuntimeError if an image (height, width, 3) is (almost) completely white."""
    if np.mean(image[::4, ::4].min(axis=2) < 235) < 0.02:
        raise RuntimeError("the picture is blank")


def add_edges(plotter: Any, skin: DrawnSurface, points: Floats, frame: Frame, pen: tuple[str, float]) -> None:
    """Draw the edges of the shape (not of the elements), with its nodes at `points`."""
    sides, sharp = skin.sides
    add_lines(plotter, refined_line(points, sides[sharp]) + frame.nudge, *pen)


def add_lines(plotter: Any, lines: Floats, colour: str, width: float, opacity: float = 1.0) -> None:
    """Draw lines through (n_lines, n_points, 3)."""
    if len(lines) == 0:
        return
    count, length, _ = lines.shape
    cells = np.column_stack([np.full(count, length), np.arange(count * length).reshape(count, length)])
    drawn = pyvista.PolyData(lines.reshape(-1, 3), lines=cells.ravel())
    plotter.add_mesh(drawn, color=colour, line_width=OVERSAMPLED * width, opacity=opacity, lighting=False)


def write(
    plotter: Any,
    text: str,
    place: tuple[float, float],
    size: int,
    *,
    centred: bool = False,
    ground: float = 0.0,
) -> None:
    """Write at a place given as fractions of the active frame's width and height.

    `size` is in pixels; `ground` is the opacity of the background of the text, 0 to 1.
    """
    actor = plotter.add_text(text, position=place, viewport=True, color=INK, font="arial")
    actor.prop.font_size = OVERSAMPLED * size
    if centred:
        actor.prop.justification_horizontal = "center"
    actor.prop.background_color = PAPER
    actor.prop.background_opacity = ground


def is_complete_png(path: Path) -> bool:
    """Return whether `path` is a PNG with every chunk intact and more than one colour in it."""
    try:
        with Image.open(path, formats=["PNG"]) as image:
            image.verify()  # of the chunks; after it an image cannot be read
        with Image.open(path, formats=["PNG"]) as image:
            bands = np.atleast_2d(image.getextrema())
    except (OSError, SyntaxError, ValueError):  # Pillow's for a chunk that is damaged or missing
        return False
    return bool((bands[:, 0] < bands[:, 1]).any())
