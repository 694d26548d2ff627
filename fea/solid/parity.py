"""Symmetric and antisymmetric parts about y = 0."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from geometry.arrays import Floats, Ints, Mask


class Parity(IntEnum):
    """Continuation of a vector field across y = 0: mirrored, or mirrored and reversed."""

    SYMMETRIC = 1
    ANTISYMMETRIC = -1


@dataclass(frozen=True)
class ParityPair:
    """Symmetric and antisymmetric part of a field about y = 0 on the meshed cell, each (n_nodes, 3).

    The second is None for a model that is not cut there.
    """

    symmetric: Floats
    antisymmetric: Floats | None

    @classmethod
    def of(cls, even: Floats, odd: Floats, *, cut: bool) -> "ParityPair":
        """Return the pair for a model that is cut at y = 0; on another the parts add up."""
        return cls(even, odd) if cut else cls(even + odd, None)

    def part(self, parity: Parity) -> Floats:
        """One of the two parts; zero where there is none."""
        if parity is Parity.SYMMETRIC:
            return self.symmetric
        return np.zeros_like(self.symmetric) if self.antisymmetric is None else self.antisymmetric


@dataclass(frozen=True)
class MirrorUnfolding:
    """Relation of unknowns on the whole body, such as pressures, to those on the cell.

    Of a cell that is cut at y = 0 and loaded in both parities, the unknowns are those of the cell, then
    those at their images off the plane. Otherwise they are those of the cell.
    """

    on_y: Mask  #: (n_cell,) whether each of the cell's unknowns is at a place on y = 0
    both_sides: bool  #: whether the images across y = 0 are separate unknowns
    images: int  #: number of cells in the whole body
    #: (n_cell,) which of those on y = 0 act across the plane, so that they have only an odd part; the others
    #: have only an even one. None by default.
    across: Mask | None = None

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.on_y) + (int((~self.on_y).sum()) if self.both_sides else 0)

    def parities(self) -> tuple[Parity, ...]:
        """Return the parities that the unknowns have."""
        return tuple(Parity) if self.both_sides else (Parity.SYMMETRIC,)

    def has(self, parity: Parity) -> Mask:
        """Mask (n_cell,) of the cell's unknowns that have a part of this parity."""
        across = self._across
        return ~(self.on_y & (across if parity is Parity.SYMMETRIC else ~across))

    @property
    def _across(self) -> Mask:
        return np.zeros_like(self.on_y) if self.across is None else self.across

    def images_of(self, cells: Ints) -> Ints:
        """Unknowns (n,) that are the images of unknowns of the cell; those on y = 0 are their own."""
        if not self.both_sides:
            return cells
        off = ~self.on_y
        number = np.where(off, len(off) + np.cumsum(off) - 1, np.arange(len(off)))
        return np.asarray(number[cells])

    def with_images(self, cells: Ints) -> Ints:
        """Unknowns of the cell, then their images across y = 0."""
        if not self.both_sides:
            return cells
        return np.concatenate([cells, self.images_of(cells[~self.on_y[cells]])])

    def parts(self, values: Floats) -> dict[Parity, Floats]:
        """Values (n_cell, …) on the cell of each parity from those of the unknowns (n, …)."""
        if not self.both_sides:
            return {Parity.SYMMETRIC: values}
        here, off = values[: len(self.on_y)], ~self.on_y
        there = here.copy()
        there[off] = values[len(self.on_y) :]
        across = self.on_y & self._across
        there[across] = -here[across]
        return {Parity.SYMMETRIC: (here + there) / 2, Parity.ANTISYMMETRIC: (here - there) / 2}

    def unfolded(self, parts: dict[Parity, Floats]) -> Floats:
        """Unknowns (n, …) from values (n_cell, …) on the cell of each parity: the inverse of `parts`."""
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
        masks, extra = (~self.on_y, self.on_y & self._across), (1,) * (even.ndim - 1)
        off, across = (mask.reshape(-1, *extra) for mask in masks)
        here = np.where(off, (even + odd) / 2, np.where(across, odd, even))
        return np.concatenate([here, ((even - odd) / 2)[~self.on_y]])

    def compliance(self, of_cell: Mapping[Parity, Floats]) -> Floats:
        """Moments (n, n) of unit unknowns from those (n_cell, n_cell) on the cell of each parity.

        It is `moments` of these times `parts` of the unit matrix, without its zeros.
        """
        if not self.both_sides:
            return self.images * of_cell[Parity.SYMMETRIC]
        n, off = len(self.on_y), np.flatnonzero(~self.on_y)
        parts = []
        for parity in Parity:
            share = np.where(self.has(parity), np.where(self.on_y, 1.0, 0.5), 0.0)
            part = of_cell[parity] * (self.images * share)
            part *= share[:, None]
            parts.append(part)
        even, odd = parts
        moments = np.empty((n + len(off),) * 2)
        moments[:n, :n], apart = even + odd, even - odd
        moments[:n, n:], moments[n:, :n] = apart[:, off], apart[off]
        moments[n:, n:] = moments[off][:, off]
        return moments
