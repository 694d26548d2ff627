"""Constraints of the search: stress at each place, buckling, and the oil film of the big end."""

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
# The factor of this constraint is the smallest film, µm.
FILM = "oil film, big end, µm"
# A film that starves, overheats or is not solved counts at most as this share of the required one.
_UNSOUND = 0.5


def required(study: Study) -> dict[str, float]:
    """Return the safety factors and the film, less their error bars, that a study requires, by mode."""
    table, usual = study.optimise or OptimiseTable(), study.analysis.min_safety or 1.0
    given = (table.min_yield_safety, table.min_fatigue_safety, table.min_buckling_safety)
    factors = {mode: own or usual for mode, own in zip((YIELDING, FATIGUE, BUCKLING), given, strict=True)}
    return factors if table.min_film_um is None else factors | {FILM: table.min_film_um}


@dataclass(frozen=True)
class Constraint:
    """A constraint on a rod, by mode of failure and place: ``"fatigue, shank"``.

    `factor` is the smallest safety factor there over all speeds, `error_percent` the error bar of the stress
    behind it, `required` the least factor less its bar; of `FILM`, all are of the film's thickness.
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
        """Unused share of the permissible stress, at most 1; linear in the stress, so smooth."""
        return 1 - self.required / self.low


@dataclass(frozen=True)
class MinimumFilm:
    """The minimum film thickness of a rod at one speed."""

    coarse: float  #: µm, on the coarse grid
    correction: tuple[float, float]  #: ratio of fine to coarse grid, and its error, percent, of any such rod
    sound: bool  #: neither starving nor too hot

    @classmethod
    def of(cls, result: FilmResult) -> "MinimumFilm":
        """Take it from a film on both grids."""
        fine, coarse = (float(film.thinnest.min()) / UM for film in (result.cycle, result.coarse))
        return cls(coarse, (fine / coarse, result.figures.h_min_error_percent), result.sound)

    @classmethod
    def corrected(cls, rod: PreparedRod, rpm: float, correction: tuple[float, float]) -> "MinimumFilm":
        """Compute it on the coarse grid, to be corrected as that of another rod."""
        try:
            film = rod.films.coarse(rod.crank_cycle(rpm))
        except FilmError:
            return cls(math.inf, correction, sound=False)
        return cls(float(film.thinnest.min()) / UM, correction, sound=not (film.starved or film.too_hot))

    def constraint(self, required: float) -> Constraint:
        """Return the constraint of this film."""
        ratio, error = self.correction
        thickness = self.coarse * ratio
        return Constraint(
            FILM, thickness if self.sound else min(thickness, _UNSOUND * required), error, required
        )


def constraints(
    rod: PreparedRod,
    results: Sequence[SpeedResult],
    required: Mapping[str, float],
    films: Sequence[MinimumFilm] = (),
) -> tuple[Constraint, ...]:
    """Return the constraints of a rod that is solved at all speeds; each is the worst of them.

    Stress is constrained in both ends and in the shank, each by itself: the largest stress of one place
    changes smoothly with the dimensions, that of the whole rod has a kink wherever the place changes. Raises
    `SingularMatrixError`: see `fea.analysis.buckling.buckling_report`.
    """
    every = [film.constraint(required[FILM]) for film in films]
    for result in results:
        every += [*_of_stress(rod, result, required), *_of_buckling(rod, result, required[BUCKLING])]
    names = dict.fromkeys(constraint.name for constraint in every)
    return tuple(
        min((one for one in every if one.name == name), key=lambda one: one.margin) for name in names
    )


def _of_stress(rod: PreparedRod, result: SpeedResult, required: Mapping[str, float]) -> list[Constraint]:
    bar = max(case.error_percent for case in result.cases.values())
    if result.cycle is None:
        counts = np.all([case.counts for case in result.cases.values()], axis=0)
        factors = {YIELDING: np.min([case.of_rod for case in result.cases.values()], axis=0)}
    else:
        counts, envelope = result.cycle.counts, result.cycle.envelope
        factors = {YIELDING: 1 / np.maximum(envelope.usage, 1e-300)}
        if envelope.fatigue_factor is not None:
            factors[FATIGUE] = np.where(np.isnan(envelope.fatigue_factor), np.inf, envelope.fatigue_factor)
    found = []
    for place, nodes in _places(rod).items():
        for mode, factor in factors.items():
            least = float(factor[nodes & counts].min(initial=np.inf))
            if np.isfinite(least):
                found.append(Constraint(f"{mode}, {place}", least, bar, required[mode]))
    edges = [
        Constraint(f"{YIELDING}, sharp edge", edge.safety_factor, edge.error_percent, required[YIELDING])
        for case in result.cases.values()
        for edge in case.sharp_mattering
    ]
    return found + edges


def _places(rod: PreparedRod) -> dict[str, Mask]:
    """Nodes (n_nodes,) of big end, shank and small end."""
    x, bores = rod.mesh.whole.points[:, 0], rod.mesh.bores
    shape = rod.study.rod.dimensions
    if shape is None:
        raise ValueError("only a rod with dimensions has places")
    big, small = x <= shape.big_end_radius, x >= bores.rod_length - shape.small_end_radius
    return {"big end": big, "shank": ~(big | small), "small end": small}


def _of_buckling(rod: PreparedRod, result: SpeedResult, required: float) -> list[Constraint]:
    figures = buckling_report(rod, result).figures
    column = [
        Constraint(f"{BUCKLING}, {plane.replace('_', ' ')}", one.safety_factor, 0.0, required)
        for plane, one in figures.column.planes.items()
        if one.safety_factor is not None
    ]
    modes = [mode.factor for own in (figures.modes or {}).values() for mode in own]
    return [*column, *(Constraint(f"{BUCKLING}, of the solid", factor, 0.0, required) for factor in modes)]
