"""The components of every picture: lines, text, a canvas, a file."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyvista
from PIL import Image

from fea.output.pictures.surface import DrawnSurface, refined_line
from geometry.arrays import Floats, Mask

# Three-quarter view from above the face of the rod, from which a rod is easily recognised.
USUAL = np.array([-0.25, 0.4, 0.88])


@dataclass(frozen=True)
class View:
    """A parallel view: unit vectors to the eye and across; the rod's x points to the right if possible."""

    towards: Floats
    right: Floats
    up: Floats

    @classmethod
    def along(cls, towards: Floats) -> "View":
        """Return the view from this direction (not along the rod)."""
        towards = towards / np.linalg.norm(towards)
        right = np.array([1.0, 0.0, 0.0]) - towards[0] * towards
        right = right / np.linalg.norm(right)
        return cls(towards, right, np.cross(towards, right))

    def across(self, points: Floats) -> Floats:
        """Return the picture coordinates (…, 2) of points (…, 3), mm to the right and up."""
        return points @ np.stack([self.right, self.up], axis=1)


def choose_view(normal: Floats, visible: Callable[[Floats], bool], closeness: float) -> View:
    """Return the view that shows a place with this outward unit normal (3,) best.

    `visible` returns whether an eye in a direction (3,) sees the place; `closeness` is the weight of
    looking straight at the place, relative to looking from the usual direction.
    """
    slant, around = np.radians(np.mgrid[-40:41:8, -180:180:10].reshape(2, -1))
    directions = np.stack(
        [np.sin(slant), np.cos(slant) * np.sin(around), np.cos(slant) * np.cos(around)], axis=1
    )
    merit = closeness * (directions @ normal) + directions @ (USUAL / np.linalg.norm(USUAL))
    order = np.argsort(-merit, kind="stable")
    facing = [k for k in order if directions[k] @ normal > 0.1]
    best = next((k for k in facing if visible(directions[k])), order[0])
    return View.along(directions[best])


@dataclass(frozen=True)
class CameraFrame:
    """A rectangle in space, seen from a direction; lengths in mm.

    `centre` (2,) is the middle in the view's coordinates, `aspect` width over height. Marks are drawn at the
    position `near` towards the eye, in front of everything else.
    """

    view: View
    centre: Floats
    half_height: float
    aspect: float
    near: float

    @property
    def nudge(self) -> Floats:
        """Small offset (3,) towards the eye, so that a line on a surface is not half hidden by it."""
        step: Floats = 4e-3 * self.half_height * self.view.towards
        return step

    @classmethod
    def around(cls, points: Floats, view: View, aspect: float, width: float, height: float) -> "CameraFrame":
        """Return a frame in which points (n, 3) fill at most these fractions of its width and height."""
        flat = view.across(points)
        low, high = flat.min(axis=0), flat.max(axis=0)
        half = max((high[0] - low[0]) / (width * aspect), (high[1] - low[1]) / height) / 2
        return cls(view, (low + high) / 2, float(half), aspect, float((points @ view.towards).max()) + 1.0)

    def lifted(self, flat: Floats) -> Floats:
        """Return points (…, 3) in front of everything else, from coordinates (…, 2) of the view."""
        axes = np.stack([self.view.right, self.view.up])
        return flat @ axes + self.near * self.view.towards

    def relative(self, flat: Floats) -> tuple[float, float]:
        """Return coordinates (2,) of the view as fractions of the frame's width and height."""
        x, y = (flat - self.centre) / (2 * self.half_height * np.array([self.aspect, 1.0])) + 0.5
        return float(x), float(y)

    def place(self, relative: tuple[float, float]) -> Floats:
        """Return coordinates (2,) of the view from fractions of the frame's width and height."""
        size = 2 * self.half_height * np.array([self.aspect, 1.0])
        flat: Floats = self.centre + (np.array(relative) - 0.5) * size
        return flat

    def meets(self, groups: Floats) -> Mask:
        """Return which groups (n, k, 3) of points may be seen here, or close to the border."""
        flat = self.view.across(groups) - self.centre
        half = 1.1 * self.half_height * np.array([self.aspect, 1.0])
        return np.asarray(np.all((flat.min(axis=1) < half) & (flat.max(axis=1) > -half), axis=1))

    def aim(self, plotter: Any) -> None:
        """Let the camera of the plotter's active part show this frame."""
        middle = self.lifted(self.centre)
        camera = plotter.camera
        camera.parallel_projection = True
        camera.focal_point = middle
        camera.position = middle + 10 * self.half_height * self.view.towards
        camera.up = self.view.up
        camera.parallel_scale = self.half_height
        plotter.renderer.ResetCameraClippingRange()
        # A light beside the eye: surfaces that face it are bright, and curved ones look curved.
        lamp = 0.3 * self.view.up - 0.2 * self.view.right + self.view.towards
        light = pyvista.Light(position=middle + lamp, focal_point=middle, light_type="scene light")
        plotter.add_light(light, only_active=True)


SIZE = (1600, 1000)  # pixels
# Everything is drawn this many times larger and then reduced, which leaves no jagged edges: where a processor
# draws, this takes half as long as VTK's own anti-aliasing.
OVERSAMPLED = 2
INK, GREY, PAPER = "#1a1a1a", "#a0a0a0", "white"
SHADING = {"ambient": 0.5, "diffuse": 0.52, "specular": 0.0, "culling": "back"}


Shares = tuple[float, ...]
Rows = tuple[int, ...]


def canvas(rows: Shares, columns: Shares, *, joined: Rows = (), axes: Rows = ()) -> Any:
    """Return an empty plotter without a window; pictures of one layout share it, which saves time.

    `rows` and `columns` are fractions of its height and width, `joined` the rows that are one part, and
    `axes` those whose first part shows the directions of the axes.
    """
    plotter = _plotter(rows, columns, joined, axes)
    plotter.clear()
    return plotter


@cache
def _plotter(rows: Shares, columns: Shares, joined: Rows, axes: Rows) -> Any:
    groups = [(row, slice(None)) for row in joined] or None
    layout = {
        "shape": (len(rows), len(columns)),
        "row_weights": rows,
        "col_weights": columns,
        "groups": groups,
    }
    window = oversampled(SIZE)
    plotter = pyvista.Plotter(off_screen=True, window_size=window, border=False, lighting="none", **layout)
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
    """Render a `canvas` plotter, the rod in its upper `share`. Raises `RuntimeError`: a blank picture."""
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


def add_edges(
    plotter: Any, skin: DrawnSurface, points: Floats, frame: CameraFrame, pen: tuple[str, float]
) -> None:
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
    """Write at fractions of the frame; `size` in pixels, `ground` the background's opacity, 0 to 1."""
    actor = plotter.add_text(text, position=place, viewport=True, color=INK, font="arial")
    actor.prop.font_size = OVERSAMPLED * size
    if centred:
        actor.prop.justification_horizontal = "center"
    actor.prop.background_color = PAPER
    actor.prop.background_opacity = ground
