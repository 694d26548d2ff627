"""Right-handed frames about an axis, and where a rod's centre of gravity lies in its frame."""

from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats


def rod_frame(axis: Floats, between: Floats) -> tuple[Floats, float]:
    """Return the rod's frame in the coordinates of a file, and its length.

    Parameters
    ----------
    axis
        Unit vector (3,) along the pins.
    between
        From a point on the big end's axis to one on the small end's, mm.

    Returns
    -------
    tuple
        Unit vectors (3, 3) along the rod, across it and along its pins, as rows; distance of the axes, mm.
    """
    x = between - (between @ axis) * axis
    length = float(np.linalg.norm(x))
    x = x / length
    return np.stack([x, np.cross(axis, x), axis]), length


# Largest distance of a rod's centre of gravity from the line between its bores, and from the ends of that
# line, over the distance of the bores: 0.06 and 0 on rods.
_OFF_LINE = 0.2


class Balance(NamedTuple):
    """Where a centre of gravity lies relative to the line between two bores."""

    distance: float  # of the bores, mm
    # aside, beyond: of the centre of gravity from the line, and from its ends along it, mm; 0 beyond where it
    # is between
    aside: float
    beyond: float

    @classmethod
    def of(cls, axis: Floats, big: Floats, small: Floats, middle: Floats) -> "Balance":
        """Balance of a centre of gravity (3,), bores along the unit vector `axis` through points (3,)."""
        frame, distance = rod_frame(axis, small - big)
        along, aside, _ = (frame @ (middle - big)).tolist()
        return cls(distance, abs(aside), max(-along, along - distance, 0.0))

    @property
    def is_that_of_a_rod(self) -> bool:
        """Whether these may be the bores of a rod, rather than holes for bolts or of other parts."""
        return max(self.aside, self.beyond) <= _OFF_LINE * self.distance

    def text(self) -> str:
        """Say it."""
        return (
            f"the centre of gravity lies {self.aside:.4g} mm beside and {self.beyond:.4g} mm beyond the line "
            f"between them, which is {self.distance:.4g} mm long"
        )


def basis_across(direction: Floats) -> Floats:
    """Two unit vectors (2, 3) across a direction and across each other, right-handed with it."""
    first = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    first = first / np.linalg.norm(first)
    return np.stack([first, np.cross(direction, first)])
