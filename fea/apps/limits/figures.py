"""The results of `fea limits`, as `summary.json` holds them, and in words."""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from fea.analysis.figures import Figures, WhereKnown
from fea.analysis.life_figures import CycleLifeFigures
from fea.analysis.pipeline import RefinedRod
from fea.apps.limits.engine import MECHANICAL_EFFICIENCY
from fea.apps.limits.explore import LEAST_GAS, RodLimits, SafeLimit
from fea.apps.limits.factors import ONSETS, PLASTIC, FailureMode
from fea.apps.limits.limit_map import MOST_PEAK, LimitPoint, ending, least_of
from fea.base.note import Note, assumption, by_consequence, omission, warning
from fea.base.shipped import shipped_toml
from fea.base.units import BAR, DEG
from fea.machine.clock import Clock
from fea.output.life_statements import lasts
from fea.rod.loading import CLOSED_THROTTLE
from fea.study.study import Study
from geometry.arrays import Floats
from loads.gas import Otto

# What ends a rod, by the mode; the place is that of the whole rod.
ENDS: Mapping[str, str] = shipped_toml("base/failures.toml")["limits"]
# Modes that end it at one crank angle.
_AT_ONE_ANGLE = ENDS.keys() - {"fatigue", "bolt fatigue"}
_ROWS = 9  # of the table
_TABLE_HEAD = ("rpm", "safe peak pressure, bar", "ended by")


class LimitPointFigures(Figures):
    """A point at which a safety factor is the required one."""

    mode: str
    rpm: float
    peak_pressure_bar: float  #: absolute
    bar: float | None  #: of the factor, by the stress there, percent; None where there is no estimate
    gas_scale: float  #: the key of [engine] that gives this peak
    interpolated: bool = False  #: between points that were solved
    at_mm: tuple[float, ...] | None  #: None where the mode has no place
    crank_deg: float | None
    exceeds: WhereKnown[str] = None  #: what of a permanent set exceeds its limit


class LargestValue(LimitPointFigures):
    """The largest speed along a line of operation, or the largest peak pressure at a speed."""

    value: float  #: rpm, or absolute peak pressure, bar
    bar: float | None  #: of the value, in its unit; None where the stress has no error bar
    place: str  #: in words; empty where the mode has no place
    boost_bar: float  #: gauge pressure in the intake
    safe_from: float | None  #: the least value that is safe, where it is not the least of all

    @property
    def ending(self) -> str:
        """What ends the rod, in words."""
        text = ENDS[self.mode].format(place=f"the {self.place}")
        at_one_angle = self.mode in _AT_ONE_ANGLE and self.crank_deg is not None
        return f"{text}, at {self.crank_deg:.0f}°" if at_one_angle else text

    def printed(self, unit: str) -> str:
        """The value with its error bar, both rounded: speeds to 10 rpm, pressures to 1 bar."""
        if self.bar is None:
            return f"{float(f'{self.value:.3g}'):.0f} {unit}"
        step = 10 if unit == "rpm" else 1
        bar = max(step * round(self.bar / step), step)
        return f"{step * round(self.value / step):.0f} ± {bar:.0f} {unit}"


class LimitsFigures(Figures):
    """The limits of a rod in its engine."""

    study: str
    required_safety_factor: float
    text: str  #: the answer in words
    trusted: bool
    rpm: float  #: of the study, the highest
    #: safe_rpm, safe_boost: up to which speed, rpm, and boost, bar, it is safe; None where it is at none
    safe_rpm: float | None
    safe_boost: float | None
    largest_rpm: LargestValue | None
    largest_peak_pressure_bar: LargestValue | None
    closed_throttle: LargestValue | None
    limits: tuple[LimitPointFigures, ...]
    #: By the speeds of the study, rpm, at its load; None: unlimited. Empty where life was not found
    life_hours: Mapping[str, float | None]
    life: Mapping[str, CycleLifeFigures]  #: the same with its range
    #: Peak pressures that are safe at some speeds, what ends them, and where collapse and a set begin
    table: tuple[tuple[str, ...], ...]
    table_head: tuple[str, ...]
    notes: tuple[Note, ...]
    left_out: tuple[Note, ...]
    files: tuple[str, ...]
    timings_s: Mapping[str, float]
    total_s: float
    schema: str = "fea/limits/1"

    def reaches(self, rpm: float | None, boost: float | None) -> bool:
        """Whether the rod reaches a speed at full load, and a boost, bar, at its speed, less error bars."""
        fast, pressed = self.largest_rpm, self.largest_peak_pressure_bar
        if rpm is not None and (self.safe_rpm is None or rpm > self.safe_rpm - ((fast and fast.bar) or 0.0)):
            return False
        if boost is None:
            return True
        if self.safe_boost is None:
            return False
        spread = 0.0 if pressed is None else (pressed.bar or 0.0) / pressed.value * (self.safe_boost + 1.0)
        return self.safe_boost - spread >= boost


def figures_of(study: Study, found: RodLimits, adapted: RefinedRod, clock: Clock) -> LimitsFigures:
    """Return the figures of the limits of a rod."""
    engine = found.engine
    speed, pressure, closed = largest_values(found)
    shortfall = [adapted.shortfall] if adapted.shortfall else []
    notes, left_out = by_consequence([*found.static.notes, *_notes(found), *shortfall])
    boost = None
    if found.pressure is not None and found.pressure.rpm >= found.at_rpm:
        boost = engine.boost(engine.scale(found.pressure.rpm, found.pressure.high))
    return LimitsFigures(
        study=study.name,
        required_safety_factor=study.analysis.min_safety or 1.0,
        text=words(found),
        trusted=found.static.trusted,
        rpm=found.rpm,
        safe_rpm=None if found.speed is None else found.speed.high,
        safe_boost=boost,
        largest_rpm=speed,
        largest_peak_pressure_bar=pressure,
        closed_throttle=closed,
        limits=tuple(_point_figures(limit, found) for limit in found.of_rays.points),
        life_hours={f"{rpm:g}": life.hours for rpm, life in found.lives.items()},
        life={f"{rpm:g}": life for rpm, life in found.lives.items()},
        table=tuple(_table(found)),
        table_head=(*_TABLE_HEAD, *(f"{mode.split()[-1]} at, bar" for mode in _plastic(found))),
        notes=notes,
        left_out=left_out,
        files=(),
        timings_s=dict(clock.seconds),
        total_s=clock.total,
    )


def largest_values(found: RodLimits) -> tuple[LargestValue | None, LargestValue | None, LargestValue | None]:
    """Return the largest safe speed, pressure, and speed with the throttle closed; None where unlimited."""
    speed, pressure, closed = (_largest(line, found) for line in (found.speed, found.pressure, found.closed))
    return speed, pressure, closed


def _point_figures(limit: LimitPoint, found: RodLimits) -> LimitPointFigures:
    angle = limit.worst.crank_angle
    return LimitPointFigures(
        mode=limit.mode.value,
        rpm=limit.rpm,
        peak_pressure_bar=limit.peak / BAR,
        bar=found.bar_percent(limit),
        gas_scale=limit.scale * (found.engine.loading.table.gas_scale or 1.0),
        interpolated=limit.interpolated,
        at_mm=limit.worst.at,
        crank_deg=None if angle is None else angle / DEG,
        exceeds=limit.worst.what or None,
    )


def _largest(safe: SafeLimit | None, found: RodLimits) -> LargestValue | None:
    if safe is None or safe.limit is None:
        return None
    limit, of_speed = safe.limit, math.isnan(safe.rpm)
    point, unit = _point_figures(limit, found), 1.0 if of_speed else BAR
    value = (limit.rpm if of_speed else limit.peak) / unit
    share = abs(limit.slope) * (point.bar or 0.0) / 100 + limit.spread
    return LargestValue(
        **vars(point) | {"bar": value * share if point.bar is not None or limit.spread else None},
        value=value,
        place=found.place(limit),
        boost_bar=found.engine.boost(limit.scale),
        safe_from=safe.low / unit if safe.low > safe.least else None,
    )


def words(found: RodLimits) -> str:
    """Return the answer in words."""
    return " ".join(_sentences(found))


def _sentences(found: RodLimits) -> Iterator[str]:
    speed, pressure, closed = largest_values(found)
    engine = found.engine
    load = "the study's load" if engine.full_load is None else "full load"
    load = load if engine.burns else "inertia alone"
    rpm = np.linspace(engine.idle, engine.fastest, 500)
    factors = found.of_rays.factors(rpm, np.array([engine.full_load_scale(each) for each in rpm.tolist()]))
    if found.overloaded_at_rest is not None:
        mode, usage = found.overloaded_at_rest
        at_rest = f"{1 / usage:.2f} times the required one as assembled, before any load acts"
        yield f"Against {mode.value} the safety factor is {at_rest}."
    if found.speed is None:
        yield _nowhere_safe(found, load, rpm, ending(factors))
    elif speed is None:
        yield f"At {load} nothing fails up to {found.speed.high:.0f} rpm, a mean piston speed of 50 m/s."
    else:
        least = "" if speed.safe_from is None else f"From {speed.safe_from:.0f} rpm, u"
        yield f"{least or 'U'}p to {speed.printed('rpm')} at {load}; there {speed.ending}."
    if engine.burns:
        yield from _of_pressure(found, pressure)
        yield from _of_linings(found)
    yield from _beyond_yield(found, load, rpm, factors)
    if closed is not None:
        yield f"With the throttle closed: {closed.printed('rpm')}; there {closed.ending}."
    if found.estimated:
        yield "These are estimates; what is solved follows."
    yield from _of_life(found, load)
    if all(material.endurance_limit is None for material in found.rod.materials):
        yield "Fatigue is not judged: the material has no endurance limit (material.endurance_MPa)."
    for mode in sorted(ONSETS & factors.keys()):
        below = np.flatnonzero(factors[mode] < 1)
        for part in np.split(below, np.flatnonzero(np.diff(below) > 1) + 1) if below.size else ():
            low, high = (f"{float(f'{at:.2g}'):.0f}" for at in rpm[part[[0, -1]]])
            until = "" if part[-1] == rpm.size - 1 else f" to {high}"
            yield f"From about {low}{until} rpm {ENDS[mode.value]}."


def _of_life(found: RodLimits, load: str) -> Iterator[str]:
    for rpm, life in found.lives.items():
        yield lasts(life, f"at {rpm:.0f} rpm and {load}")
    if found.no_life_because:
        yield f"Its life is not given: {found.no_life_because}."


def _nowhere_safe(found: RodLimits, load: str, rpm: Floats, factors: Mapping[FailureMode, Floats]) -> str:
    least = least_of(factors, rpm)
    at = int(least.argmax())
    mode = min(factors, key=lambda mode: factors[mode][at])
    idle = f"{found.engine.idle:.0f} rpm, about idling speed"
    best = (
        f": at best {least[at]:.2f} of it, against {mode.value}, at about {float(f'{rpm[at]:.2g}'):.0f} rpm"
    )
    best = best if least[at] < 1 else ""  # between the rays the map is an estimate
    return f"At {load} the rod does not reach the required safety factor at any speed from {idle}{best}."


def _of_pressure(found: RodLimits, largest: LargestValue | None) -> Iterator[str]:
    safe = found.pressure
    if safe is None or safe.rpm < found.at_rpm:
        yield f"At {found.at_rpm:.0f} rpm no peak pressure is safe."
    if safe is None:
        return
    at = f"At {safe.rpm:.0f} rpm"
    if largest is None:
        yield f"{at} nothing fails up to {safe.high / BAR:.0f} bar, more than any engine reaches."
        return
    least = "" if largest.safe_from is None else f"from {largest.safe_from:.0f} bar "
    boost = f"{largest.boost_bar:.2g} bar of boost" if largest.boost_bar > 0 else "no boost"
    yield f"{at} {least}up to {largest.printed('bar')} peak ({boost}); there {largest.ending}."


def _over_pressures(found: RodLimits, rpm: float) -> tuple[Floats, dict[FailureMode, Floats]]:
    """Peak pressures (n,), MPa, and the factors of each mode at a speed under them."""
    peaks = np.linspace(found.engine.peak(rpm, LEAST_GAS), MOST_PEAK, 2000)
    return peaks, found.of_rays.factors(np.full_like(peaks, rpm), found.engine.scale(rpm, peaks))


def _of_linings(found: RodLimits) -> Iterator[str]:
    """Yield the peak pressure from which bushing and shells yield, which does not end the rod."""
    rpm = found.at_rpm if found.pressure is None else found.pressure.rpm
    peaks, factors = _over_pressures(found, rpm)
    held = np.flatnonzero(factors.get(FailureMode.LINING, np.full(1, np.inf)) >= 1)
    if held.size and held[-1] + 1 < len(factors.get(FailureMode.LINING, ())):
        begins = f"from about {peaks[held[-1]] / BAR:.0f} bar peak on"
        yield f"At {rpm:.0f} rpm {ENDS[FailureMode.LINING.value]}, {begins}. That does not end the rod."


def _plastic(found: RodLimits) -> list[FailureMode]:
    """Modes that need not begin while all else is elastic, as far as they are known."""
    return [mode for mode in PLASTIC if mode in found.of_rays.loads]


def _begins(factors: Floats, coordinates: Floats) -> float | None:
    """Return the least coordinate (n,) at which factors are below the required one; None without one."""
    below = np.flatnonzero(factors < 1)
    return float(coordinates[below[0]]) if below.size else None


def _beyond_yield(
    found: RodLimits, load: str, rpm: Floats, factors: Mapping[FailureMode, Floats]
) -> Iterator[str]:
    """Yield from which speed (n,), rpm, and which pressure on the rod bends, or is deformed for good."""
    peaks, pressed = _over_pressures(found, found.rpm) if found.engine.burns else (np.zeros(1), {})
    for mode in _plastic(found):
        fast, at = _begins(factors[mode], rpm), f"at {found.rpm:.0f} rpm"
        places = [] if fast is None else [f"from about {_round(fast)} rpm on at {load}"]
        begins = _begins(pressed[mode], peaks) if pressed else None
        if begins is not None:
            on = (
                f"from about {_round(begins / BAR)} bar peak on"
                if begins > peaks[0]
                else "under any pressure"
            )
            places.append(f"{on} {at}")
        if places:
            line = found.of_rays.limits.get(mode, ())
            exceeded = dict.fromkeys(limit.worst.what for limit in line if limit is not None)
            ends = ENDS[mode.value].format(place=", ".join(exceeded))
            yield f"Yielding left aside, {ends} {' and '.join(places)}."
    if found.no_set_because:
        yield f"Its permanent set is not given: {found.no_set_because}."


def _round(value: float) -> str:
    return f"{float(f'{value:.3g}'):.0f}"


def _table(found: RodLimits) -> Iterator[tuple[str, ...]]:
    """Yield the range of safe peak pressures at some speeds, with what ends it on either side."""
    if not (found.engine.burns and found.of_rays.limits):
        return
    step = 250 * math.ceil(max(limit.rpm for limit in found.of_rays.points) / _ROWS / 250)
    fastest = max(limit.rpm for limit in found.of_rays.points)
    for rpm in np.arange(step, fastest + step, step).tolist():
        peaks, factors = _over_pressures(found, rpm)
        begins = [_begins(factors[mode], peaks) for mode in _plastic(found)]
        plastic = ["none" if at is None else f"{at / BAR:.0f}" if at > peaks[0] else "0" for at in begins]
        factors = ending(factors)
        safe = np.flatnonzero(least_of(factors, peaks) > 1)
        if not safe.size:
            yield f"{rpm:.0f}", "none", min(factors, key=lambda mode: factors[mode].max()).value, *plastic
            continue
        low = "0" if safe[0] == 0 else f"{peaks[safe[0]] / BAR:.0f}"
        above = min(safe[-1] + 1, len(peaks) - 1)
        mode = min(factors, key=lambda mode: factors[mode][above])
        yield f"{rpm:.0f}", f"{low} to {peaks[safe[-1]] / BAR:.0f}", mode.value, *plastic


_OTTO = (
    "every pressure of the cycle grows in proportion to the intake pressure: same mixture, intake "
    "temperature, ignition and compression ratio (Heywood 1988, §5.3); knock is not considered"
)
_MULTIPLIED = (
    "the gauge pressure of the gas is multiplied, its course over the crank angle unchanged; boost is its "
    "ratio to the study's times the study's intake pressure"
)
_ASSEMBLED = (
    "lines of the map are those of the decisive instants, interpolated where limits.csv says so; the limits "
    "in words are solved over whole cycles"
)
_LINES = {  # that are not those of elastic stress
    FailureMode.FILM: "its line is where a coarse film is as thin as the surfaces are rough, to a few "
    "percent (fea run --film gives the error of its grid)",
    FailureMode.COLLAPSE: "the shank is bowed by a thousandth of its length (or overload.bow_mm) and yields "
    "without hardening, at the cyclic yield strength if that is smaller",
    FailureMode.SET: "what four turns of the peak cases leave, without hardening, at the cyclic yield "
    "strength if that is smaller, under the contact of the elastic rod; its line is found on "
    "four rays, to 2 %, and straight between them",
}
_CLOSED = {
    4: f"{CLOSED_THROTTLE:g} bar absolute in the intake and no combustion",
    2: "the exhaust port still opens to the atmosphere, and there is no combustion",
}


def _notes(found: RodLimits) -> Iterator[Note]:
    rod, engine = found.rod, found.engine
    table = engine.loading.table
    if engine.burns:
        yield assumption(_OTTO if isinstance(engine.loading.gas, Otto) else _MULTIPLIED, "gas")
    yield assumption(f"with the throttle closed {_CLOSED[engine.loading.engine.strokes]}", "gas")
    if table.full_load and any("torque_Nm" in point for point in table.full_load):
        yield assumption(f"mechanical efficiency {MECHANICAL_EFFICIENCY:g} (Heywood 1988, §2.4)", "full load")
    if rod.options.in_contact:
        fits = "clearances and reliefs of the bores"
        yield assumption(f"{fits} are those at the study's speed and load", "pins")
    if rod.assembly_contact is not None:
        yield assumption(_ASSEMBLED, "map")
    if found.unsettled:
        text = f"at {found.unsettled} operating points the friction of the joint did not settle"
        yield warning(f"{text}, and the factors are estimates", "map")
    yield from (assumption(text, mode.value) for mode, text in _LINES.items() if mode in found.of_rays.loads)
    if found.life is not None:
        line = "an S–N line that is assumed from the strengths" if found.life.assumed else "the mean S–N line"
        kept = f"hours are those of continuous running at one point, by {line}; 1 % more stress "
        yield assumption(f"{kept}takes about a tenth of them (fea run with [duty] adds up a duty)", "life")
    yield omission("the load case gas", "the limits are those of the running engine at each speed")
    if rod.sharp_places:
        yield omission("structural stress at sharp edges", "fea run judges them at one speed and load")
    if all(material.endurance_limit is None for material in rod.materials):
        yield omission("limits by fatigue", "the material has no endurance limit (material.endurance_MPa)")
