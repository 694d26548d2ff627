"""The limits of a rod: the answer first, then the map."""

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from fea.analysis.flow import left_out
from fea.analysis.life_figures import CycleLifeFigures
from fea.analysis.pipeline import RefinedRod, solve_speed
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.apps.limits.assembled_factors import AssembledFactors
from fea.apps.limits.engine import ScaledEngine
from fea.apps.limits.factors import STRESSED, FailureMode, RodFactors, SuperposedFactors
from fea.apps.limits.limit_map import (
    MOST_PEAK,
    LifeMap,
    LimitMap,
    LimitPoint,
    RayAxes,
    ending,
    life_at,
    life_map,
    with_film,
)
from fea.apps.limits.search import LimitSearch, OperatingLine
from fea.apps.limits.set_line import with_set
from fea.rod.places import place_name
from fea.solid.errors import ContactError
from fea.study.pin_models import FILM
from fea.study.study import Study
from geometry.errors import require, require_positive

# The least gas load factor that is evaluated.
LEAST_GAS = 0.02
# Of the largest speed: where the pressure is found if none is safe at that of the study.
_LOWER = 0.9
# Where no stress of the load cases is as near to the peak, the error bar of the place counts alone.
_NEAR_PEAK = 0.8


@dataclass(frozen=True)
class SafeLimit:
    """The safe interval along a line of operation, and what ends it."""

    low: float  #: low, high: the safe interval of the line's coordinate, rpm or MPa
    high: float
    limit: LimitPoint | None  #: None where nothing ends it
    least: float  #: where the line begins
    rpm: float = math.nan  #: of a line of one speed, whose coordinate is the pressure


@dataclass(frozen=True)
class RodLimits:
    """The limits of a rod in its engine."""

    rod: PreparedRod
    engine: ScaledEngine
    rpm: float  #: the highest of the study
    at_rpm: float  #: at which the largest peak pressure was asked for
    static: SpeedResult  #: of `rpm`
    #: speed, pressure: along the line of full load, and at one speed; None where nothing is safe
    speed: SafeLimit | None
    pressure: SafeLimit | None
    closed: SafeLimit | None  #: with the throttle closed; None where nothing ends it
    #: A mode with its utilisation beyond 1 as assembled, before any load acts; None where there is none
    overloaded_at_rest: tuple[FailureMode, float] | None
    unsettled: int  #: number of points whose friction did not settle
    estimated: bool  #: whether speeds and pressures are estimates
    of_rays: LimitMap
    life: LifeMap | None = None  #: where it was asked for and is known
    #: by the speeds of the study, rpm, at its load
    lives: Mapping[float, CycleLifeFigures] = field(default_factory=dict)
    no_life_because: str = ""  #: why no life is known although it was asked for
    no_set_because: str = ""  #: likewise the line of the permanent set

    def place(self, limit: LimitPoint) -> str:
        """Return where a limit is, or what of a set exceeds its own, in words; empty where there is none."""
        at = limit.worst.at
        return limit.worst.what if at is None else place_name(self.rod.mesh, self._node(at))

    def bar_percent(self, limit: LimitPoint) -> float | None:
        """Error bar of the stress at a limit by the solved cases; None where stress does not decide."""
        if limit.worst.at is None or limit.mode not in STRESSED:
            return None
        node = self._node(limit.worst.at)
        cases = [case for case in self.static.cases.values() if case.load.in_cycle]
        case = max(cases, key=lambda each: float(each.von_mises[node]))
        stress = float(case.von_mises[node])
        error = 100 * float(case.von_mises_error[node]) / max(stress, 1e-12)
        near = stress >= _NEAR_PEAK * case.peak.value
        return max(error, case.worst.error_percent) if near else error

    def _node(self, place: tuple[float, ...]) -> int:
        """Node of the whole rod at a place, mm."""
        return int(np.linalg.norm(self.rod.mesh.whole.points - np.array(place), axis=1).argmin())


def limited_speeds(study: Study) -> list[float]:
    """Return the speeds of a study, rpm, in rising order; raises `InvalidValue` where it has no limits."""
    rule = "gives the force on the pin: without an engine there are no speeds and peak pressures"
    require(study.forces is None, "[forces]", None, rule, "Give an [engine], or use --engine.")
    study.require_engine()
    rule = "would need oil films, which take seconds, at each of some hundred operating points"
    remedy = "Leave it out; --film adds the line of the oil film."
    require(study.analysis.pressure != FILM, "analysis.pressure", FILM, rule, remedy)
    speeds = sorted(rpm for rpm in study.speeds() if rpm is not None)
    require_positive("speed.rpm", speeds[-1])
    return speeds


def explore(
    adapted: RefinedRod,
    rpm: float,
    at_rpm: float | None = None,
    show: Callable[[str], None] = lambda _stage: None,
    answered: Callable[[RodLimits], None] = lambda _found: None,
    *,
    mapped: bool = True,
    lives_at: Sequence[float] = (),
    permanent_set: bool = False,
) -> RodLimits:
    """Find the limits of a rod on its mesh; `rpm`: the highest speed of the study.

    `answered` is called with the limits before the map is made; they are estimates for a rod of separate
    parts. `mapped`: whether the map is made; with it, `lives_at`: speeds, rpm, at which life is found too, as
    all over the map; `permanent_set`: whether the line is found from which the rod is left deformed.
    """
    rod, engine = adapted.rod, ScaledEngine(adapted.rod.engine, adapted.rod.mass)
    static = adapted.results.get(rpm) or solve_speed(rod, rpm)
    required = rod.options.min_safety or 1.0
    model = _model(rod, engine, rpm, show)
    search = LimitSearch(model, engine, _axes(static, engine, rpm, required), required, show)
    closed_throttle = engine.closed_throttle()

    def found(of_rays: LimitMap) -> RodLimits:
        show("largest speed and pressure")
        speed, pressure = _speed(search, of_rays, rpm), None
        if engine.burns:
            pressure = _pressure(search, of_rays, at_rpm or rpm)
            if pressure is None and speed is not None and at_rpm is None:
                lower = max(100 * math.floor(_LOWER * speed.high / 100), engine.idle)
                pressure = _pressure(search, of_rays, lower)
        closed = search.fastest(of_rays, closed_throttle)
        worst = max(ending(search.rest).items(), key=lambda item: item[1], default=None)
        return RodLimits(
            rod=rod,
            engine=engine,
            rpm=rpm,
            at_rpm=at_rpm or rpm,
            static=static,
            speed=speed,
            pressure=pressure,
            closed=None if closed is None else SafeLimit(0.0, closed.rpm, closed, 0.0),
            overloaded_at_rest=worst if worst is not None and worst[1] > 1 else None,
            unsettled=model.unsettled,
            estimated=not search.certain,
            of_rays=of_rays,
        )

    first = found(search.survey())
    answered(first)
    of_rays = search.map() if mapped else first.of_rays
    search.certain = True
    last = found(of_rays)
    if not mapped:
        return last
    if rod.study.analysis.film and of_rays.limits:
        of_rays = with_film(rod, engine, of_rays, show)
    why = left_out(rod)
    if permanent_set and not why:
        of_rays = with_set(rod, engine, of_rays, required, show)
    last = replace(last, of_rays=of_rays, no_set_because=why if permanent_set else "")
    if not lives_at:
        return last
    show("life")
    life = life_map(model, engine, of_rays, required)
    if life is None:
        why = "nothing fails by fatigue" if model.endurance is not None else "the material has no S–N line"
        return replace(last, no_life_because=why)
    lives = {each: own for each in lives_at if (own := life_at(model, engine, each)) is not None}
    return replace(last, life=life, lives=lives)


def _model(rod: PreparedRod, engine: ScaledEngine, rpm: float, show: Callable[[str], None]) -> RodFactors:
    pins = rod.assembly_contact
    if pins is not None:
        show("the cycle of the study")
        assembled = AssembledFactors(rod, pins)
        with suppress(ContactError):  # its decisive instants are also those of other points
            assembled.at(engine.cycle(rpm, engine.full_load_scale(rpm)))
        return assembled
    show("unit solutions")
    cycle = rod.crank_cycle(rpm)
    return SuperposedFactors(rod, rod.spanned_cycle([cycle]).supported(cycle))


def _axes(static: SpeedResult, engine: ScaledEngine, rpm: float, required: float) -> RayAxes:
    """Estimate the limits by inertia alone and by gas alone from solved load cases."""
    tension, gas = (static.cases.get(name) for name in ("tension", "gas"))
    fast = rpm if tension is None else rpm * math.sqrt(tension.min_safety_factor / required)
    fast = min(fast, engine.fastest)
    if gas is None:
        return RayAxes(fast, 1.0)
    return RayAxes(fast, min(gas.min_safety_factor / required, engine.scale(engine.idle, MOST_PEAK)))


def _speed(search: LimitSearch, of_rays: LimitMap, rpm: float) -> SafeLimit | None:
    engine = search.engine
    ends = (min(engine.idle, rpm), engine.fastest)
    line = OperatingLine("load", engine, lambda at: (at, engine.full_load_scale(at)), ends)
    safe = search.safe(of_rays, line)
    around = [each for each in safe if each[0] <= rpm] or safe[:1]
    return SafeLimit(*around[-1], ends[0]) if around else None


def _pressure(search: LimitSearch, of_rays: LimitMap, rpm: float) -> SafeLimit | None:
    engine = search.engine
    ends = (engine.peak(rpm, LEAST_GAS), MOST_PEAK)
    line = OperatingLine(f"{rpm} rpm", engine, lambda at: (rpm, engine.scale(rpm, at)), ends)
    safe = search.safe(of_rays, line)
    return SafeLimit(*safe[-1], ends[0], rpm) if safe else None
