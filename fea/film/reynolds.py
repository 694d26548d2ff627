"""Reynolds' equation by finite volumes, with cavitation that conserves the oil.

Where the film is full, its pressure p is positive; elsewhere p is that of the surroundings, 0, and oil fills
the share θ < 1 of the gap (Jakobsson & Floberg 1957, Olsson 1965). Of every cell,

    ∂(θh)/∂t + ∂/∂x (θ h U/2 − h³/12μ ∂p/∂x) − ∂/∂z (h³/12μ ∂p/∂z) = supply,   p ≥ 0, θ ≤ 1, p (1 − θ) = 0.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fea.film.grid import FilmGrid, Stencil
from fea.film.oil import Oil
from geometry.arrays import Floats, Mask

# Pressure that may arise in one of Newton's steps, MPa.
_FIRST = 100.0
# A hole that fills a cell but for this share of it sets the pressure of the cell.
_OPEN = 1e-6
# Of a cell that is half covered, the rim is a quarter of its length from its middle, not all of it.
_RIM = 4.0


@dataclass(frozen=True)
class Supply:
    """Holes and grooves: the share (n_angle, n_width) of each cell that they cover, and their pressure."""

    share: Floats
    pressure: float  #: above the surroundings, MPa, positive: oil that is not pressed in fills no gap


@dataclass(frozen=True)
class Conditions:
    """What drives the oil, and how fast it may change."""

    speed: float  #: U of the journal's surface relative to the bore's, towards larger angles, mm/s
    supply: Supply | None = None
    #: rate, before: the time derivative of θh (n_angle, n_width) is rate·θh − before, 1/s and mm/s
    rate: float = 0.0
    before: Floats | float = 0.0


@dataclass(frozen=True)
class Film:
    """The oil in the gap."""

    pressure: Floats  #: (n_angle, n_width) above the surroundings, MPa
    fill: Floats  #: (n_angle, n_width) θ, 1 where the film is full
    full: Mask  #: (n_angle, n_width)

    @classmethod
    def at_rest(cls, grid: FilmGrid) -> "Film":
        """A full film without pressure."""
        return cls(np.zeros(grid.shape), np.ones(grid.shape), np.ones(grid.shape, dtype=bool))

    def changed(self, by: Floats) -> "Film":
        """Add a change (n_angle, n_width), of p where the film is full and of θ elsewhere.

        A pressure at most doubles, but for the first ones: the viscosity grows exponentially with it.
        """
        most = 2 * self.pressure + _FIRST
        pressure = np.where(self.full, np.minimum(self.pressure + by, most), 0.0)
        fill = np.where(self.full, 1.0, self.fill + by)
        full = np.where(self.full, pressure >= 0, fill > 1)
        return Film(np.maximum(pressure, 0.0), np.minimum(fill, 1.0), full)


@dataclass(frozen=True)
class Balance:
    """Oil that leaves each cell beyond what it may, and its derivatives as entries of `Stencil`."""

    excess: Floats  #: (n_angle, n_width), mm³/s
    by_film: Floats  #: (5, n_angle, n_width) of the unknown of each cell: p, MPa, or θ
    by_gap: Floats  #: (5, n_angle, n_width), mm²/s
    supplied: float  #: through holes and grooves of the whole bearing, mm³/s
    leaked: float  #: at the ends of the whole bearing, mm³/s
    pressed: float  #: power that the flow under pressure dissipates in the whole bearing, N·mm/s


class _Flow(NamedTuple):
    """Flow of oil, its derivatives by the unknowns and gaps on both sides, and the power of its pressure."""

    flow: Floats
    by_film: Floats
    by_gap: Floats
    power: Floats


@dataclass(frozen=True)
class Reynolds:
    """The equation on a grid."""

    grid: FilmGrid
    oil: Oil

    @cached_property
    def stencil(self) -> Stencil:
        """Solves its linear equations."""
        return Stencil(self.grid)

    def balance(self, film: Film, gap: Floats, conditions: Conditions) -> Balance:
        """Balance the oil of each cell; `gap`: h (n_angle, n_width), mm."""
        grid, rate = self.grid, conditions.rate
        q, slope = self.oil.generalised(film.pressure)
        slope = np.where(film.full, slope, 0.0)
        around = self._around(film, gap, q, slope, conditions.speed)
        along, (ends, supplied) = (
            self._along(film, gap, q, slope),
            self._exchanged(film, gap, q, slope, conditions),
        )
        excess = grid.area * (rate * film.fill * gap - conditions.before) + ends.flow - supplied.flow
        excess += around.flow - np.roll(around.flow, 1, 0) + along.flow
        excess[:, 1:] -= along.flow[:, :-1]
        by_film, by_gap = (
            self._entries(around.by_film, along.by_film),
            self._entries(around.by_gap, along.by_gap),
        )
        by_film[0] += np.where(film.full, 0.0, grid.area * rate * gap) + ends.by_film - supplied.by_film
        by_gap[0] += grid.area * rate * film.fill + ends.by_gap - supplied.by_gap
        power = around.power + along.power + ends.power + supplied.power
        return Balance(
            excess,
            by_film,
            by_gap,
            supplied=grid.images * float(supplied.flow.sum()),
            leaked=grid.images * float(ends.flow.sum()),
            pressed=grid.images * float(power.sum()),
        )

    def _around(self, film: Film, gap: Floats, q: Floats, slope: Floats, speed: float) -> _Flow:
        """Flow to the next angle, at the filled share of the cell from which the journal carries the oil."""
        grid = self.grid
        falls, drags = grid.dz / grid.dx / (12 * self.oil.viscosity), grid.dz * speed / 2
        middle = (gap + np.roll(gap, -1, 0)) / 2
        drop, conducts = np.roll(q, -1, 0) - q, falls * middle**3
        upstream = film.fill if speed >= 0 else np.roll(film.fill, -1, 0)
        by_middle = (drags * upstream - 3 * falls * middle**2 * drop) / 2
        by_film = np.stack([conducts * slope, -conducts * np.roll(slope, -1, 0)])
        by_film[0 if speed >= 0 else 1] += np.where(
            film.full if speed >= 0 else np.roll(film.full, -1, 0), 0.0, drags * middle
        )
        return _Flow(
            drags * upstream * middle - conducts * drop,
            by_film,
            np.stack([by_middle, by_middle]),
            conducts * drop * (np.roll(film.pressure, -1, 0) - film.pressure),
        )

    def _along(self, film: Film, gap: Floats, q: Floats, slope: Floats) -> _Flow:
        grid = self.grid
        falls = grid.dx / grid.dz / (12 * self.oil.viscosity)
        middle = (gap[:, :-1] + gap[:, 1:]) / 2
        conducts, drop = falls * middle**3, np.diff(q)
        by_middle = -3 * falls * middle**2 * drop / 2
        parts = (
            -conducts * drop,
            np.stack([conducts * slope[:, :-1], -conducts * slope[:, 1:]]),
            np.stack([by_middle, by_middle]),
            conducts * drop * np.diff(film.pressure),
        )
        flow = _Flow(*(np.zeros((*part.shape[:-1], grid.n_width)) for part in parts))
        for whole, part in zip(flow, parts, strict=True):
            whole[..., :-1] = part
        return flow

    def _exchanged(
        self, film: Film, gap: Floats, q: Floats, slope: Floats, conditions: Conditions
    ) -> tuple[_Flow, _Flow]:
        """Flow out of the cells at the ends, and into cells through holes and grooves."""
        grid, supply = self.grid, conditions.supply
        falls = 1 / (12 * self.oil.viscosity)
        ends = np.zeros(grid.shape)
        ends[:, [-1] if grid.halved else [0, -1]] = 2 * falls * grid.dx / grid.dz
        share = 0.0 if supply is None else supply.share / (1 - supply.share + _OPEN)
        open_to = np.broadcast_to(_RIM * falls * (grid.dx / grid.dz + grid.dz / grid.dx) * share, grid.shape)
        inlet = 0.0 if supply is None else supply.pressure
        q_inlet, _ = self.oil.generalised(np.array(inlet))
        flows = []
        for factor, sign, head, rise in (
            (ends, 1.0, q, film.pressure),
            (open_to, -1.0, q - q_inlet, film.pressure - inlet),
        ):
            conducts = factor * gap**3
            out = sign * conducts * head
            flows.append(_Flow(out, sign * conducts * slope, 3 * out / gap, conducts * head * rise))
        return flows[0], flows[1]

    def _entries(self, around: Floats, along: Floats) -> Floats:
        """Entries (5, n_angle, n_width) of flows' derivatives (2, …) by the cells on both sides of a face."""
        entries = np.zeros((5, *self.grid.shape))
        entries[0] = around[0] - np.roll(around[1], 1, 0) + along[0]
        entries[0, :, 1:] -= along[1, :, :-1]
        entries[1], entries[2] = around[1], -np.roll(around[0], 1, 0)
        entries[3, :, :-1] = along[1, :, :-1]
        entries[4, :, 1:] = -along[0, :, :-1]
        return entries

    def friction(
        self, film: Film, gap: Floats, speed: float, *, full_shear: bool = False
    ) -> tuple[float, float]:
        """Force of the film against the journal's motion, N, and the power that shear dissipates, N·mm/s.

        Of the gap that is partly filled, the filled share is sheared, or, with `full_shear`, all of it.
        """
        grid = self.grid
        share = np.ones(grid.shape) if full_shear else np.maximum(film.fill, 0.0)
        viscosity = self.oil.viscosity * self.oil.relative_viscosity(film.pressure)
        sheared = float((share * viscosity / gap).sum()) * grid.area * grid.images * speed
        middle = (gap + np.roll(gap, -1, 0)) / 2
        rises = np.roll(film.pressure, -1, 0) - film.pressure
        pushed = float((middle / 2 * rises).sum()) * grid.dz * grid.images
        return sheared + pushed, sheared * speed
