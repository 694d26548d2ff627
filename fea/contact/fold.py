"""Pressures on both sides of the mirror plane y = 0, from those on the cell by their parity."""

from dataclasses import dataclass

import numpy as np

from fea.solid.parity import Parity
from geometry.arrays import Floats, Mask


@dataclass(frozen=True)
class Fold:
    """How pressures on the whole body follow from the cell.

    Of a cell that is cut at y = 0 and loaded in both parities, the unknowns are the pressures at its
    vertices, then those at their images off the plane. Otherwise they are those of the cell.

    Attributes
    ----------
    on_y
        (n_cell,) which vertices of the cell lie on y = 0.
    both_sides
        Whether the images across y = 0 are unknowns of their own.
    images
        How many cells make the whole body.
    """

    on_y: Mask
    both_sides: bool
    images: int

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.on_y) + (int((~self.on_y).sum()) if self.both_sides else 0)

    def parities(self) -> tuple[Parity, ...]:
        """Return the parities that the unknowns have."""
        return tuple(Parity) if self.both_sides else (Parity.SYMMETRIC,)

    def parts(self, pressure: Floats) -> dict[Parity, Floats]:
        """Pressures (n_cell, …) on the cell of each parity from the unknowns (n, …)."""
        if not self.both_sides:
            return {Parity.SYMMETRIC: pressure}
        here, off = pressure[: len(self.on_y)], ~self.on_y
        there = here.copy()
        there[off] = pressure[len(self.on_y) :]
        return {Parity.SYMMETRIC: (here + there) / 2, Parity.ANTISYMMETRIC: (here - there) / 2}

    def joined(self, parts: dict[Parity, Floats]) -> Floats:
        """Unknowns (n, …) from pressures (n_cell, …) on the cell of each parity: the inverse of `parts`."""
        even = parts[Parity.SYMMETRIC]
        if not self.both_sides:
            return even
        odd = parts[Parity.ANTISYMMETRIC]
        return np.concatenate([even + odd, (even - odd)[~self.on_y]])

    def moments(self, parts: dict[Parity, Floats]) -> Floats:
        """Moments (n, …) over the whole body from those (n_cell, …) on the cell of each parity.

        It is the transpose of `parts`, times the number of images: pressure times moment is work.
        """
        even = self.images * parts[Parity.SYMMETRIC]
        if not self.both_sides:
            return even
        odd = self.images * parts[Parity.ANTISYMMETRIC]
        off = ~self.on_y
        here = np.where(off.reshape(-1, *(1,) * (even.ndim - 1)), (even + odd) / 2, even)
        return np.concatenate([here, ((even - odd) / 2)[off]])
