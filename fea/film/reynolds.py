"""Reynolds' equation by finite volumes, with cavitation that conserves the oil.

Where the film is full, its pressure p is positive; elsewhere p is that of the surroundings, 0, and oil fills
the share θ < 1 of the gap (Jakobsson & Floberg 1957, Olsson 1965). Of every cell,

    ∂(θh)/∂t + ∂/∂x (θ h U/2 − h³/12μ ∂p/∂x) − ∂/∂z (h³/12μ ∂p/∂z) = supply,   p ≥ 0, θ ≤ 1, p (1 − θ) = 0.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from fea.film.constitutive import Oil
from fea.film.grid import FilmGrid, Stencil
from geometry.arrays import Floats, Mask

# Pressure that may arise in one of Newton's steps, MPa.
_FIRST = 100.0
# A hole that fills a cell but for this share of it sets the pressure of the cell.
_OPEN = 1e-6
# How much better a cell that is half covered is supplied than through a film of its size: so holes of 3 to
# 8 mm feed a strip as in closed form, within 5 % on the grid of a run and within 1.5 % on one twice as fine.
_RIM = 8.0
# Least share of its length by which the middle of a cell, or the rim of a hole in it, is away from its faces.
_NEAR = 1e-3


@lru_cache(maxsize=16)  # oils differ by temperature: a search meets many
def _potential(oil: Oil, pressure: float) -> float:
    """The q of a pressure: see `Oil.generalised`."""
    return float(oil.generalised(np.array(pressure))[0])


def _next(values: np.ndarray) -> np.ndarray:
    """Values (n_angle, …) of the next angle; several times as fast as `numpy.roll`."""
    return np.concatenate([values[1:], values[:1]])


def _last(values: np.ndarray) -> np.ndarray:
    return np.concatenate([values[-1:], values[:-1]])


@dataclass(frozen=True)
class Supply:
    """Holes and grooves: the share (n_angle, n_width) of each cell that they cover, and their pressure."""

    share: Floats
    #: Above the surroundings, MPa, of all or in each cell; positive: oil that is not pressed in fills no gap
    pressure: Floats | float
    outside: float = 0.0  #: of the oil in which the ends of the bearing stand

    @cached_property
    def land(self) -> Floats:
        """Share of each cell where a surface faces the other."""
        return 1 - self.share

    @cached_property
    def reach(self) -> Floats:
        """Share of its length over which each cell conducts on either side: to the rim of what covers it."""
        return np.clip(self.land, _NEAR, 0.5)

    @cached_property
    def openness(self) -> Floats:
        """How much better than through a film of the cell's own size each cell is supplied."""
        return np.asarray(_RIM * self.share / (self.land + _OPEN))


@dataclass(frozen=True)
class Conditions:
    """What drives the oil, and how fast it may change."""

    speed: float  #: U of the journal's surface relative to the bore's, towards larger angles, mm/s
    supply: Supply | None = None
    #: rate, before: the time derivative of θh (n_angle, n_width) is rate·θh − before, 1/s and mm/s
    rate: float = 0.0
    before: Floats | float = 0.0


@dataclass(frozen=True)
class FilmState:
    """The oil in the gap."""

    pressure: Floats  #: (n_angle, n_width) above the surroundings, MPa
    fill: Floats  #: (n_angle, n_width) θ, 1 where the film is full
    full: Mask  #: (n_angle, n_width)

    @classmethod
    def at_rest(cls, grid: FilmGrid) -> "FilmState":
        """A full film without pressure."""
        return cls(np.zeros(grid.shape), np.ones(grid.shape), np.ones(grid.shape, dtype=bool))

    def changed(self, by: Floats, oil: Oil) -> "FilmState":
        """Add a change (n_angle, n_width), of p where the film is full and of θ elsewhere.

        The viscosity grows exponentially with the pressure, until the oil is solid. So a pressure at most
        doubles, but for the first ones, and falls by less than the tangent of ∫₀ᵖ μ₀/μ dp says, in which the
        flow is linear.
        """
        most, rise, alpha = 2 * self.pressure + _FIRST, np.maximum(by, 0.0), oil.piezoviscosity
        if alpha:
            solid = np.clip(self.pressure - oil.solid, 0.0, rise - by)
            fall = solid + np.log1p(alpha * (rise - by - solid)) / alpha
            by = np.where(self.full, rise - fall, by)
        pressure = np.where(self.full, np.minimum(self.pressure + by, most), 0.0)
        fill = np.where(self.full, 1.0, self.fill + by)
        full = np.where(self.full, pressure >= 0, fill > 1)
        return FilmState(np.maximum(pressure, 0.0), np.minimum(fill, 1.0), full)

    def ahead(self, start: "FilmState", end: "FilmState") -> "FilmState":
        """Guess of the film a step later, if it changes as from a start to an end."""
        now, before, after = (
            np.where(film.full, film.pressure / _FIRST, film.fill - 1) for film in (self, start, end)
        )
        later = now + after - before
        full = later >= 0
        most = np.where(self.full, 2 * self.pressure, 0.0)
        pressure = np.where(full, np.minimum(_FIRST * later, most), 0.0)
        return FilmState(pressure, np.where(full, 1.0, np.maximum(1 + later, 0.0)), full)


@dataclass(frozen=True)
class OilBalance:
    """Oil that leaves each cell beyond what it may, and its derivatives as entries of `Stencil`."""

    excess: Floats  #: (n_angle, n_width), mm³/s
    by_film: Floats  #: (5, n_angle, n_width) of the unknown of each cell: p, MPa, or θ
    by_gap: Floats  #: (5, n_angle, n_width), mm²/s
    supplied: float  #: through holes, grooves and flooded ends of the whole bearing, mm³/s
    leaked: float  #: at the ends of the whole bearing, mm³/s
    pressed: float  #: power that the flow under pressure dissipates in the whole bearing, N·mm/s
    brought: float  #: power of the pressures under which oil is supplied, N·mm/s
    lost: float  #: excess of the whole bearing, mm³/s


class _Flow(NamedTuple):
    """Flow of oil, its derivatives by the unknowns and gaps on both sides, and the power of its pressure."""

    flow: Floats
    by_film: Sequence[Floats]
    by_gap: Sequence[Floats]
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

    @cached_property
    def _drains(self) -> tuple[Floats, Floats]:
        """Factors (n_width,) of h³: through half a cell at the ends, and through open parts of cells."""
        grid, ends = self.grid, [-1] if self.grid.halved else [0, -1]
        across = grid.dx / grid.dz / (12 * self.oil.viscosity)
        leaking = np.zeros_like(across)
        leaking[ends] = 2 * across[ends]
        return leaking, across + grid.dz / grid.dx / (12 * self.oil.viscosity)

    def balance(self, film: FilmState, gap: Floats, conditions: Conditions) -> OilBalance:
        """Balance the oil of each cell; `gap`: h (n_angle, n_width), mm."""
        grid, rate = self.grid, conditions.rate
        q, slope = self.oil.generalised(film.pressure)
        slope = np.where(film.full, slope, 0.0)
        supply = conditions.supply
        shorter: tuple[Floats | float, Floats | float] = (1.0, 1.0)
        if supply is not None and supply.share.any():
            reach, long = supply.reach, supply.reach * grid.dz
            shorter = reach + _next(reach), (long[:, :-1] + long[:, 1:]) / np.diff(grid.z)
        around = self._around(film, gap, q, slope, conditions.speed, shorter=shorter[0])
        along = self._along(film, gap, q, slope, shorter[1])
        inlet, openness, outside = (
            (0.0, 0.0, 0.0) if supply is None else (supply.pressure, supply.openness, supply.outside)
        )
        (leaking, opened), cube = self._drains, gap * gap * gap
        ends = self._drained(film, gap, (q, slope), leaking * cube, outside)
        supplied = self._drained(film, gap, (q, slope), opened * openness * cube, inlet)
        excess = grid.area * (rate * film.fill * gap - conditions.before) + ends.flow + supplied.flow
        excess += around.flow - _last(around.flow) + along.flow
        excess[:, 1:] -= along.flow[:, :-1]
        by_film, by_gap = map(self._entries, around[1:3], along[1:3])
        by_film[0] += np.where(film.full, 0.0, grid.area * rate * gap) + ends.by_film[0] + supplied.by_film[0]
        by_gap[0] += grid.area * rate * film.fill + ends.by_gap[0] + supplied.by_gap[0]
        power = around.power + along.power + ends.power + supplied.power
        return OilBalance(
            excess,
            by_film,
            by_gap,
            supplied=-grid.images * float(supplied.flow.sum() + np.minimum(ends.flow, 0.0).sum()),
            leaked=grid.images * float(np.maximum(ends.flow, 0.0).sum()),
            pressed=grid.images * float(power.sum()),
            lost=abs(grid.images * float(excess.sum())),
            brought=-grid.images * float((inlet * supplied.flow + outside * ends.flow).sum()),
        )

    def _around(
        self, film: FilmState, gap: Floats, q: Floats, slope: Floats, speed: float, *, shorter: Floats | float
    ) -> _Flow:
        """Flow to the next angle, at the filled share of the cell from which the journal carries the oil.

        `shorter`: length of what conducts between two cells over the distance of their middles.
        """
        grid = self.grid
        falls, drags = grid.dz / grid.dx / (12 * self.oil.viscosity), grid.dz * speed / 2
        middle = (gap + _next(gap)) / 2
        square = falls * middle * middle / shorter
        drop, conducts = _next(q) - q, square * middle
        from_here = speed >= 0
        upstream, full = (film.fill, film.full) if from_here else (_next(film.fill), _next(film.full))
        by_middle = (drags * upstream - 3 * square * drop) / 2
        by_film = [conducts * slope, -conducts * _next(slope)]
        by_film[0 if from_here else 1] += np.where(full, 0.0, drags * middle)
        pushed, rise = conducts * drop, _next(film.pressure) - film.pressure
        return _Flow(drags * upstream * middle - pushed, by_film, (by_middle, by_middle), pushed * rise)

    def _along(
        self, film: FilmState, gap: Floats, q: Floats, slope: Floats, shorter: Floats | float
    ) -> _Flow:
        """Flow to the next cell along the width; none from the last."""
        grid = self.grid
        middle = gap.copy()
        middle[:, :-1] = (gap[:, :-1] + gap[:, 1:]) / 2
        square = grid.dx / (12 * self.oil.viscosity) * middle * middle
        square[:, :-1] /= np.diff(grid.z) * shorter
        square[:, -1] = 0.0
        conducts = square * middle
        drop, rise, beyond = (np.concatenate([v[:, 1:], v[:, -1:]], 1) for v in (q, film.pressure, slope))
        drop, rise = drop - q, rise - film.pressure
        flow, by_middle = -conducts * drop, -1.5 * square * drop
        by_film = conducts * slope, -conducts * beyond
        return _Flow(flow, by_film, (by_middle, by_middle), -flow * rise)

    def _drained(
        self,
        film: FilmState,
        gap: Floats,
        potential: tuple[Floats, Floats],
        conducts: Floats,
        around: Floats | float,
    ) -> _Flow:
        """Flow out of cells to oil of a pressure around them, through what conducts with h³."""
        (q, slope), oil = potential, self.oil
        beyond = _potential(oil, around) if isinstance(around, float) else oil.generalised(around)[0]
        out = conducts * (q - beyond)
        return _Flow(out, [conducts * slope], [3 * out / gap], out * (film.pressure - around))

    def _entries(self, around: Sequence[Floats], along: Sequence[Floats]) -> Floats:
        """Entries (5, n_angle, n_width) of flows' derivatives by the cells on both sides of a face."""
        entries = np.zeros((5, *self.grid.shape))
        entries[0] = around[0] - _last(around[1]) + along[0]
        entries[0, :, 1:] -= along[1][:, :-1]
        entries[1], entries[2] = around[1], -_last(around[0])
        entries[3, :, :-1] = along[1][:, :-1]
        entries[4, :, 1:] = -along[0][:, :-1]
        return entries

    def friction(
        self, film: FilmState, gap: Floats, speed: float, *, full_shear: bool = False
    ) -> tuple[float, float]:
        """Force of the film against the journal's motion, N, and the power that shear dissipates, N·mm/s.

        Of the gap that is partly filled, the filled share is sheared, or, with `full_shear`, all of it.
        """
        grid = self.grid
        share = np.ones(grid.shape) if full_shear else np.maximum(film.fill, 0.0)
        viscosity = self.oil.viscosity * self.oil.relative_viscosity(film.pressure)
        sheared = grid.total(share * viscosity / gap) * speed
        middle = (gap + _next(gap)) / 2
        rises = _next(film.pressure) - film.pressure
        pushed = grid.total(middle / 2 * rises) / grid.dx
        return sheared + pushed, sheared * speed
