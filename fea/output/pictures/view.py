"""The direction from which a place on a rod can be seen."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats

# Three-quarter view from above the face of the rod, from which a rod is easily recognised.
USUAL = np.array([-0.25, 0.4, 0.88])


@dataclass(frozen=True)
class View:
    """A direction to look from, without perspective.

    Attributes
    ----------
    towards
        Unit vector from the rod to the eye.
    right, up
        Unit vectors across the picture: the x axis of the rod points to the right as far as possible.
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
    """Return the view that shows a place best.

    Parameters
    ----------
    normal
        Outward unit normal (3,) of the surface there.
    visible
        Tells whether the place is visible to an eye in a direction (3,).
    closeness
        Weight of looking straight at the place, relative to looking from the usual direction.
    """
    directions = _directions()
    merit = closeness * (directions @ normal) + directions @ (USUAL / np.linalg.norm(USUAL))
    order = np.argsort(-merit, kind="stable")
    facing = [k for k in order if directions[k] @ normal > 0.1]
    best = next((k for k in facing if visible(directions[k])), order[0])
    return View.along(directions[best])


def _directions() -> Floats:
    """Return directions (n, 3) all around the rod, none nearly along it, so that its length stays visible."""
    slant, around = np.radians(np.mgrid[-40:41:8, -180:180:10].reshape(2, -1))
    return np.stack([np.sin(slant), np.cos(slant) * np.sin(around), np.cos(slant) * np.cos(around)], axis=1)
