"""The figures of the limits of a rod, and the answer in words."""

import math
from collections.abc import Iterator

import numpy as np

from fea.analysis.pipeline import RefinedRod
from fea.apps.limits.explore import LEAST_CHARGE, Reached, RodLimits
from fea.apps.limits.figures import ENDS, Largest, LimitFigures, LimitsFigures, ends, with_bar
from fea.apps.limits.limit_map import MOST_PEAK, Limit, ending, least_of
from fea.apps.limits.operation import CLOSED_THROTTLE, MECHANICAL_EFFICIENCY, Operation
from fea.apps.limits.states import ONSETS, STRESSED, Mode
from fea.base.note import Note, assumption, by_consequence, omission, warning
from fea.base.units import BAR, DEG
from fea.machine.clock import Clock
from fea.rod.place_names import place_name
from fea.study.study import Study
from loads.gas import Otto

# Where no stress of the load cases comes as near to the peak, the bar of the place counts alone.
_NEAR_PEAK = 0.8
_ROWS = 9  # of the table


class Bars:
    """Error bars, percent of the stress, of places of a rod, from its solved load cases."""

    def __init__(self, found: RodLimits) -> None:
        self._cases = [case for case in found.static.cases.values() if case.load.in_cycle]
        self._rod = found.rod.mesh

    def node(self, place: tuple[float, ...]) -> int:
        """Return the node of the whole rod at a place, mm."""
        return int(np.linalg.norm(self._rod.whole.points - np.array(place), axis=1).argmin())

    def percent(self, limit: Limit) -> float | None:
        """Return the bar of the stress at a limit; None where the mode is not one of stress."""
        if limit.worst.at is None or limit.mode not in STRESSED:
            return None
        node = self.node(limit.worst.at)
        case = max(self._cases, key=lambda one: float(one.von_mises[node]))
        stress = float(case.von_mises[node])
        error = 100 * float(case.von_mises_error[node]) / max(stress, 1e-12)
        near = stress >= _NEAR_PEAK * case.peak.value
        return max(error, case.worst.error_percent) if near else error

    def place(self, limit: Limit) -> str:
        """Return where a limit is, in words."""
        return "" if limit.worst.at is None else place_name(self._rod, self.node(limit.worst.at))


def words(found: RodLimits) -> str:
    """Return the answer in words."""
    return " ".join(_sentences(found))


def ends_of(found: RodLimits) -> tuple[Largest | None, Largest | None, Largest | None]:
    """Speed, pressure, and speed with the throttle closed, that end what is safe."""
    closed = None if found.closed is None else Reached(0.0, found.closed.rpm, found.closed, 0.0)
    bars, lines = Bars(found), (found.speed, found.pressure, closed)
    speed, pressure, last = (_largest(line, bars, found.operation) for line in lines)
    return speed, pressure, last


def figures_of(study: Study, found: RodLimits, adapted: RefinedRod, clock: Clock) -> LimitsFigures:
    """Return the figures of what was found."""
    operation = found.operation
    bars, (speed, pressure, closed) = Bars(found), ends_of(found)
    every = [limit for line in found.of_rays.limits.values() for limit in line if limit is not None]
    shortfall = [adapted.shortfall] if adapted.shortfall else []
    notes, left_out = by_consequence([*found.static.notes, *_notes(found), *shortfall])
    boost = None
    if found.pressure is not None and found.pressure.rpm >= found.at_rpm:
        boost = operation.boost(operation.scale(found.pressure.rpm, found.pressure.high))
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
        limits=tuple(_limit(limit, bars, operation) for limit in every),
        life_hours={f"{rpm:g}": None if math.isinf(hours) else hours for rpm, hours in found.hours.items()},
        table=tuple(_table(found)),
        notes=notes,
        left_out=left_out,
        files=(),
        timings_s=dict(clock.seconds),
        total_s=clock.total,
    )


def _limit(limit: Limit, bars: Bars, operation: Operation) -> LimitFigures:
    angle = limit.worst.crank_angle
    return LimitFigures(
        mode=limit.mode.value,
        rpm=limit.rpm,
        peak_pressure_bar=limit.peak / BAR,
        bar=bars.percent(limit),
        gas_scale=limit.scale * (operation.loading.table.gas_scale or 1.0),
        interpolated=limit.interpolated,
        at_mm=limit.worst.at,
        crank_deg=None if angle is None else angle / DEG,
    )


def _largest(reached: Reached | None, bars: Bars, operation: Operation) -> Largest | None:
    if reached is None or reached.limit is None:
        return None
    limit, of_speed = reached.limit, math.isnan(reached.rpm)
    unit, percent = 1.0 if of_speed else BAR, bars.percent(limit)
    value = (limit.rpm if of_speed else limit.peak) / unit
    share = abs(limit.slope) * (percent or 0.0) / 100 + limit.spread
    return Largest(
        **vars(_limit(limit, bars, operation))
        | {"bar": value * share if percent is not None or limit.spread else None},
        value=value,
        place=bars.place(limit),
        boost_bar=operation.boost(limit.scale),
        safe_from=reached.low / unit if reached.low > reached.least else None,
    )


def _sentences(found: RodLimits) -> Iterator[str]:
    speed, pressure, closed = ends_of(found)
    operation = found.operation
    load = "the study's load" if operation.full_load is None else "full load"
    load = load if operation.burns else "inertia alone"
    rpm = np.linspace(operation.idle, operation.fastest, 500)
    factors = found.of_rays.factors(rpm, np.array([operation.today(each) for each in rpm.tolist()]))
    if found.spent is not None:
        mode, usage = found.spent
        lost = "as assembled, before any load acts"
        yield f"Against {mode.value} the safety factor is {1 / usage:.2f} times the required one {lost}."
    if found.speed is None:
        idle = f"{operation.idle:.0f} rpm, about idling speed"
        of_speeds = least_of(ending(factors), rpm)
        best, most = rpm[of_speeds.argmax()], of_speeds.max()
        mode = min(ending(factors), key=lambda mode: factors[mode][of_speeds.argmax()])
        gap = f": at best {most:.2f} of it, against {mode.value}, at about {float(f'{best:.2g}'):.0f} rpm"
        gap = gap if most < 1 else ""  # between the rays the map is an estimate
        yield f"At {load} the rod does not reach the required safety factor at any speed from {idle}{gap}."
    elif speed is None:
        yield f"At {load} nothing fails up to {found.speed.high:.0f} rpm, a mean piston speed of 50 m/s."
    else:
        least = "" if speed.safe_from is None else f"From {speed.safe_from:.0f} rpm, u"
        yield f"{least or 'U'}p to {with_bar(speed.value, speed.bar, 'rpm')} at {load}; there {ends(speed)}."
    if operation.burns:
        yield from _of_pressure(found, pressure)
        yield from _of_linings(found)
    if closed is not None:
        yield f"With the throttle closed: {with_bar(closed.value, closed.bar, 'rpm')}; there {ends(closed)}."
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


def _of_pressure(found: RodLimits, largest: Largest | None) -> Iterator[str]:
    reached = found.pressure
    if reached is None or reached.rpm < found.at_rpm:
        yield f"At {found.at_rpm:.0f} rpm no peak pressure is safe."
    if reached is None:
        return
    at = f"At {reached.rpm:.0f} rpm"
    if largest is None:
        yield f"{at} nothing fails up to {reached.high / BAR:.0f} bar, more than any engine reaches."
        return
    least = "" if largest.safe_from is None else f"from {largest.safe_from:.0f} bar "
    boost = f"{largest.boost_bar:.2g} bar of boost" if largest.boost_bar > 0 else "no boost"
    most = with_bar(largest.value, largest.bar, "bar")
    yield f"{at} {least}up to {most} peak ({boost}); there {ends(largest)}."


def _of_linings(found: RodLimits) -> Iterator[str]:
    """Yield, of bushing and shells, which do not end the rod, from which peak pressure on they yield."""
    rpm = found.at_rpm if found.pressure is None else found.pressure.rpm
    peaks = np.linspace(found.operation.peak(rpm, LEAST_CHARGE), MOST_PEAK, 2000)
    factors = found.of_rays.factors(np.full_like(peaks, rpm), found.operation.scale(rpm, peaks))
    held = np.flatnonzero(factors.get(Mode.LINING, np.full(1, np.inf)) >= 1)
    if held.size and held[-1] + 1 < len(factors.get(Mode.LINING, ())):
        low = peaks[held[-1]] / BAR
        begins = f"from about {low:.0f} bar peak on"
        yield f"At {rpm:.0f} rpm {ENDS[Mode.LINING.value]}, {begins}. That does not end the rod."


def _of_life(found: RodLimits, load: str) -> Iterator[str]:
    for rpm, hours in found.hours.items():
        long = f"about {hours:.2g} hours" if hours >= 1 else f"about {60 * hours:.2g} minutes"
        yield f"At {rpm:.0f} rpm and {load} its life is {'unlimited' if math.isinf(hours) else long}."
    if found.lifeless:
        yield f"Its life is not given: {found.lifeless}."


def _notes(found: RodLimits) -> Iterator[Note]:
    rod, operation = found.rod, found.operation
    table = operation.loading.table
    if operation.burns and isinstance(operation.loading.gas, Otto):
        how = "every pressure of the cycle grows in proportion to the intake pressure: same mixture, intake "
        yield assumption(
            f"{how}temperature, ignition and compression ratio (Heywood 1988, §5.3); knock is not considered",
            "gas",
        )
    elif operation.burns:
        how = "the gauge pressure of the gas is multiplied, its course over the crank angle unchanged"
        yield assumption(f"{how}; boost is its ratio to the study's times the study's intake pressure", "gas")
    closed = f"{CLOSED_THROTTLE:g} bar absolute in the intake and no combustion"
    yield assumption(f"with the throttle closed {closed}", "gas")
    if table.full_load and any("torque_Nm" in point for point in table.full_load):
        yield assumption(f"mechanical efficiency {MECHANICAL_EFFICIENCY:g} (Heywood 1988, §2.4)", "full load")
    if rod.options.in_contact:
        fits = "clearances and reliefs of the bores"
        yield assumption(f"{fits} are those at the study's speed and load", "pins")
    if rod.assembly_contact is not None:
        yield from _of_parts(found.unsettled)
    if Mode.FILM in found.of_rays.limits:
        film = "its line is where a coarse film is as thin as the surfaces are rough, to a few percent"
        yield assumption(f"{film} (fea run --film gives the error of its grid)", "oil film")
    if found.life is not None:
        kept = "hours are those of continuous running at one point, by the mean S–N line; 1 % more stress "
        yield assumption(f"{kept}takes about a tenth of them (fea run with [duty] gives their band)", "life")
    yield omission("the load case gas", "the limits are those of the running engine at each speed")
    if rod.sharp_places:
        yield omission("structural stress at sharp edges", "fea run judges them at one speed and load")
    if all(material.endurance_limit is None for material in rod.materials):
        yield omission("limits by fatigue", "the material has no endurance limit (material.endurance_MPa)")


def _of_parts(unsettled: int) -> Iterator[Note]:
    lines = "lines of the map are those of the decisive instants, interpolated where limits.csv says so"
    yield assumption(f"{lines}; the limits in words are solved over whole cycles", "map")
    if unsettled:
        text = f"at {unsettled} operating points the friction of the joint did not settle"
        yield warning(f"{text}, and the factors are estimates", "map")


def _table(found: RodLimits) -> Iterator[tuple[str, ...]]:
    """Yield the range of safe peak pressures at some speeds, with what ends it on either side."""
    operation, of_rays = found.operation, found.of_rays
    if not (operation.burns and of_rays.limits):
        return
    fastest = max(limit.rpm for line in of_rays.limits.values() for limit in line if limit is not None)
    step = 250 * math.ceil(fastest / _ROWS / 250)
    for rpm in np.arange(step, fastest + step, step).tolist():
        peaks = np.linspace(operation.peak(rpm, LEAST_CHARGE), MOST_PEAK, 2000)
        scale = operation.scale(rpm, peaks)
        factors = ending(of_rays.factors(np.full_like(scale, rpm), scale))
        least, modes = least_of(factors, scale), list(factors)
        safe = np.flatnonzero(least > 1)
        if not safe.size:
            worst = modes[int(np.argmin([factor.max() for factor in factors.values()]))]
            yield f"{rpm:.0f}", "none", worst.value
            continue
        low = "0" if safe[0] == 0 else f"{peaks[safe[0]] / BAR:.0f}"
        above = min(safe[-1] + 1, len(peaks) - 1)
        what = modes[int(np.argmin([factor[above] for factor in factors.values()]))]
        yield f"{rpm:.0f}", f"{low} to {peaks[safe[-1]] / BAR:.0f}", what.value
