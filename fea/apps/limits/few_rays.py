"""What is found on a few rays of the map, because it is costly: the line of the oil film, and hours of life.

The film is that of the big end, and its line where it becomes thinner than its surfaces are rough. A film
costs several static runs: on a few rays the load is found by root finding on coarse films, and its logarithm
is interpolated between them.

A rod has a life where its material has an S–N line. Along a ray all loads grow together, so that the number
of crank cycles to failure falls nearly as a power of the load. It is found at a few loads of a few rays; its
logarithm is interpolated between them.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from fea.analysis.life import CYCLES_PER_HOUR
from fea.analysis.prepare import PreparedRod
from fea.apps.limits.limit_map import Limit, LimitMap, Point, furthest
from fea.apps.limits.operation import Operation
from fea.apps.limits.states import Mode, States, Worst
from fea.base.root import root
from fea.pins.lubrication import crank_angles
from fea.solid.errors import ContactError, FilmError
from geometry.arrays import Floats

_OF_FILM = 4
_WITHIN = 0.04  # of the thickness; a coarse film is 10 to 20 % thinner than a fine one
_STARVED = 0.5  # at most, over the roughness, where the supply cannot keep the film full


def with_film(
    rod: PreparedRod, operation: Operation, of_rays: LimitMap, show: Callable[[str], None]
) -> LimitMap:
    """Return the map with the line of the oil film; without one where the surfaces are smooth."""
    films, axes = rod.films, of_rays.axes
    if films.lubrication.asperities is None:
        return of_rays
    rough, angles = films.lubrication.asperities.roughness, of_rays.angles
    some = np.unique(np.linspace(0, angles.size - 1, _OF_FILM).round().astype(int))
    loads, moments = np.full(some.size, np.inf), dict[Point, float]()

    def level(point: Point) -> float:
        film = films.coarse(operation.cycle(*point))
        moments[point] = float(crank_angles(film.thinnest.size)[film.thinnest.argmin()])
        ratio = float(film.thinnest.min()) / rough
        return math.log(min(ratio, _STARVED) if film.starved else ratio)

    for number, angle in enumerate(angles[some].tolist()):
        show(f"oil film on ray {number + 1} of {some.size}")
        most = furthest(operation, axes, angle)
        with suppress(FilmError):
            first = [min(1.0, most)]
            edge = root(lambda load: level(axes.point(angle, load)), first, -1.0, (0.0, most), _WITHIN)  # noqa: B023 - called at once
            loads[number] = math.inf if edge is None else edge.x
    with np.errstate(invalid="ignore"):  # beside a ray without a limit there is none
        every = np.exp(np.interp(angles, angles[some], np.log(loads)))
    every[~np.isfinite(every)] = math.inf

    def limit(angle: float, load: float) -> Limit | None:
        if not math.isfinite(load):
            return None
        point = axes.point(angle, load)
        worst = Worst(1.0, None, moments.get(point))
        return Limit(Mode.FILM, *point, operation.peak(*point), worst, -1.0, point not in moments)

    return replace(
        of_rays,
        loads={**of_rays.loads, Mode.FILM: every},
        limits={**of_rays.limits, Mode.FILM: tuple(map(limit, angles.tolist(), every.tolist()))},
    )


# Rays, and utilisations against fatigue, over the required factor, at which the number of cycles is found;
# and rays where states are costly.
_RAYS, _USAGE, _OF_COSTLY = 5, np.geomspace(0.7, 2.2, 8), 3


@dataclass(frozen=True)
class LifeMap:
    """Crank cycles to failure on rays."""

    of_rays: LimitMap
    angles: Floats  #: (n,) of the rays, rad
    logarithms: Floats  #: (n, k) of the numbers of cycles, to base 10, at the utilisations `_USAGE`
    endless: float  #: utilisation up to which nothing is damaged: 0 for metals without an endurance limit

    def hours(self, rpm: Floats, charge: Floats) -> Floats:
        """Hours at points (…), each kept up; infinite without damage, NaN far beyond the endurance limit."""
        usage = 1 / self.of_rays.factors(rpm, charge)[Mode.FATIGUE]
        angle, _ = self.of_rays.axes.ray(rpm, charge)
        level = np.log(usage.ravel())
        by_ray = np.stack([np.interp(level, np.log(_USAGE), own, right=np.nan) for own in self.logarithms])
        pairs = zip(angle.ravel().tolist(), by_ray.T, strict=True)
        cycles = 10 ** np.array([np.interp(at, self.angles, own) for at, own in pairs])
        hours = cycles.reshape(usage.shape) / (CYCLES_PER_HOUR * np.asarray(rpm))
        return np.asarray(np.where(usage <= self.endless, np.inf, hours))


def life_map(states: States, operation: Operation, of_rays: LimitMap, required: float) -> LifeMap | None:
    """Find the life over the map; None where no limit by fatigue or no S–N line is known."""
    limits = of_rays.loads.get(Mode.FATIGUE, np.zeros(0))
    rays = np.flatnonzero(np.isfinite(limits))
    if not rays.size or states.endless is None:
        return None
    count, still = _OF_COSTLY if states.costly else _RAYS, of_rays.rest.get(Mode.FATIGUE, 0.0)
    some = np.unique(rays[np.linspace(0, rays.size - 1, count).round().astype(int)])
    logarithms = np.full((some.size, _USAGE.size), np.nan)
    for row, ray in enumerate(some):
        for column, load in enumerate(limits[ray] * (_USAGE - still) / (1 - still)):
            if load <= 0:  # utilised more before anything loads it
                continue
            point = of_rays.axes.point(float(of_rays.angles[ray]), float(load))
            try:
                cycles = states.lasting(operation.cycle(*point), estimated=True)
            except ContactError:  # no state of contact carries so much
                break
            logarithms[row, column] = math.log10(cycles)
    return LifeMap(of_rays, of_rays.angles[some], logarithms, required if states.endless else 0.0)


def hours_at(states: States, operation: Operation, rpm: float) -> float:
    """Hours at today's load and a speed, rpm; infinite without damage."""
    cycle = operation.cycle(rpm, operation.today(rpm))
    if states.endless and states.at(cycle)[Mode.FATIGUE].factor >= 1:
        return math.inf
    return states.lasting(cycle) / (CYCLES_PER_HOUR * rpm)
