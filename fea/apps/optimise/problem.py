"""The problem of the search: free dimensions of a rod between bounds, and constraints on it.

A constraint is on the stress at a place, on buckling and collapse, or on the oil film of the big end; of the
last rod, which is analysed as by `fea run`, also on flow, permanent set and the overload of the study.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fea.analysis.buckling import buckling_report
from fea.analysis.collapse import bending_figures
from fea.analysis.film import FilmResult
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.analysis.survival import COLLAPSE, LASTING_FLOW, OVERLOAD, SET, flaw_factors
from fea.base.units import UM
from fea.judge.cycle_life import strength_share
from fea.judge.fatigue import fatigue_factor
from fea.solid.errors import FilmError
from fea.study.option_tables import OptimiseTable
from fea.study.rod_table import dimension_of
from fea.study.study import Study
from geometry.arrays import Floats, Mask
from geometry.errors import InvalidValue, require
from geometry.section import OF_WALLS, walls

# Of a study that names none: the sizes that set mass and strength of shank and rings.
_USUAL = ("shank_width", "shank_depth_big_end", "shank_depth_small_end", "big_end_ring", "small_end_ring")
_USUAL_OF_I = ("web_thickness", "flange_thickness")
_OF_POCKET = (*_USUAL_OF_I, "pocket_corner_radius", "pocket_floor_radius", "pocket_setback")
# Their bounds, relative to the study's values.
_FROM, _TO = 0.6, 1.4
# Least wall of a study that gives none, mm: thinner webs and rings are hard to forge.
_LEAST_WALL = 3.0
_HALVINGS = 20
_ROUNDING = 1e-9
# Of the range of a dimension: a step that shows the rule that stops it.
_A_LITTLE = 0.01


@dataclass(frozen=True)
class Variables:
    """Free dimensions: (n,) keys of the [rod] table of a study, where they start, and their bounds, mm."""

    study: Study
    keys: tuple[str, ...]
    low: Floats
    high: Floats
    least_wall: float

    @property
    def start(self) -> Floats:
        """The study's own values (n,), scaled."""
        rod = self.study.rod.solid()
        values = np.array([getattr(rod, dimension_of(key)) for key in self.keys])
        return (values - self.low) / (self.high - self.low)

    def dimensions(self, x: Floats) -> dict[str, float]:
        """Return the dimensions, mm, by their keys, of scaled values (n,)."""
        values = self.low + x * (self.high - self.low)
        return dict(zip(self.keys, values.tolist(), strict=True))

    def study_at(self, x: Floats) -> Study:
        """Return the study of scaled values (n,); raises `InvalidValue`: they break a rule of the rod."""
        return self.study.with_rod(**self.dimensions(x))

    def fault(self, x: Floats) -> str:
        """Return why no rod of scaled values (n,) can be drawn with walls thick enough; "" if it can."""
        try:
            rod = self.study_at(x).rod.solid()
        except InvalidValue as error:
            return str(error)
        thinnest, where = min((wall, name) for name, wall in walls(rod).items())
        if thinnest >= self.least_wall * (1 - _ROUNDING):
            return ""
        return f"the {where} must be at least {self.least_wall:.4g} mm thick"

    def obstacles(self, x: Floats) -> dict[str, str]:
        """Return why free dimensions cannot be a little smaller or larger, by key; bounds are left out."""
        reasons = {}
        for number, key in enumerate(self.keys):
            for step, change in ((-_A_LITTLE, "smaller"), (_A_LITTLE, "larger")):
                beside = x.copy()
                beside[number] += step
                why = self.fault(beside) if 0 <= beside[number] <= 1 else ""
                if why:
                    reasons[f"{key.removesuffix('_mm')} cannot be {change}"] = why
        return reasons

    def nearest_feasible(self, x: Floats, sound: Floats) -> Floats:
        """Return the last sound values (n,) on the way to `x` from others that are sound."""
        if not self.fault(x):
            return x
        inside, outside = 0.0, 1.0
        for _ in range(_HALVINGS):
            middle = (inside + outside) / 2
            if not self.fault(sound + middle * (x - sound)):
                inside = middle
            else:
                outside = middle
        return sound + inside * (x - sound)


def variables(study: Study) -> Variables:
    """Return a study's free dimensions. Raises `InvalidValue`: there are none, or one is out of bounds."""
    rod, table = study.rod.solid(), study.optimise or OptimiseTable()
    usual = (*_USUAL, *(_USUAL_OF_I if rod.has_pockets else ()))
    bounds = {key: (bound[0], bound[1]) for key, bound in table.free.items()} or {
        f"{name}_mm": (_FROM * getattr(rod, name), _TO * getattr(rod, name)) for name in usual
    }
    for key, (low, high) in bounds.items():
        start = getattr(rod, dimension_of(key))
        rule = f"is 0 in this rod, so the feature is left out: it cannot vary from {low:g} to {high:g} mm"
        require(start > 0, f"rod.{key}", start, rule, "Give it a value, or do not name it as free.")
        rule = "cannot be free: the shank has no pockets, so that it has no effect"
        of_pocket = dimension_of(key) in _OF_POCKET and not (rod.shank_bore and key == "pocket_setback_mm")
        require(rod.has_pockets or not of_pocket, f"optimise.free.{key}", None, rule, "Leave it out.")
        rule = f"must lie between its bounds, {low:g} and {high:g} mm, where the search starts"
        require(low <= start <= high, f"rod.{key}", start, rule, "Widen the bounds.")
    thinnest, where = min((wall, name) for name, wall in walls(rod).items())
    least = min(_LEAST_WALL, thinnest) if table.least_wall_mm is None else table.least_wall_mm
    rule = f"must not exceed the walls of the rod, where the search starts: its {where} is {thinnest:.4g} mm"
    remedy = "Thicken the wall, or reduce the limit."
    require(least <= thinnest, "optimise.least_wall_mm", least, rule, remedy)
    low, high = np.array(list(bounds.values())).T
    a_wall = np.array([dimension_of(key) in OF_WALLS for key in bounds])
    return Variables(study, tuple(bounds), np.where(a_wall, np.maximum(low, least), low), high, least)


YIELDING, FATIGUE, BUCKLING = "yielding", "fatigue", "buckling"
# The factor of this constraint is that by which stress may grow until the rod lasts the hours and no more.
HOURS = "hours"
# The factor of this constraint is the smallest film, µm.
FILM = "oil film, big end, µm"
# A film that starves, overheats or is not solved counts at most as this share of the required one.
_UNSOUND = 0.5


def required(study: Study) -> dict[str, float]:
    """Return the safety factors and the film, less their error bars, that a study requires, by mode."""
    table, usual = study.optimise or OptimiseTable(), study.analysis.min_safety or 1.0
    given = (table.min_yield_safety, table.min_fatigue_safety, table.min_buckling_safety)
    factors = {mode: own or usual for mode, own in zip((YIELDING, FATIGUE, BUCKLING), given, strict=True)}
    if table.min_hours is not None:
        factors[HOURS] = table.min_hours
        if table.min_fatigue_safety is None:
            del factors[FATIGUE]
    return factors if table.min_film_um is None else factors | {FILM: table.min_film_um}


@dataclass(frozen=True)
class DesignConstraint:
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

    def constraint(self, required: float) -> DesignConstraint:
        """Return the constraint of this film."""
        ratio, error = self.correction
        thickness = self.coarse * ratio
        return DesignConstraint(
            FILM, thickness if self.sound else min(thickness, _UNSOUND * required), error, required
        )


def constraints(
    rod: PreparedRod,
    results: Sequence[SpeedResult],
    required: Mapping[str, float],
    films: Sequence[MinimumFilm] = (),
) -> tuple[DesignConstraint, ...]:
    """Return the constraints of a rod that is solved at all speeds; each is the worst of them.

    Stress is constrained in both ends and in the shank, each by itself: the largest stress of one place
    changes smoothly with the dimensions, that of the whole rod has a kink wherever the place changes. Raises
    `SingularMatrixError`: see `fea.analysis.buckling.buckling_report`.
    """
    every = [film.constraint(required[FILM]) for film in films]
    for result in results:
        every += [*_of_stress(rod, result, required), *_of_buckling(rod, result, required[BUCKLING])]
        every += _beyond_yield(rod, result, required[BUCKLING])
    names = dict.fromkeys(constraint.name for constraint in every)
    return tuple(
        min((one for one in every if one.name == name), key=lambda one: one.margin) for name in names
    )


def _of_stress(
    rod: PreparedRod, result: SpeedResult, required: Mapping[str, float]
) -> list[DesignConstraint]:
    bar = max(case.error_percent for case in result.cases.values())
    if result.cycle is None:
        counts = np.all([case.counts for case in result.cases.values()], axis=0)
        factors = {YIELDING: np.min([case.of_rod for case in result.cases.values()], axis=0)}
    else:
        counts, envelope = result.cycle.counts, result.cycle.envelope
        factors = {YIELDING: 1 / np.maximum(envelope.usage, 1e-300)}
        if HOURS in required:
            factors[f"life of {required[HOURS]:g} h"] = _life_factors(rod, result, required[HOURS])
        if envelope.fatigue_factor is not None and FATIGUE in required:
            factors[FATIGUE] = np.where(np.isnan(envelope.fatigue_factor), np.inf, envelope.fatigue_factor)
    found = []
    for place, nodes in _places(rod).items():
        for mode, factor in factors.items():
            least = float(factor[nodes & counts].min(initial=np.inf))
            if np.isfinite(least):
                found.append(DesignConstraint(f"{mode}, {place}", least, bar, required.get(mode, 1.0)))
    edges = [
        DesignConstraint(
            f"{YIELDING}, sharp edge", float(edge.safety_factor), edge.error_percent, required[YIELDING]
        )
        for case in result.cases.values()
        for edge in case.sharp_mattering
    ]
    flaws = [
        DesignConstraint(one.mode, float(one), one.percent or 0.0, rod.options.min_safety or 1.0)
        for one in flaw_factors(result.defect)
    ]
    return found + edges + flaws


def _life_factors(rod: PreparedRod, result: SpeedResult, hours: float) -> Floats:
    """Factors (n_nodes,) by which stress may grow until places last so many hours."""
    factors, cycle = None, result.cycle
    if cycle is not None and result.rpm is not None:
        (material,), found = rod.materials, cycle.envelope
        cycles = hours * result.rpm * rod.engine.engine.cycles_per_hour
        share = strength_share(material, cycle.regions.factors(material), cycles)
        if share is not None:
            factors = fatigue_factor(rod.options.fatigue, found.mean, found.amplitude, material, share)
    if factors is None:
        raise ValueError("only a rod with a crank cycle and an S–N line has hours")
    return factors


def _places(rod: PreparedRod) -> dict[str, Mask]:
    """Nodes (n_nodes,) of big end, shank and small end."""
    x, bores = rod.mesh.whole.points[:, 0], rod.mesh.bores
    shape = rod.study.rod.dimensions
    if shape is None:
        raise ValueError("only a rod with dimensions has places")
    big, small = x <= shape.big_end_radius, x >= bores.rod_length - shape.small_end_radius
    return {"big end": big, "shank": ~(big | small), "small end": small}


def _beyond_yield(rod: PreparedRod, result: SpeedResult, required: float) -> list[DesignConstraint]:
    """Return collapse of the bowed shank, and where they were followed flow, set and overload."""
    found, bent = [], bending_figures(rod, result.loads.cases)
    if bent is not None:
        found.append(DesignConstraint(COLLAPSE, bent.limit_N / bent.force_N, 0.0, required))
    if result.overload is not None:
        found.append(DesignConstraint(OVERLOAD, float(result.overload.safety_factor), 0.0, 1.0))
    left = [source.set_judged for source in (result.plastic, result.overload) if source is not None]
    ratios = [each.least_factor for each in left if each is not None and each.least_factor is not None]
    found += [DesignConstraint(SET, ratio, 0.0, 1.0) for ratio in ratios]
    if result.plastic is not None:
        settles = result.plastic.settling_factor
        found.append(DesignConstraint(LASTING_FLOW, float(settles), settles.percent or 0.0, 1.0))
    return found


def _of_buckling(rod: PreparedRod, result: SpeedResult, required: float) -> list[DesignConstraint]:
    figures = buckling_report(rod, result).figures
    column = [
        DesignConstraint(f"{BUCKLING}, {plane.replace('_', ' ')}", one.safety_factor, 0.0, required)
        for plane, one in figures.column.planes.items()
        if one.safety_factor is not None
    ]
    modes = [mode.factor for own in (figures.modes or {}).values() for mode in own]
    return [
        *column,
        *(DesignConstraint(f"{BUCKLING}, of the solid", factor, 0.0, required) for factor in modes),
    ]
