"""The limits of a rod: the answer first, then the map."""

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from fea.analysis.pipeline import RefinedRod, solve_speed
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.apps.limits.assembled_states import AssembledStates
from fea.apps.limits.few_rays import LifeMap, hours_at, life_map, with_film
from fea.apps.limits.limit_map import MOST_PEAK, Axes, Explorer, Limit, LimitMap, Line, ending
from fea.apps.limits.operation import Operation
from fea.apps.limits.states import Mode, States, SuperposedStates
from fea.solid.errors import ContactError
from fea.study.pin_models import FILM
from fea.study.study import Study
from geometry.errors import require, require_positive

# Least charge that is looked at.
LEAST_CHARGE = 0.02
# Of the largest speed, where no pressure is safe at that of the study.
_LOWER = 0.9


class Reached(NamedTuple):
    """The end of what is safe along a line of operation."""

    low: float  #: low, high: the safe interval of the line's coordinate, rpm or MPa
    high: float
    limit: Limit | None  #: None where nothing ends it
    least: float  #: where the line begins
    rpm: float = math.nan  #: of a line of one speed


@dataclass(frozen=True)
class RodLimits:
    """The limits of a rod in its engine."""

    rod: PreparedRod
    operation: Operation
    rpm: float  #: the highest of the study
    at_rpm: float  #: at which the largest peak pressure was asked for
    static: SpeedResult  #: of `rpm`
    #: speed, pressure: along the line of full load, and at one speed; None where nothing is safe
    speed: Reached | None
    pressure: Reached | None
    closed: Limit | None  #: with the throttle closed; None where nothing ends it
    #: A mode with its utilisation beyond 1 before anything loads the rod; None where there is none
    spent: tuple[Mode, float] | None
    unsettled: int  #: number of states whose friction did not settle
    estimated: bool  #: whether speeds and pressures are estimates as yet
    of_rays: LimitMap
    life: LifeMap | None = None  #: where it was asked for and is known
    hours: Mapping[float, float] = field(default_factory=dict)  #: by the speeds of the study, at its load
    lifeless: str = ""  #: why no life is known although it was asked for


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
    lasting: Sequence[float] = (),
) -> RodLimits:
    """Find the limits of a rod on its mesh; `rpm`: the highest speed of the study.

    `answered` is told what is found before the map is made, of a survey; of a rod in parts, it is estimated.
    `mapped`: whether the map is made. `lasting`: speeds, rpm, at which its life is found too, and all over
    the map.
    """
    rod = adapted.rod
    static = adapted.results.get(rpm) or solve_speed(rod, rpm)
    operation = Operation(rod.engine, rod.mass)
    required = rod.options.min_safety or 1.0
    axes = _axes(static, operation, rpm, required)
    states = _states(rod, operation, rpm, show)
    explorer = Explorer(states, operation, axes, required, show)
    closed_throttle = operation.closed_throttle()

    def found(of_rays: LimitMap) -> RodLimits:
        show("largest speed and pressure")
        speed = _speed(explorer, of_rays, rpm)
        pressure = None
        if operation.burns:
            pressure = _pressure(explorer, of_rays, at_rpm or rpm)
            if pressure is None and speed is not None and at_rpm is None:
                lower = max(100 * math.floor(_LOWER * speed.high / 100), operation.idle)
                pressure = _pressure(explorer, of_rays, lower)
        closed = explorer.fastest(of_rays, closed_throttle)
        worst = min(ending(explorer.rest).items(), key=lambda each: -each[1], default=None)
        return RodLimits(
            rod=rod,
            operation=operation,
            rpm=rpm,
            at_rpm=at_rpm or rpm,
            static=static,
            speed=speed,
            pressure=pressure,
            closed=closed,
            spent=worst if worst is not None and worst[1] > 1 else None,
            unsettled=states.unsettled,
            estimated=not explorer.certain,
            of_rays=of_rays,
        )

    first = found(explorer.survey())
    answered(first)
    of_rays = explorer.map() if mapped else first.of_rays
    explorer.certain = True
    last = found(of_rays)
    if not mapped:
        return last
    if rod.study.analysis.film and of_rays.limits:
        last = replace(last, of_rays=with_film(rod, operation, of_rays, show))
    if not lasting:
        return last
    show("life")
    life = life_map(states, operation, of_rays, required)
    if life is None:
        why = "the material has no S–N line" if states.endless is None else "nothing fails by fatigue"
        return replace(last, lifeless=why)
    hours = {each: hours_at(states, operation, each) for each in lasting}
    return replace(last, life=life, hours=hours)


def _states(rod: PreparedRod, operation: Operation, rpm: float, show: Callable[[str], None]) -> States:
    pins = rod.assembly_contact
    if pins is not None:
        show("the cycle of the study")
        states = AssembledStates(rod, pins)
        with suppress(ContactError):  # its instants that decide are those of others, too
            states.at(operation.cycle(rpm, operation.today(rpm)))
        return states
    show("unit solutions")
    return SuperposedStates(rod, rod.spanned_cycle([rod.crank_cycle(rpm)]))


def _axes(static: SpeedResult, operation: Operation, rpm: float, required: float) -> Axes:
    """Estimate the limits by inertia alone and by gas alone from solved load cases."""
    tension, gas = (static.cases.get(name) for name in ("tension", "gas"))
    fast = rpm if tension is None else rpm * math.sqrt(tension.min_safety_factor / required)
    fast = min(fast, operation.fastest)
    if gas is None:
        return Axes(fast, 1.0)
    return Axes(fast, min(gas.min_safety_factor / required, operation.scale(operation.idle, MOST_PEAK)))


def _speed(explorer: Explorer, of_rays: LimitMap, rpm: float) -> Reached | None:
    operation = explorer.operation
    ends_ = (min(operation.idle, rpm), operation.fastest)
    safe = explorer.safe(of_rays, Line("load", operation, lambda at: (at, operation.today(at)), ends_))
    around = [each for each in safe if each[0] <= rpm] or safe[:1]
    return Reached(*around[-1], ends_[0]) if around else None


def _pressure(explorer: Explorer, of_rays: LimitMap, rpm: float) -> Reached | None:
    operation = explorer.operation
    ends_ = (operation.peak(rpm, LEAST_CHARGE), MOST_PEAK)
    line = Line(f"{rpm} rpm", operation, lambda at: (rpm, operation.scale(rpm, at)), ends_)
    safe = explorer.safe(of_rays, line)
    return Reached(*safe[-1], ends_[0], rpm) if safe else None
