"""The map of limits: where each mode of failure begins on rays from rest through speed squared and gas.

Two additions are costly and found on a few rays. The line of the oil film, that of the big end, is where it
becomes thinner than its surfaces are rough: a root on coarse films, whose logarithm is interpolated between
the rays. Along a ray all loads grow together, so that the number of crank cycles to failure falls nearly as a
power of the load: its logarithm is found at a few loads and interpolated.
"""

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np

from fea.analysis.cycle.figures import cycle_life_figures
from fea.analysis.life_figures import CycleLifeFigures
from fea.analysis.prepared_rod import PreparedRod
from fea.apps.limits.engine import ScaledEngine
from fea.apps.limits.factors import ONSETS, FailureMode, ModeFactor, RodFactors
from fea.base.root import root
from fea.pins.lubrication import crank_angles
from fea.solid.errors import ContactError, FilmError
from geometry.arrays import Floats, Ints
from loads.gas import LARGEST_PEAK

# Just below the largest pressure of any engine, MPa: the highest that is evaluated.
MOST_PEAK = 0.999 * LARGEST_PEAK
# Loads over that at yield beyond which stress is not elastic, and nothing is drawn.
ELASTIC = 1.2
# Loads on a ray are at most so many times those of about its limit.
_FURTHEST = 3.0
# Gas load factor on the ray of inertia, relative to that of the limit by gas alone.
_LEAST_GAS = 0.02

T = TypeVar("T")
Point = tuple[float, float]  # speed, rpm, and gas load factor


@dataclass(frozen=True)
class LimitPoint:
    """A point at which a safety factor is the required one."""

    mode: FailureMode
    rpm: float
    scale: float  #: gas load factor
    peak: float  #: absolute peak pressure, MPa
    worst: ModeFactor
    slope: float  #: d ln x/d ln f of the coordinate x along which it was found
    interpolated: bool = False  #: between points that were solved
    spread: float = 0.0  #: relative uncertainty of the coordinate where it is estimated


@dataclass(frozen=True)
class RayAxes:
    """Scales of the rays: about the limit by inertia alone, rpm, and by gas alone, gas load factor."""

    rpm: float
    scale: float

    def point(self, angle: float, load: float) -> Point:
        """Return the point of a ray at a distance from rest."""
        return self.rpm * math.sqrt(load * math.cos(angle)), load * self.scale * math.sin(angle)

    def ray(self, rpm: Floats | float, scale: Floats | float) -> tuple[Floats, Floats]:
        """Angles, rad, and distances from rest of points."""
        along, up = (np.asarray(rpm) / self.rpm) ** 2, np.asarray(scale) / self.scale
        return np.arctan2(up, along), np.hypot(along, up)

    def angles(self, engine: ScaledEngine, count: int) -> Floats:
        """Angles (n,) of the rays, from inertia alone to gas at idling speed, rad."""
        if not engine.burns:
            return np.zeros(1)
        return np.linspace(math.atan(_LEAST_GAS), math.atan2(1.0, (engine.idle / self.rpm) ** 2), count)

    def furthest(self, engine: ScaledEngine, angle: float) -> float:
        """Return the load on a ray that no engine exceeds by its speed or its pressure."""
        most = min(_FURTHEST, (engine.fastest / self.rpm) ** 2 / max(math.cos(angle), 1e-9))
        if engine.burns:
            rpm, _ = self.point(angle, most)
            most = min(most, engine.scale(rpm, MOST_PEAK) / self.scale / math.sin(angle))
        return most


@dataclass(frozen=True)
class LimitMap:
    """The limits of a rod in an engine."""

    axes: RayAxes
    angles: Floats  #: (n,) of the rays, rad
    #: (n,) distances of the limit of each mode from rest; infinite without one
    loads: Mapping[FailureMode, Floats]
    rest: Mapping[FailureMode, float]  #: utilisation of the required factor at rest, where it is not 0
    #: on each ray; None where none was found. Empty in a survey
    limits: Mapping[FailureMode, tuple[LimitPoint | None, ...]] = field(default_factory=dict)

    @property
    def points(self) -> list[LimitPoint]:
        """Every limit."""
        return [limit for line in self.limits.values() for limit in line if limit is not None]

    def factors(self, rpm: Floats, scale: Floats) -> dict[FailureMode, Floats]:
        """Estimate the factors over that required at points (n,): utilisations are linear between rays."""
        angle, load = self.axes.ray(rpm, scale)
        angle = np.clip(angle, self.angles[0], self.angles[-1])
        after = np.clip(np.searchsorted(self.angles, angle), 1, max(len(self.angles) - 1, 1))
        ends = np.append(self.angles, self.angles[-1] + 1.0)[np.stack([after - 1, after])]
        # A point is the sum of vectors along the rays beside it.
        shares = np.sin([ends[1] - angle, angle - ends[0]]) / np.sin(ends[1] - ends[0])
        factors = {}
        for mode, loads in self.loads.items():
            inverse, still = np.append(1 / loads, 0.0), self.rest.get(mode, 0.0)
            usage = (shares[0] * inverse[after - 1] + shares[1] * inverse[after]) * load
            with np.errstate(divide="ignore"):
                factors[mode] = 1 / (still + max(1 - still, 0.0) * usage)
        return factors

    def ending_factors(self, rpm: Floats | float, scale: Floats | float) -> dict[FailureMode, Floats]:
        """Return those of the modes that end the rod."""
        return ending(self.factors(np.asarray(rpm), np.asarray(scale)))

    def least(self, rpm: Floats | float, scale: Floats | float) -> Floats:
        """Return the least of these; infinite where nothing limits the rod."""
        return least_of(self.ending_factors(rpm, scale), np.asarray(rpm))


def ending(by_mode: Mapping[FailureMode, T]) -> dict[FailureMode, T]:
    """Return the entries of the modes that end a rod."""
    return {mode: value for mode, value in by_mode.items() if mode not in ONSETS}


def least_of(factors: Mapping[FailureMode, Floats], points: Floats) -> Floats:
    """Return the least of the factors at points; infinite where nothing limits the rod."""
    return np.min(list(factors.values()), axis=0) if factors else np.full(np.shape(points), np.inf)


_FILM_RAYS = 4  # on which the film is computed
_WITHIN = 0.04  # of the thickness; a coarse film is 10 to 20 % thinner than a fine one
_STARVED = 0.5  # at most, over the roughness, where the supply cannot keep the film full
# Rays on which the number of cycles is found, also where factors are costly; and the utilisations against
# fatigue, over the required factor.
_LIFE_RAYS, _OF_COSTLY, _USAGE = 5, 3, np.geomspace(0.7, 2.2, 8)


def few(rays: Ints, count: int) -> Ints:
    """Return so many rays, evenly spaced, the first and the last among them."""
    return np.unique(rays[np.linspace(0, rays.size - 1, count).round().astype(int)])


def with_film(
    rod: PreparedRod, engine: ScaledEngine, of_rays: LimitMap, show: Callable[[str], None]
) -> LimitMap:
    """Return the map with the line of the oil film; without one where the surfaces are smooth."""
    films, axes = rod.films, of_rays.axes
    if films.lubrication.asperities is None:
        return of_rays
    roughness, angles = films.lubrication.asperities.roughness, of_rays.angles
    some = few(np.arange(angles.size), _FILM_RAYS)
    loads, thinnest_at = np.full(some.size, np.inf), dict[Point, float]()

    def level(point: Point) -> float:
        film = films.coarse(engine.cycle(*point))
        steps = crank_angles(film.thinnest.size, engine.loading.engine.cycle)
        thinnest_at[point] = float(steps[film.thinnest.argmin()])
        ratio = float(film.thinnest.min()) / roughness
        return math.log(min(ratio, _STARVED) if film.starved else ratio)

    for number, angle in enumerate(angles[some].tolist()):
        show(f"oil film on ray {number + 1} of {some.size}")
        most = axes.furthest(engine, angle)
        start, ends = [min(1.0, most)], (0.0, most)
        with suppress(FilmError):
            edge = root(lambda load: level(axes.point(angle, load)), start, -1.0, ends, _WITHIN)  # noqa: B023 - called at once
            loads[number] = math.inf if edge is None else edge.x
    with np.errstate(invalid="ignore"):  # beside a ray without a limit there is none
        every = np.exp(np.interp(angles, angles[some], np.log(loads)))
    every[~np.isfinite(every)] = math.inf

    def limit(angle: float, load: float) -> LimitPoint | None:
        if not math.isfinite(load):
            return None
        point = axes.point(angle, load)
        worst = ModeFactor(1.0, None, thinnest_at.get(point))
        interpolated = point not in thinnest_at
        return LimitPoint(FailureMode.FILM, *point, engine.peak(*point), worst, -1.0, interpolated)

    return replace(
        of_rays,
        loads={**of_rays.loads, FailureMode.FILM: every},
        limits={**of_rays.limits, FailureMode.FILM: tuple(map(limit, angles.tolist(), every.tolist()))},
    )


@dataclass(frozen=True)
class LifeMap:
    """Crank cycles to failure on rays."""

    of_rays: LimitMap
    angles: Floats  #: (n,) of the rays, rad
    logarithms: Floats  #: (n, k) of the numbers of cycles, to base 10, at the utilisations `_USAGE`
    #: (n,) utilisations up to which life is unlimited: 0 for metals without an endurance limit
    undamaged: Floats
    assumed: bool  #: whether an S–N line is assumed
    per_hour: float  #: cycles an hour at 1 rpm

    def hours(self, rpm: Floats, scale: Floats) -> Floats:
        """Hours of running at points (…); infinite without damage, NaN far beyond the endurance limit."""
        usage = 1 / self.of_rays.factors(rpm, scale)[FailureMode.FATIGUE]
        angle, _ = self.of_rays.axes.ray(rpm, scale)
        level = np.log(usage.ravel())
        by_ray = np.stack([np.interp(level, np.log(_USAGE), row, right=np.nan) for row in self.logarithms])
        pairs = zip(angle.ravel().tolist(), by_ray.T, strict=True)
        cycles = 10 ** np.array([np.interp(at, self.angles, values) for at, values in pairs])
        hours = cycles.reshape(usage.shape) / (self.per_hour * np.asarray(rpm))
        return np.asarray(np.where(self.of_unlimited(rpm, scale) <= 1, np.inf, hours))

    def of_unlimited(self, rpm: Floats, scale: Floats) -> Floats:
        """Utilisation at points (…) over that up to which life is unlimited."""
        usage = 1 / self.of_rays.factors(rpm, scale)[FailureMode.FATIGUE]
        angle, _ = self.of_rays.axes.ray(rpm, scale)
        with np.errstate(divide="ignore"):
            return np.asarray(usage / np.interp(angle, self.angles, self.undamaged))


def life_map(model: RodFactors, engine: ScaledEngine, of_rays: LimitMap, required: float) -> LifeMap | None:
    """Find the life over the map; None where no limit by fatigue or no S–N line is known."""
    limits = of_rays.loads.get(FailureMode.FATIGUE, np.zeros(0))
    rays = np.flatnonzero(np.isfinite(limits))
    if not rays.size or model.endurance is None:
        return None
    still = of_rays.rest.get(FailureMode.FATIGUE, 0.0)
    some = few(rays, _OF_COSTLY if model.costly else _LIFE_RAYS)
    logarithms, undamaged = np.full((some.size, _USAGE.size), np.nan), np.zeros(some.size)
    for row, ray in enumerate(some):
        if model.endurance:
            at_limit = engine.cycle(*of_rays.axes.point(float(of_rays.angles[ray]), float(limits[ray])))
            undamaged[row] = required / model.tail(at_limit)
        for column, load in enumerate(limits[ray] * (_USAGE - still) / (1 - still)):
            if load <= 0:  # utilised more before anything loads it
                continue
            point = of_rays.axes.point(float(of_rays.angles[ray]), float(load))
            try:
                cycles = model.smooth_life(engine.cycle(*point))
            except ContactError:  # no state of contact carries the load
                break
            logarithms[row, column] = math.log10(cycles)
    per_hour = engine.loading.engine.cycles_per_hour
    return LifeMap(of_rays, of_rays.angles[some], logarithms, undamaged, model.assumed, per_hour)


def life_at(model: RodFactors, engine: ScaledEngine, rpm: float) -> CycleLifeFigures | None:
    """Return the life at the study's load and a speed, rpm; None where no S–N line is known."""
    cycle = engine.cycle(rpm, engine.full_load_scale(rpm))
    found = model.life(cycle)
    return None if found is None else cycle_life_figures(found, cycle.engine.cycles_per_hour * rpm)
