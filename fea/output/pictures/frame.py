"""The rectangle that a picture without perspective shows."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyvista

from geometry.arrays import Floats, Mask

# Three-quarter view from above the face of the rod, from which a rod is easily recognised.
USUAL = np.array([-0.25, 0.4, 0.88])


@dataclass(frozen=True)
class View:
    """A direction to look from, without perspective.

    Unit vectors: from the rod to the eye, and across the picture; the x axis of the rod points to the right
    as far as possible.
    """

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

    `visible` tells whether the place is visible to an eye in a direction (3,); `closeness` is the weight of
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
class Frame:
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
    def around(cls, points: Floats, view: View, aspect: float, width: float, height: float) -> "Frame":
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
        plotter.add_light(
            pyvista.Light(position=middle + lamp, focal_point=middle, light_type="scene light"),
            only_active=True,
        )
