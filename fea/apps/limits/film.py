"""Where the oil film of the big end becomes thinner than its surfaces are rough, on rays of the map.

A film costs several static runs: on a few rays the load is found by root finding on coarse films, and its
logarithm is interpolated between them.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import numpy as np

from fea.analysis.prepare import PreparedRod
from fea.apps.limits.limit_map import Limit, LimitMap, Point, furthest, root
from fea.apps.limits.operation import Operation
from fea.apps.limits.states import Mode, Worst
from fea.pins.lubrication import crank_angles
from fea.solid.errors import FilmError

_RAYS = 4
_WITHIN = 0.04  # of the thickness; that of a coarse film errs by some percent
_STARVED = 0.5  # at most, over the roughness, where the supply cannot keep the film full


def with_film(
    rod: PreparedRod, operation: Operation, of_rays: LimitMap, show: Callable[[str], None]
) -> LimitMap:
    """Return the map with the line of the oil film; without one where the surfaces are smooth."""
    films, axes = rod.films, of_rays.axes
    if films.lubrication.asperities is None:
        return of_rays
    rough, angles = films.lubrication.asperities.roughness, of_rays.angles
    some = np.unique(np.linspace(0, angles.size - 1, _RAYS).round().astype(int))
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
            edge = root(lambda load: level(axes.point(angle, load)), most, [min(1.0, most)], _WITHIN)  # noqa: B023 - called at once
            loads[number] = math.inf if edge is None else edge[0]
    with np.errstate(invalid="ignore"):  # beside a ray without a limit there is none
        every = np.exp(np.interp(angles, angles[some], np.log(loads)))
    every[~np.isfinite(every)] = math.inf
    limits = list[Limit | None]()
    for angle, load in zip(angles.tolist(), every.tolist(), strict=True):
        point = axes.point(angle, load) if math.isfinite(load) else None
        near = None if point is None else moments.get(point)
        limits.append(
            None
            if point is None
            else Limit(Mode.FILM, *point, operation.peak(*point), Worst(1.0, None, near), -1.0, near is None)
        )
    return replace(
        of_rays,
        loads={**of_rays.loads, Mode.FILM: every},
        limits={**of_rays.limits, Mode.FILM: tuple(limits)},
    )
