"""When the first of many rods fail: B-lives over the places of a rod, and over the rods of an engine.

B10 is the number of cycles by which a tenth of all rods has failed. What differs between rods is log-normal:
strength, static strength and the mean pressure of a cylinder; batch and boost are common to the rods of an
engine. Pressure differs from cycle to cycle within every rod: there its mean damage counts, and the tail
where a life is unlimited.

By N cycles a place fails whose strength, over the median, is below the critical one, at which its damage is
1/N. Given the loads the share of such places is known in closed form, so that loads alone are sampled:
conditional Monte Carlo (Rubinstein & Kroese, Simulation and the Monte Carlo Method, section 5.4), with
scrambled Sobol points (Owen 1998). So a share of 1e-9 takes no more samples than one of a half. The error is
that of the mean of independently scrambled replicates.

Places of a rod may depend on one another in any positive way: max P_i ≤ P ≤ 1 − Π (1 − P_i).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri

from fea.judge.cycle_life import TAIL
from fea.judge.fatigue import LifeLine
from geometry.arrays import Floats, Ints

# Scrambled replicates; loads of rods in each; and common causes with rods of each, of engines.
_REPLICATES, _LOADS, _COMMON, _OF_EACH = 8, 256, 64, 32
# Logarithms of strength over median between which critical ones are looked for, and those of tables.
_STRENGTHS = np.linspace(-1.5, 1.5, 601)
# Standard deviations from the median of static strengths for which places have responses; and from the mean
# of further causes for which they have.
STATIC, AWAY = np.linspace(-4.0, 4.0, 9), (-2.0, -1.0, 1.0, 2.0)
# Cycles beyond which a life counts as unlimited, and the least and largest share that is computed.
_LONGEST, _LEAST, _MOST = 1e15, 1e-15, 1 - 1e-15


@dataclass(frozen=True)
class Scatter:
    """Coefficients of variation of what differs."""

    strength: float = 0.0  #: strength between all rods
    batch: float = 0.0  #: the part of it that the rods of an engine share
    static_strength: float = 0.0  #: of the static strength by which mean stress is corrected
    cylinder_pressure: float = 0.0  #: of the mean gas load between the cylinders of an engine
    boost: float = 0.0  #: and between engines
    cycle_pressure: float = 0.0  #: of the gas load from cycle to cycle


def deviation(variation: float) -> float:
    """Standard deviation of the logarithm of a log-normal value, of its coefficient of variation."""
    return math.sqrt(math.log1p(variation**2))


@dataclass(frozen=True)
class Place:
    """A region that can fail, such as a fillet, an edge of a bore or a bolt: one of `count` equal ones."""

    name: str
    count: int
    line: LifeLine  #: the median S–N line of the place
    gas: Floats  #: (n_gas,) rising gas load factors, of which two at least
    amplitude: Floats  #: (n_gas, n) amplitudes of fully reversed stress of the cycles of a period, MPa
    #: (n_gas, len(STATIC)) logarithm of the largest of them over that at median static strength
    static: Floats | None = None
    #: (n_causes, len(AWAY)) by how much the logarithm of amplitude over strength grows with further causes
    responses: Floats = field(default_factory=lambda: np.zeros((0, len(AWAY))))
    rate: Floats | None = None  #: (n_gas, n) how often each cycle occurs in a period; once, if none are given
    assumed: bool = False  #: whether the S–N line is
    node: int | None = None  #: on the whole rod, but of bolts

    @property
    def often(self) -> Floats:
        """How often (n_gas, n) each cycle occurs in a period."""
        return np.ones_like(self.amplitude) if self.rate is None else self.rate

    def damage(self, scatter: float) -> Floats:
        """Logarithm of the mean damage of a period (n_gas, n) at strengths `_STRENGTHS`.

        `scatter`: coefficient of variation of the gas load from cycle to cycle, which is normal.
        """
        reversed_ = self.amplitude[:, :, None] / np.exp(_STRENGTHS)
        cycles = self.line.cycles(reversed_.reshape(-1, 1)).reshape(reversed_.shape)
        of_gas = np.log((self.often[..., None] / cycles).sum(axis=1) + np.finfo(float).tiny)
        places, weights = np.polynomial.hermite_e.hermegauss(9 if scatter else 1)
        seen = np.maximum(self.gas[:, None] * (1 + scatter * places), 0)
        after, share = _cell(seen, self.gas)
        damage = np.exp((1 - share[..., None]) * of_gas[after - 1] + share[..., None] * of_gas[after])
        return np.asarray(np.log(np.einsum("q,gqs->gs", weights / weights.sum(), damage)))

    def tail(self, scatter: float) -> Floats:
        """Logarithm (n_gas,) of the largest amplitude of single cycles over the endurance limit."""
        factors = self.gas * (1 + TAIL * scatter * np.array([[-1.0], [0.0], [1.0]]))
        largest = np.interp(factors, self.gas, self.amplitude.max(axis=1)).max(axis=0)
        return np.asarray(np.log(np.maximum(largest, np.finfo(float).tiny) / float(self.line.limit[0])))


def responded(away: Floats, response: Floats) -> Floats:
    """Interpolate a response (len(AWAY),) at deviations (…) from the mean: beyond the ends, straight on."""
    (lowest, low, high, highest), far = response, 2 * AWAY[-1]
    values = [3 * lowest - 2 * low, lowest, low, 0.0, high, highest, 3 * highest - 2 * high]
    return np.asarray(np.interp(away, [-far, *AWAY[:2], 0.0, *AWAY[2:], far], values))


class BLife(NamedTuple):
    """When a share has failed."""

    cycles: float  #: infinite if it never does
    error: float = 0.0  #: standard error of the sampling, relative


class FirstFailure:
    """Rods with several places that can fail; `seed` of the samples."""

    samples = _REPLICATES * _LOADS  #: loads of rods

    def __init__(self, places: Sequence[Place], scatter: Scatter, seed: int = 0) -> None:
        self.places, self._scatter, self._seed = places, scatter, seed
        self._causes = len(places[0].responses)

    def of_place(self, number: int, share: float) -> BLife:
        """Return when a place has failed in a share of the rods."""
        return _solved(share, lambda cycles: self._shares(cycles, [number])[0])

    def of_rod(self, share: float) -> BLife:
        """Return when a share of the rods has failed, if their places fail independently."""
        return _solved(share, lambda cycles: self._any(self._shares(cycles)))

    def of_engine(self, share: float, rods: int) -> BLife:
        """Return when a share of the engines has lost the first of so many rods, likewise."""
        return _solved(share, lambda cycles: self._lost(cycles, rods))

    def failed(self, cycles: float) -> tuple[float, float]:
        """Return the share of rods that have failed by some cycles, at least and at most."""
        shares = self._shares(cycles)
        return float(shares.mean(axis=1).max()), float(self._any(shares).mean())

    def _any(self, shares: Floats) -> Floats:
        """1 − Π (1 − P_i) of shares (n_places, …), every one of equal places counted."""
        each = (
            place.count * np.log1p(-np.minimum(of, _MOST))
            for place, of in zip(self.places, shares, strict=True)
        )
        return np.asarray(-np.expm1(sum(each)))

    def _shares(self, cycles: float, numbers: Sequence[int] | None = None) -> Floats:
        """Shares (n_places, n_replicates) of some places, or of all, that have failed by some cycles."""
        every, places = deviation(self._scatter.strength), self._places_of_rods
        chosen = places if numbers is None else [places[number] for number in numbers]
        return np.array([_below(of.critical(cycles), every).mean(axis=1) for of in chosen])

    def _lost(self, cycles: float, rods: int) -> Floats:
        """Share (n_replicates,) of engines of which a rod has failed: the mean over their common causes."""
        batch = deviation(self._scatter.batch)
        own = math.sqrt(max(deviation(self._scatter.strength) ** 2 - batch**2, 0.0))
        common = batch * self._common[..., 0, None]
        failed = [_below(of.critical(cycles) - common, own).mean(axis=2) for of in self._places_of_engines]
        of_rod = np.minimum(self._any(np.array(failed)), _MOST)
        return np.asarray(-np.expm1(rods * np.log1p(-of_rod)).mean(axis=1))

    @cached_property
    def _places_of_rods(self) -> list["_Critical"]:
        """The places under loads (n_replicates, n) of rods."""
        z, scatter = _normal(_LOADS, 3 + self._causes, self._seed), self._scatter
        gas = np.exp(deviation(scatter.cylinder_pressure) * z[..., 0] + deviation(scatter.boost) * z[..., 1])
        return [_Critical(place, scatter.cycle_pressure, gas, z[..., 2:]) for place in self.places]

    @cached_property
    def _common(self) -> Floats:
        """Standard normal values (n_replicates, n_common, 2) of batch and engine."""
        return _normal(_COMMON, 2, self._seed + 1)

    @cached_property
    def _places_of_engines(self) -> list["_Critical"]:
        """The places under loads (n_replicates, n_common, n) of rods with common causes."""
        z, scatter = _normal(_OF_EACH, 2 + self._causes, self._seed + 2)[:, None], self._scatter
        engine = deviation(scatter.boost) * self._common[..., 1, None]
        gas = np.exp(deviation(scatter.cylinder_pressure) * z[..., 0] + engine)
        own = np.broadcast_to(z[..., 1:], (*gas.shape, 1 + self._causes))
        return [_Critical(place, scatter.cycle_pressure, gas, own) for place in self.places]


class _Critical:
    """Logarithm of the strength, over the median, below which a place fails, under loads of one shape.

    `cycle`: scatter of the gas load from cycle to cycle; `gas`: factors of its mean; `others` (…, 1 +
    n_causes): standard deviations of the static strength from its median, and of further causes.
    """

    def __init__(self, place: Place, cycle: float, gas: Floats, others: Floats) -> None:
        self._place, self._damage, self._tail = place, place.damage(cycle), place.tail(cycle)
        self._after, self._part = _cell(gas, place.gas)
        self._more = np.zeros_like(gas)
        for number, response in enumerate(place.responses, 1):
            self._more = self._more + responded(others[..., number], response)
        if place.static is not None:
            j, t = _cell(others[..., 0], STATIC)
            before, after = (
                (1 - t) * place.static[i, j - 1] + t * place.static[i, j]
                for i in (self._after - 1, self._after)
            )
            self._more = self._more + (1 - self._part) * before + self._part * after

    def critical(self, cycles: float) -> Floats:
        """Return it for failure by some cycles."""
        log, place, line = math.log(cycles), self._place, self._place.line
        at = np.array([np.interp(log, -of_gas, _STRENGTHS) for of_gas in self._damage])
        if line.gentle is not None:
            largest = place.amplitude.argmax(axis=1)[:, None]
            often = cycles / line.knee * np.take_along_axis(place.often, largest, axis=1)[:, 0]
            at = np.minimum(at, self._tail + np.log(np.maximum(often, 1.0)) / line.gentle)
        return np.asarray((1 - self._part) * at[self._after - 1] + self._part * at[self._after] + self._more)


def _cell(values: Floats, grid: Floats) -> tuple[Ints, Floats]:
    """Number of the point of a grid that follows each value, and how far the value is on the way to it."""
    after = np.clip(np.searchsorted(grid, values), 1, len(grid) - 1)
    return after, np.clip((values - grid[after - 1]) / (grid[after] - grid[after - 1]), 0, 1)


def _solved(share: float, failed: Callable[[float], Floats]) -> BLife:
    """Return the cycles at which what has failed (n_replicates,) reaches a share."""

    def away(log: float) -> float:
        """Return the distance on the scale of the normal distribution, where it is almost straight."""
        reached = float(np.clip(failed(math.exp(log)).mean(), _LEAST, _MOST))
        return float(ndtri(reached) - ndtri(share))

    low, high = 0.0, math.log(_LONGEST)
    if away(high) <= 0:
        return BLife(math.inf)
    if away(low) >= 0:
        return BLife(1.0)
    log = brentq(away, low, high, xtol=1e-5)
    there, later = failed(math.exp(log)), failed(math.exp(log + 0.01))
    slope = max(float(later.mean() - there.mean()) / 0.01, np.finfo(float).tiny)
    return BLife(math.exp(log), float(there.std(ddof=1)) / math.sqrt(_REPLICATES) / slope)


def _normal(count: int, dimensions: int, seed: int) -> Floats:
    """Standard normal values (n_replicates, count, dimensions), each replicate scrambled by itself."""
    from scipy.stats import qmc  # noqa: PLC0415 - who asks for no B-life does without

    rng = np.random.default_rng(seed)
    every = [qmc.Sobol(dimensions, rng=own).random(count) for own in rng.spawn(_REPLICATES)]
    return np.asarray(ndtri(np.clip(every, 1e-12, 1 - 1e-12)))


def _below(log: Floats, spread: float) -> Floats:
    """Share of log-normal strengths of median 1 that are below others, given by their logarithms."""
    return np.asarray(ndtr(log / spread) if spread else (log > 0).astype(float))
