"""What limits a rod that a search tries: stress at each place, buckling, and the oil film of its big end."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fea.analysis.buckling import buckling_report
from fea.analysis.film import FilmResult
from fea.analysis.prepare import PreparedRod
from fea.analysis.speed import SpeedResult
from fea.base.units import UM
from fea.solid.errors import FilmError
from fea.study.option_tables import OptimiseTable
from fea.study.study import Study
from geometry.arrays import Mask

YIELDING, FATIGUE, BUCKLING = "yielding", "fatigue", "buckling"
# The factor of this limit is the smallest film, µm.
FILM = "oil film, big end, µm"
# Of the film that is required, what one counts at most that starves, overheats or is not solved.
_UNSOUND = 0.5
_PLACES = ("big end", "shank", "small end")


def required(study: Study) -> dict[str, float]:
    """Return the safety factors and the film, less their error bars, that a study asks for, by mode."""
    table, usual = study.optimise or OptimiseTable(), study.analysis.min_safety or 1.0
    asked = (table.min_yield_safety, table.min_fatigue_safety, table.min_buckling_safety)
    factors = {mode: own or usual for mode, own in zip((YIELDING, FATIGUE, BUCKLING), asked, strict=True)}
    return factors if table.min_film_um is None else factors | {FILM: table.min_film_um}


@dataclass(frozen=True)
class Limit:
    """A limit on a rod, by mode of failure and place: ``"fatigue, shank"``.

    `factor` is the smallest safety factor there over all speeds, `error_percent` the error bar of the stress
    behind it, `required` what the factor less its bar must reach; of `FILM`, all are of the film's thickness.
    """

    name: str
    factor: float
    error_percent: float
    required: float

    @property
    def low(self) -> float:
        """The factor if the stress is higher by its error bar."""
        return self.factor / (1 + self.error_percent / 100)

    @property
    def margin(self) -> float:
        """Share of what the rod may bear that is left, at most 1; linear in the stress, so smooth."""
        return 1 - self.required / self.low


def limits(
    rod: PreparedRod,
    results: Sequence[SpeedResult],
    asked: Mapping[str, float],
    films: Sequence["Thinnest"] = (),
) -> tuple[Limit, ...]:
    """Return the limits of a rod that is solved at all speeds; each is the worst of them.

    Stress limits the rod in both ends and in the shank, each by itself: the largest stress of one place
    changes smoothly with the dimensions, that of the whole rod has a kink wherever the place changes. Raises
    `SingularMatrixError`: see `fea.analysis.buckling.buckling_report`.
    """
    worst: dict[str, Limit] = {}
    if films:
        worst[FILM] = min((film.limit(asked[FILM]) for film in films), key=lambda limit: limit.margin)
    for result in results:
        for limit in (*_of_stress(rod, result, asked), *_of_buckling(rod, result, asked)):
            if limit.name not in worst or limit.margin < worst[limit.name].margin:
                worst[limit.name] = limit
    return tuple(worst.values())


def _of_stress(rod: PreparedRod, result: SpeedResult, asked: Mapping[str, float]) -> list[Limit]:
    bar = max(case.error_percent for case in result.cases.values())
    if result.cycle is None:
        counts = np.all([case.counts for case in result.cases.values()], axis=0)
        factors = {YIELDING: np.min([case.of_rod for case in result.cases.values()], axis=0)}
    else:
        counts, envelope = result.cycle.counts, result.cycle.envelope
        factors = {YIELDING: 1 / np.maximum(envelope.usage, 1e-300)}
        if envelope.fatigue_factor is not None:
            factors[FATIGUE] = np.where(np.isnan(envelope.fatigue_factor), np.inf, envelope.fatigue_factor)
    limits_here = []
    for place, own in zip(_PLACES, _places(rod), strict=True):
        here = own & counts
        for mode, factor in factors.items():
            least = float(factor[here].min(initial=np.inf))
            if np.isfinite(least):
                limits_here.append(Limit(f"{mode}, {place}", least, bar, asked[mode]))
    return [*limits_here, *_of_edges(result, asked)]


def _of_edges(result: SpeedResult, asked: Mapping[str, float]) -> list[Limit]:
    edges = [edge for case in result.cases.values() for edge in case.sharp_mattering]
    if not edges:
        return []
    worst = min(edges, key=lambda edge: edge.safety_factor / (1 + edge.error_percent / 100))
    return [
        Limit(f"{YIELDING}, sharp edge", float(worst.safety_factor), worst.error_percent, asked[YIELDING])
    ]


def _places(rod: PreparedRod) -> tuple[Mask, Mask, Mask]:
    """Nodes (n_nodes,) of big end, shank and small end."""
    x, bores = rod.mesh.whole.points[:, 0], rod.mesh.bores
    shape = rod.study.rod.dimensions
    if shape is None:
        raise ValueError("only a rod with dimensions has places")
    big, small = x <= shape.big_end_radius, x >= bores.rod_length - shape.small_end_radius
    return big, ~(big | small), small


def _of_buckling(rod: PreparedRod, result: SpeedResult, asked: Mapping[str, float]) -> list[Limit]:
    figures = buckling_report(rod, result).figures
    column = [
        Limit(f"{BUCKLING}, {plane.replace('_', ' ')}", one.safety_factor, 0.0, asked[BUCKLING])
        for plane, one in figures.column.planes.items()
        if one.safety_factor is not None
    ]
    modes = [mode.factor for own in (figures.modes or {}).values() for mode in own]
    solid = [Limit(f"{BUCKLING}, of the solid", min(modes), 0.0, asked[BUCKLING])] if modes else []
    return [*column, *solid]


@dataclass(frozen=True)
class Thinnest:
    """The smallest film of a rod at one speed, µm; whether it is sound, neither starving nor too hot."""

    coarse: float  #: of the coarse grid
    #: That of the fine grid over it, and its error, percent: of this rod, or of another one
    finer: tuple[float, float]
    sound: bool

    @classmethod
    def of(cls, found: FilmResult) -> "Thinnest":
        """Take it from a whole result."""
        fine, coarse = (float(film.thinnest.min()) / UM for film in (found.cycle, found.coarse))
        return cls(coarse, (fine / coarse, found.figures.h_min_error_percent), found.sound)

    @classmethod
    def like(cls, rod: PreparedRod, rpm: float, finer: tuple[float, float]) -> "Thinnest":
        """Compute it on the coarse grid, with what the fine one changed for another rod."""
        try:
            film = rod.films.coarse(rod.crank_cycle(rpm))
        except FilmError:
            return cls(math.inf, finer, sound=False)
        return cls(float(film.thinnest.min()) / UM, finer, sound=not (film.starved or film.too_hot))

    def limit(self, required: float) -> Limit:
        """The limit that it is."""
        finer, error = self.finer
        thickness = self.coarse * finer
        if not self.sound:
            thickness = min(thickness, _UNSOUND * required)
        return Limit(FILM, thickness, error, required)
