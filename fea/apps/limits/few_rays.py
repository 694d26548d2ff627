"""Costly additions to the map, found on a few of its rays: the line of the oil film, and hours of life.

The film is that of the big end, and its line is where it becomes thinner than its surfaces are rough. The
load is found by root finding on coarse films, and its logarithm is interpolated between the rays.

Along a ray all loads grow together, so that the number of crank cycles to failure falls nearly as a power of
the load. Its logarithm is found at a few loads of a few rays and interpolated between them.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from fea.analysis.life import CYCLES_PER_HOUR
from fea.analysis.prepared_rod import PreparedRod
from fea.apps.limits.engine import ScaledEngine
from fea.apps.limits.factors import FailureMode, ModeFactor, RodFactors
from fea.apps.limits.limit_map import LimitMap, LimitPoint, Point
from fea.base.root import root
from fea.pins.lubrication import crank_angles
from fea.solid.errors import ContactError, FilmError
from geometry.arrays import Floats, Ints

_FILM_RAYS = 4
_WITHIN = 0.04  # of the thickness; a coarse film is 10 to 20 % thinner than a fine one
_STARVED = 0.5  # at most, over the roughness, where the supply cannot keep the film full
# Rays on which the number of cycles is found, also where factors are costly; and the utilisations against
# fatigue, over the required factor.
_LIFE_RAYS, _OF_COSTLY, _USAGE = 5, 3, np.geomspace(0.7, 2.2, 8)


def _some(rays: Ints, count: int) -> Ints:
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
    some = _some(np.arange(angles.size), _FILM_RAYS)
    loads, thinnest_at = np.full(some.size, np.inf), dict[Point, float]()

    def level(point: Point) -> float:
        film = films.coarse(engine.cycle(*point))
        thinnest_at[point] = float(crank_angles(film.thinnest.size)[film.thinnest.argmin()])
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
    undamaged: float  #: utilisation up to which life is unlimited: 0 for metals without an endurance limit

    def hours(self, rpm: Floats, scale: Floats) -> Floats:
        """Hours of running at points (…); infinite without damage, NaN far beyond the endurance limit."""
        usage = 1 / self.of_rays.factors(rpm, scale)[FailureMode.FATIGUE]
        angle, _ = self.of_rays.axes.ray(rpm, scale)
        level = np.log(usage.ravel())
        by_ray = np.stack([np.interp(level, np.log(_USAGE), row, right=np.nan) for row in self.logarithms])
        pairs = zip(angle.ravel().tolist(), by_ray.T, strict=True)
        cycles = 10 ** np.array([np.interp(at, self.angles, values) for at, values in pairs])
        hours = cycles.reshape(usage.shape) / (CYCLES_PER_HOUR * np.asarray(rpm))
        return np.asarray(np.where(usage <= self.undamaged, np.inf, hours))


def life_map(model: RodFactors, engine: ScaledEngine, of_rays: LimitMap, required: float) -> LifeMap | None:
    """Find the life over the map; None where no limit by fatigue or no S–N line is known."""
    limits = of_rays.loads.get(FailureMode.FATIGUE, np.zeros(0))
    rays = np.flatnonzero(np.isfinite(limits))
    if not rays.size or model.endurance is None:
        return None
    still = of_rays.rest.get(FailureMode.FATIGUE, 0.0)
    some = _some(rays, _OF_COSTLY if model.costly else _LIFE_RAYS)
    logarithms = np.full((some.size, _USAGE.size), np.nan)
    for row, ray in enumerate(some):
        for column, load in enumerate(limits[ray] * (_USAGE - still) / (1 - still)):
            if load <= 0:  # utilised more before anything loads it
                continue
            point = of_rays.axes.point(float(of_rays.angles[ray]), float(load))
            try:
                cycles = model.life(engine.cycle(*point), estimated=True)
            except ContactError:  # no state of contact carries the load
                break
            logarithms[row, column] = math.log10(cycles)
    return LifeMap(of_rays, of_rays.angles[some], logarithms, required if model.endurance else 0.0)


def hours_at(model: RodFactors, engine: ScaledEngine, rpm: float) -> float:
    """Hours at the study's load and a speed, rpm; infinite without damage."""
    cycle = engine.cycle(rpm, engine.full_load_scale(rpm))
    if model.endurance and model.at(cycle)[FailureMode.FATIGUE].factor >= 1:
        return math.inf
    return model.life(cycle) / (CYCLES_PER_HOUR * rpm)
