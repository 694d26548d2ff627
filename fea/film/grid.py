"""The cells of a film: around the bore and over its width, or half of it."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import lapack
from scipy.sparse import csr_array

from geometry.arrays import Floats, Ints
from geometry.errors import require


@dataclass(frozen=True)
class FilmGrid:
    """Cells (n_angle, n_width), the first at angle 0; `halved`: z ≥ 0 only, mirrored at z = 0."""

    radius: float  #: mm
    width: float  #: of the whole bearing, mm
    n_angle: int
    n_width: int
    halved: bool = True
    #: 0: cells of equal width; 1: as narrow at the ends of the bearing, where the pressure of a bent bore has
    #: its peak, as those of Chebyshev's points
    graded: float = 0.0

    @property
    def shape(self) -> tuple[int, int]:
        """Number of cells around the bore and over the width."""
        return self.n_angle, self.n_width

    @property
    def images(self) -> int:
        """How many cells of the bearing each cell stands for."""
        return 2 if self.halved else 1

    @property
    def dx(self) -> float:
        """Length of a cell around the bore, mm."""
        return 2 * math.pi * self.radius / self.n_angle

    @cached_property
    def edges(self) -> Floats:
        """Edges (n_width + 1,) of the cells along the width, from the middle, mm."""
        even = np.linspace(0.0 if self.halved else -1.0, 1.0, self.n_width + 1)
        return self.width / 2 * ((1 - self.graded) * even + self.graded * np.sin(math.pi / 2 * even))

    @cached_property
    def dz(self) -> Floats:
        """Lengths (n_width,) of the cells along the width, mm."""
        return np.diff(self.edges)

    @cached_property
    def area(self) -> Floats:
        """Areas (n_width,) of the cells, mm²."""
        return self.dx * self.dz

    def total(self, values: Floats) -> float:
        """Integral of values (n_angle, n_width) over the whole bearing."""
        return self.images * float((values @ self.area).sum())

    @cached_property
    def angle(self) -> Floats:
        """Angle (n_angle,) of the cells from rod +x, rad."""
        return np.linspace(0.0, 2 * math.pi, self.n_angle + 1)[:-1]

    @cached_property
    def z(self) -> Floats:
        """Place (n_width,) of the cells along the width, from the middle, mm."""
        return (self.edges[1:] + self.edges[:-1]) / 2

    @cached_property
    def outwards(self) -> Floats:
        """How much nearer (n_angle, n_width, k) the journal comes to the bore: see `outwards_at`."""
        return self.outwards_at(self.z)

    @property
    def ends(self) -> Floats:
        """Ends of the bearing along the width, mm: one of them if the other is its image."""
        return self.edges[[-1]] if self.halved else self.edges[[0, -1]]

    def outwards_at(self, z: Floats) -> Floats:
        """By unit motions of the journal (n_angle, n, k) at places along the width.

        They are shifts along x and y; on the whole width also tilts that move its end at the largest z so.
        """
        around = np.stack([np.cos(self.angle), np.sin(self.angle)], axis=-1)[:, None]
        shifts = around * np.ones((len(z), 1))
        if self.halved:
            return shifts
        return np.concatenate([shifts, shifts * (2 * z / self.width)[:, None]], axis=-1)

    def resultants(self, pressure: Floats, functions: Floats | None = None) -> Floats:
        """Integrals (…, k) over the whole bore of pressures (…, n_angle, n_width), MPa, times functions, N.

        `functions` (n_angle, n_width, k): by default `outwards`, which gives the forces along x and y.
        """
        along = self.outwards if functions is None else functions
        return np.tensordot(self.images * self.area * pressure, along, axes=2)

    def hole(self, angle: float, diameter: float, z: float = 0.0, parts: int = 4) -> Floats:
        """Share (n_angle, n_width) of each cell that a round hole at an angle and z covers.

        Each cell is cut into `parts` by `parts`, and the rim of the hole is as soft as one of them is long,
        so that the share varies continuously while the hole moves.
        """
        offsets = (np.arange(parts) + 0.5) / parts - 0.5
        around = (self.angle - angle + math.pi) % (2 * math.pi) - math.pi
        soft = np.maximum(self.dx, self.dz)[:, None, None] / parts
        near = self.radius * np.abs(around) < (diameter + self.dx + soft.max()) / 2  # others are not covered
        x = (self.radius * around[near])[:, None] + offsets * self.dx
        along = (self.z - z)[:, None] + offsets * self.dz[:, None]
        distance = np.hypot(x[:, None, :, None], along[None, :, None, :])
        share = np.zeros(self.shape)
        share[near] = np.clip((diameter / 2 - distance) / soft + 0.5, 0.0, 1.0).mean(axis=(2, 3))
        return share

    def groove(self, angle: float, arc: float, width: float = math.inf) -> Floats:
        """Share (n_angle, n_width) of each cell that a groove in the middle of the width covers; rad, mm."""
        off = np.abs((self.angle - angle + math.pi) % (2 * math.pi) - math.pi)
        off = np.where(arc < 2 * math.pi, off, -math.inf)  # all round, it has no ends
        around = np.clip((arc / 2 - off) * self.n_angle / (2 * math.pi) + 0.5, 0.0, 1.0)
        return np.outer(around, np.clip((width / 2 - np.abs(self.z)) / self.dz + 0.5, 0.0, 1.0))


class Stencil:
    """Solves sets of equations in which each cell of a grid is linked to its four neighbours.

    The cells are numbered from the angle 0 on both sides in turn, so that the neighbours of a cell on the
    closed ring have numbers within a band.
    """

    def __init__(self, grid: FilmGrid) -> None:
        n, m = grid.shape
        require(n >= 8 and m >= 2, "cells of the film", grid.shape, "must be at least 8 by 2")
        place = np.empty(n, dtype=np.int64)
        order = np.stack([np.arange(n), n - 1 - np.arange(n)], axis=1).ravel()[:n]
        place[order] = np.arange(n)
        # Numbers of the cells, in the order of the band, and the places of them in it.
        self._order = (order[:, None] * m + np.arange(m)).ravel()
        self._band = 2 * m
        number: Ints = place[:, None] * m + np.arange(m)
        self._place = number.ravel()
        # Columns of the entries of a row: itself, the next and the last angle, the next and the last z.
        plain = np.arange(n * m).reshape(n, m)
        near = np.stack([plain, *(np.roll(plain, shift, axis) for axis in (0, 1) for shift in (-1, 1))])
        columns = self._place[near]
        self._rows = 3 * self._band + 1
        there = np.ones((5, n, m), dtype=bool)  # no neighbours beyond the ends of the width
        there[3, :, -1] = there[4, :, 0] = False
        self._kept = np.flatnonzero(there)
        self._at = (columns * self._rows + 2 * self._band + number - columns).ravel()[self._kept]
        self._size = n * m
        # Where a neighbour does not exist its entry is 0, wherever it stands.
        near = near.reshape(5, -1).T.ravel()
        self._product = csr_array((np.zeros(5 * n * m), near, 5 * np.arange(n * m + 1)))

    def solver(self, entries: Floats) -> Callable[[Floats], Floats]:
        """Return what solves for right-hand sides (n_cells, k).

        `entries` (5, n_angle, n_width): in the row of each cell, the factors of its own value, of those at
        the next and the last angle, and of those at the next and the last z, where there is none 0.
        """
        band = np.zeros(self._size * self._rows)
        band[self._at] = entries.ravel()[self._kept]
        wide = self._band
        factor, pivots, failed = lapack.dgbtrf(
            band.reshape(self._size, self._rows).T, wide, wide, overwrite_ab=True
        )
        if failed:
            raise np.linalg.LinAlgError(f"a film has no solution: row {failed} of its equations")

        def solve(right: Floats) -> Floats:
            ordered = right.take(self._order, axis=0)
            solution, _ = lapack.dgbtrs(factor, wide, wide, ordered, pivots, overwrite_b=True)
            return np.asarray(solution.take(self._place, axis=0))

        return solve

    def matrix(self, entries: Floats, factors: Floats) -> csr_array:
        """Matrix (n_cells, n_cells) of entries, as of `solver`, times factors of the columns' cells.

        The next call overwrites it.
        """
        self._product.data[:] = entries.reshape(5, -1).T.ravel() * factors.ravel()[self._product.indices]
        return self._product
