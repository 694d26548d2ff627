"""The components of every picture: lines, text, a canvas, a file."""

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyvista
from PIL import Image

from fea.output.pictures.frame import Frame
from fea.output.pictures.skin import Skin, refined_line
from geometry.arrays import Floats

SIZE = (1600, 1000)  # pixels
OVERSAMPLED = 2  # anti-aliasing by oversampling makes lines thinner by this factor
INK, GREY, PAPER = "#1a1a1a", "#a0a0a0", "white"
SHADING = {"ambient": 0.5, "diffuse": 0.52, "specular": 0.0}


def canvas(rows: list[float], columns: list[float], **parts: Any) -> Any:
    """Return a plotter without a window, whose parts have these fractions of its height and width."""
    plotter = pyvista.Plotter(
        off_screen=True,
        window_size=SIZE,
        shape=(len(rows), len(columns)),
        row_weights=rows,
        col_weights=columns,
        border=False,
        lighting="none",
        **parts,
    )
    plotter.set_background(PAPER)
    return plotter


def finish(plotter: Any, png: Path, share: float) -> None:
    """Render the picture and write it.

    Parameters
    ----------
    plotter
        A plotter of `canvas`.
    png
        The file.
    share
        Fraction of the height, from the top, that shows a rod below a title.

    Raises
    ------
    RuntimeError
        The picture is blank: some OpenGL libraries fail without an error.
    """
    plotter.enable_anti_aliasing("ssaa")
    image = plotter.screenshot(return_img=True)
    plotter.close()
    require_rod(image[int(0.1 * share * SIZE[1]) : int(share * SIZE[1])])
    # A palette of 256 colours reduces the file to a third of its size without a visible difference.
    few = Image.fromarray(image).quantize(256, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    few.putpalette([255 if level > 250 else level for level in few.getpalette() or []])  # white stays white
    few.save(png, format="PNG")


def require_rod(image: npt.NDArray[np.uint8]) -> None:
    """Raise RuntimeError if an image (height, width, 3) is (almost) completely white."""
    if np.mean(image[::4, ::4].min(axis=2) < 235) < 0.02:
        raise RuntimeError("the picture is blank")


def add_edges(plotter: Any, skin: Skin, points: Floats, frame: Frame, pen: tuple[str, float]) -> None:
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
    actor.prop.font_size = size
    if centred:
        actor.prop.justification_horizontal = "center"
    actor.prop.background_color = PAPER
    actor.prop.background_opacity = ground
