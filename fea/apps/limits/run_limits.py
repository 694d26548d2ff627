"""The job behind `fea limits`: the largest speed and peak pressure of a rod, and the map of both."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fea.analysis.adapt import Adapted, adapt_mesh
from fea.analysis.prepare import PreparedRod
from fea.analysis.speed import SpeedResult, solve_speed
from fea.apps.limits.figures import (
    Largest,
    LimitFigures,
    LimitsFigures,
    ends,
    with_bar,
)
from fea.apps.limits.limit_map import (
    ELASTIC,
    MOST_PEAK,
    Axes,
    Explorer,
    Limit,
    LimitMap,
    least_of,
    most_charge,
)
from fea.apps.limits.operation import CLOSED_THROTTLE, MECHANICAL_EFFICIENCY, Operation
from fea.apps.limits.states import Mode, States
from fea.base.note import Note, assumption, by_consequence, omission
from fea.base.units import BAR, DEG
from fea.machine.clock import Clock
from fea.output.folder import REPORT, SUMMARY, require_replaceable, run_folder
from fea.output.json_file import json_text
from fea.output.limits_report.report import write_limits_page
from fea.output.plots.limits import MapLine, MapPlot, plot_limits
from fea.output.text import write_text
from fea.rod.place_names import place_name
from fea.study.pin_models import FILM
from fea.study.study import Study, load_study
from geometry.arrays import Floats
from geometry.errors import require, require_positive
from loads.gas import LARGEST_PEAK, Otto
from mesh.tetmesh import TetMesh

STUDY, TABLE, MAP = "study.toml", "limits.csv", "limits.png"
FILES = (STUDY, SUMMARY, TABLE, MAP, REPORT)
# Where no stress of the load cases comes as near to the peak, the bar of the place counts alone.
_NEAR_PEAK = 0.8
# Speeds of the table, and columns and rows of the map.
_ROWS, _COLUMNS, _LINES = 9, 160, 140
_LEAST_CHARGE = 0.02
# Of the largest speed, where no pressure is safe at that of the study.
_LOWER = 0.9


class Reached(NamedTuple):
    """The end of what is safe along a line of operation."""

    limit: Limit | None  #: None where nothing ends it
    low: float  #: low, high: the safe interval of the line's coordinate, rpm or MPa
    high: float
    least: float  #: where the line begins
    rpm: float = math.nan  #: of a line of one speed


@dataclass(frozen=True)
class Found:
    """What was found of a rod."""

    rod: PreparedRod
    operation: Operation
    rpm: float  #: the highest of the study
    at_rpm: float  #: at which the largest peak pressure was asked for
    static: SpeedResult  #: of `rpm`
    of_rays: LimitMap
    #: speed, pressure: along the line of full load, and at one speed; None where nothing is safe
    speed: Reached | None
    pressure: Reached | None
    closed: Limit | None  #: with the throttle closed; None where nothing ends it


def limits(
    study: Study | str | Path,
    folder: Path | None = None,
    listener: Callable[[str], None] | None = None,
    *,
    at_rpm: float | None = None,
) -> LimitsFigures:
    """Find how fast a rod can turn and how much peak pressure it stands.

    Parameters
    ----------
    study
        A study, a shipped one by name, or the path of a TOML file.
    folder
        Where the files go; None for none.
    listener
        Is told the name of each stage as it begins.
    at_rpm
        Speed at which the largest peak pressure is found; default: that of the study, the highest.

    Raises
    ------
    InvalidValue
        There is no engine, or a value of the study breaks a rule.
    OccupiedError, StorageError
        The folder cannot take the files.
    GeometryError, MeshError, UnderconstrainedError, SingularMatrixError, ContactError
        The rod cannot be drawn, meshed or solved.
    """
    study = study if isinstance(study, Study) else load_study(study)
    rule = "are given: a rod without an engine has no speed and no peak pressure"
    require(study.forces is None, "[forces]", None, rule, "Give an [engine], or use --engine.")
    study.require_engine()
    rule = "cannot be combined with fea limits: each state of a rod in parts takes too long"
    remedy = "Remove [assembly]; then check a limit with it: fea run with its rpm and its engine.gas_scale."
    require(study.assembly is None, "[assembly]", None, rule, remedy)
    rule = "would take a film of seconds for each of some hundred states; the film changes the big end alone"
    on_film = study.analysis.pressure == FILM
    require(not on_film, "analysis.pressure", FILM, rule, "Choose another, or leave it out.")
    speeds = [rpm for rpm in study.speeds() if rpm is not None]
    require_positive("speed.rpm", max(speeds))
    if at_rpm is not None:
        require_positive("at_rpm", at_rpm)
    if folder is not None:
        require_replaceable(folder)
    clock = Clock(listener)
    study = replace(study, duty=None, analysis=replace(study.analysis, cycle=True))
    adapted = adapt_mesh(study, [max(speeds)], clock)
    with clock("limits"):
        found = explore(adapted, max(speeds), at_rpm, listener or (lambda _stage: None))
    figures = _figures(study, found, adapted, clock)
    if folder is not None:
        with run_folder(folder) as part:
            _write(part, study, found, figures, speeds)
    return figures


def explore(adapted: Adapted, rpm: float, at_rpm: float | None, show: Callable[[str], None]) -> Found:
    """Find the limits of a rod on its mesh; `rpm`: the highest speed of the study."""
    rod = adapted.rod
    static = adapted.results.get(rpm) or solve_speed(rod, rpm)
    operation = Operation(rod.engine, rod.mass)
    required = rod.options.min_safety or 1.0
    axes = _axes(static, operation, rpm, required)
    show("unit solutions")
    states = States(rod, rod.spanned_cycle([rod.crank_cycle(rpm)]))
    explorer = Explorer(states, operation, axes, required=required, show=show)
    of_rays = explorer.map()
    show("largest speed and pressure")
    speed = _speed(explorer, of_rays, rpm)
    fastest = explorer.fastest(operation.closed_throttle(), axes.rpm)
    pressure = None
    if operation.burns:
        pressure = _pressure(explorer, of_rays, at_rpm or rpm)
        if pressure is None and speed is not None and at_rpm is None:
            lower = max(100 * math.floor(_LOWER * speed.high / 100), operation.idle)
            pressure = _pressure(explorer, of_rays, lower)
    return Found(rod, operation, rpm, at_rpm or rpm, static, of_rays, speed, pressure, fastest)


def _axes(static: SpeedResult, operation: Operation, rpm: float, required: float) -> Axes:
    """Estimate the limits by inertia alone and by gas alone from solved load cases."""
    tension, gas = (static.cases.get(name) for name in ("tension", "gas"))
    fast = rpm if tension is None else rpm * math.sqrt(tension.min_safety_factor / required)
    fast = min(fast, operation.fastest)
    if gas is None:
        return Axes(fast, 1.0)
    return Axes(fast, min(gas.min_safety_factor / required, most_charge(operation, operation.idle)))


def _speed(explorer: Explorer, of_rays: LimitMap, rpm: float) -> Reached | None:
    """The end of the speeds at full load around that of the study, or below it."""
    operation = explorer.operation
    ends_ = (min(operation.idle, rpm), operation.fastest)
    edges, safe = explorer.edges(of_rays, lambda at: (at, operation.today(at)), ends_)
    around = [each for each in safe if each[0] <= rpm] or safe[:1]
    if not around:
        return None
    low, high = around[-1]
    return Reached(next((limit for limit in edges if limit.rpm == high), None), low, high, ends_[0])


def _pressure(explorer: Explorer, of_rays: LimitMap, rpm: float) -> Reached | None:
    """The end of the highest peak pressures that are safe at a speed."""
    operation = explorer.operation
    ends_ = (operation.peak(rpm, _LEAST_CHARGE), MOST_PEAK)
    edges, safe = explorer.edges(of_rays, lambda at: (rpm, operation.scale(rpm, at)), ends_)
    if not safe:
        return None
    low, high = safe[-1]
    last = next((limit for limit in edges if math.isclose(limit.peak, high)), None)
    return Reached(last, low, high, ends_[0], rpm)


class Bars:
    """Error bars, percent of the stress, of places of a rod, from its solved load cases."""

    def __init__(self, found: Found) -> None:
        self._mesh: TetMesh = found.rod.mesh.whole
        self._cases = [case for case in found.static.cases.values() if case.load.in_cycle]
        self._rod = found.rod.mesh

    def node(self, place: tuple[float, ...]) -> int:
        """Return the node of the whole rod at a place, mm."""
        return int(np.linalg.norm(self._mesh.points - np.array(place), axis=1).argmin())

    def percent(self, limit: Limit) -> float | None:
        """Return the bar of the stress at a limit; None where the mode is not one of stress."""
        if limit.worst.at is None or limit.mode not in (Mode.YIELD, Mode.FATIGUE):
            return None
        node = self.node(limit.worst.at)
        case = max(self._cases, key=lambda one: float(one.von_mises[node]))
        stress = float(case.von_mises[node])
        own = 100 * float(case.von_mises_error[node]) / max(stress, 1e-12)
        near = stress >= _NEAR_PEAK * case.peak.value
        return max(own, case.worst.error_percent) if near else own

    def place(self, limit: Limit) -> str:
        """Return where a limit is, in words."""
        return "" if limit.worst.at is None else place_name(self._rod, self.node(limit.worst.at))


def _figures(study: Study, found: Found, adapted: Adapted, clock: Clock) -> LimitsFigures:
    bars, operation = Bars(found), found.operation
    speed, pressure = (_largest(own, bars, operation) for own in (found.speed, found.pressure))
    closed = None
    if found.closed is not None:
        closed = _largest(Reached(found.closed, 0.0, found.closed.rpm, 0.0), bars, operation)
    every = [limit for own in found.of_rays.limits.values() for limit in own if limit is not None]
    shortfall = [adapted.shortfall] if adapted.shortfall else []
    notes, left_out = by_consequence([*found.static.notes, *_notes(found), *shortfall])
    boost = None
    if found.pressure is not None and found.pressure.rpm >= found.at_rpm:
        boost = operation.boost(operation.scale(found.pressure.rpm, found.pressure.high))
    return LimitsFigures(
        study=study.name,
        required_safety_factor=study.analysis.min_safety or 1.0,
        text=" ".join(_sentences(found, speed, pressure, closed)),
        trusted=found.static.trusted,
        rpm=found.rpm,
        safe_rpm=None if found.speed is None else found.speed.high,
        safe_boost=boost,
        largest_rpm=speed,
        largest_peak_pressure_bar=pressure,
        closed_throttle=closed,
        limits=tuple(_limit(limit, bars, operation) for limit in every),
        table=tuple(_table(found)),
        notes=notes,
        left_out=left_out,
        files=FILES,
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
        at_mm=limit.worst.at,
        crank_deg=None if angle is None else angle / DEG,
    )


def _largest(reached: Reached | None, bars: Bars, operation: Operation) -> Largest | None:
    if reached is None or reached.limit is None:
        return None
    limit, of_speed = reached.limit, math.isnan(reached.rpm)
    unit, percent = 1.0 if of_speed else BAR, bars.percent(limit)
    value = (limit.rpm if of_speed else limit.peak) / unit
    return Largest(
        **vars(_limit(limit, bars, operation))
        | {"bar": None if percent is None else value * abs(limit.slope) * percent / 100},
        value=value,
        place=bars.place(limit),
        boost_bar=operation.boost(limit.scale),
        safe_from=reached.low / unit if reached.low > reached.least else None,
    )


def _sentences(
    found: Found, speed: Largest | None, pressure: Largest | None, closed: Largest | None
) -> Iterator[str]:
    """Yield the answer in words."""
    operation, load = found.operation, "today's load" if found.operation.full_load is None else "full load"
    load = load if operation.burns else "inertia alone"
    if found.speed is None:
        idle = f"{operation.idle:.0f} rpm, about idling speed"
        yield f"At {load} the rod does not reach the required safety factor at any speed from {idle}."
    elif speed is None:
        yield f"At {load} nothing fails up to {found.speed.high:.0f} rpm, a mean piston speed of 50 m/s."
    else:
        least = "" if speed.safe_from is None else f"From {speed.safe_from:.0f} rpm, u"
        yield f"{least or 'U'}p to {with_bar(speed.value, speed.bar, 'rpm')} at {load}; there {ends(speed)}."
    if operation.burns:
        yield from _of_pressure(found, pressure)
    if closed is not None:
        yield f"With the throttle closed: {with_bar(closed.value, closed.bar, 'rpm')}; there {ends(closed)}."


def _of_pressure(found: Found, largest: Largest | None) -> Iterator[str]:
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


def _notes(found: Found) -> Iterator[Note]:
    """Yield what is assumed of the gas, and what is left out."""
    operation = found.operation
    table = operation.loading.table
    if operation.burns and isinstance(operation.loading.gas, Otto):
        how = "every pressure of the cycle grows in proportion to the intake pressure: same mixture, intake "
        yield assumption(
            f"{how}temperature, ignition and compression ratio (Heywood 1988, §5.3); knock is not looked at",
            "gas",
        )
    elif operation.burns:
        how = "the gauge pressure of the gas is multiplied, its course over the crank angle unchanged"
        yield assumption(f"{how}; boost is its ratio to today's times today's intake pressure", "gas")
    closed = f"{CLOSED_THROTTLE:g} bar absolute in the intake and no combustion"
    yield assumption(f"with the throttle closed {closed}", "gas")
    if table.full_load and any("torque_Nm" in point for point in table.full_load):
        yield assumption(f"mechanical efficiency {MECHANICAL_EFFICIENCY:g} (Heywood 1988, §2.4)", "full load")
    if found.rod.options.in_contact:
        yield assumption(
            "clearances and reliefs of the bores stay those of the study's speed and load", "pins"
        )
    yield omission("the case gas of the limits", "they are those of the running engine at each speed")
    if found.rod.sharp_places:
        yield omission("structural stress at sharp edges", "fea run judges them at one speed and load")
    if all(material.endurance_limit is None for material in found.rod.materials):
        yield omission("limits by fatigue", "the material has no endurance limit (material.endurance_MPa)")


def _table(found: Found) -> Iterator[tuple[str, ...]]:
    """Yield the range of safe peak pressures at some speeds, with what ends it on either side."""
    operation, of_rays = found.operation, found.of_rays
    if not (operation.burns and of_rays.limits):
        return
    fastest = max(limit.rpm for own in of_rays.limits.values() for limit in own if limit is not None)
    step = 250 * math.ceil(fastest / _ROWS / 250)
    for rpm in np.arange(step, fastest + step, step).tolist():
        peaks = np.linspace(operation.peak(rpm, _LEAST_CHARGE), MOST_PEAK, 2000)
        scale = np.array([operation.scale(rpm, peak) for peak in peaks])
        factors = of_rays.factors(np.full_like(scale, rpm), scale)
        least, modes = least_of(factors, scale), list(factors)
        safe = np.flatnonzero(least > 1)
        if not safe.size:
            worst = modes[int(np.argmin([own.max() for own in factors.values()]))]
            yield f"{rpm:.0f}", "none", worst.value
            continue
        low = "0" if safe[0] == 0 else f"{peaks[safe[0]] / BAR:.0f}"
        above = min(safe[-1] + 1, len(peaks) - 1)
        what = modes[int(np.argmin([own[above] for own in factors.values()]))]
        yield f"{rpm:.0f}", f"{low} to {peaks[safe[-1]] / BAR:.0f}", what.value


def _write(folder: Path, study: Study, found: Found, figures: LimitsFigures, speeds: list[float]) -> None:
    write_text(folder / STUDY, study.text())
    write_text(folder / SUMMARY, json_text(figures))
    head = "mode,rpm,peak_pressure_bar,gas_scale,bar_percent,x_mm,y_mm,z_mm,crank_deg"
    lines = [head, *map(_row, figures.limits)]
    write_text(folder / TABLE, "\n".join(lines) + "\n")
    shown, factors = _plot(found, figures, speeds)
    plot_limits(folder / MAP, shown)
    bars = Bars(found)
    places = {
        mode.value: ["" if one is None else bars.place(one) for one in own]
        for mode, own in found.of_rays.limits.items()
    }
    notes = [str(note) for note in (*figures.notes, *figures.left_out)]
    write_limits_page(
        folder / REPORT,
        shown,
        text=figures.text,
        factors=factors,
        places=places,
        table=figures.table,
        notes=notes,
    )


def _row(own: LimitFigures) -> str:
    place = own.at_mm or (None, None, None)
    values = (own.rpm, own.peak_pressure_bar, own.gas_scale, own.bar, *place, own.crank_deg)
    return ",".join([own.mode, *("" if value is None else f"{value:.7g}" for value in values)])


def _plot(found: Found, figures: LimitsFigures, speeds: list[float]) -> tuple[MapPlot, dict[str, Floats]]:
    """The map, and the factors at its points over the required one."""
    operation, of_rays, bars = found.operation, found.of_rays, Bars(found)
    every = [limit for own in of_rays.limits.values() for limit in own if limit is not None]
    rpm = np.linspace(0.0, 1.08 * max([limit.rpm for limit in every] + speeds), _COLUMNS)[1:]
    top = 1.15 * max([limit.peak for limit in every] + [operation.peak(each) for each in speeds])
    peak = np.linspace(0.0, min(top, LARGEST_PEAK), _LINES)
    scale = (
        np.stack([[operation.scale(each, p) for p in peak] for each in rpm], axis=1)
        if operation.burns
        else np.zeros((len(peak), len(rpm)))
    )
    factors = of_rays.factors(np.broadcast_to(rpm, scale.shape), np.maximum(scale, 0.0))
    full = rpm[rpm >= operation.idle]
    own_load = found.operation.full_load is None
    today = [operation.peak(each, operation.today(each)) / BAR for each in full.tolist()]
    closed = figures.closed_throttle
    shown = MapPlot(
        title=f"{figures.study}: limits with a safety factor of {figures.required_safety_factor:g}",
        rpm=rpm,
        peak=peak / BAR,
        factor=least_of(factors, scale),
        yielding=figures.required_safety_factor / factors[Mode.YIELD]
        if Mode.YIELD in factors
        else np.zeros_like(scale),
        elastic=ELASTIC,
        lines={mode.value: _line(own, bars) for mode, own in of_rays.limits.items()},
        full_load=(full, np.array(today)),
        full_load_name="today's load" if own_load else "full load",
        points=[(each, operation.peak(each, operation.today(each)) / BAR) for each in speeds],
        closed_throttle=None if closed is None else (closed.value, closed.peak_pressure_bar),
        boost=_boosts(found, float(peak[-1])),
    )
    return shown, {mode.value: own for mode, own in factors.items()}


def _line(own: tuple[Limit | None, ...], bars: Bars) -> MapLine:
    nan = math.nan
    rows = [
        (nan, nan, nan) if one is None else (one.rpm, one.peak / BAR, (bars.percent(one) or nan) / 100)
        for one in own
    ]
    rpm, peak, bar = np.array(rows).T
    return MapLine(rpm=rpm, peak=peak, bar=bar)


def _boosts(found: Found, top: float) -> list[tuple[float, float]]:
    """Round pressures of boost with their peak pressures at the study's speed, bar."""
    operation = found.operation
    if not operation.burns:
        return []
    none, one = operation.boost(0.0), operation.boost(1.0)
    ticks = []
    for boost in np.arange(math.ceil(2 * none) / 2, 100, 0.5).tolist():
        peak = operation.peak(found.rpm, (boost - none) / (one - none))
        if peak > top:
            break
        if peak >= 0:
            ticks.append((boost, peak / BAR))
    return ticks[:: max(1, len(ticks) // 8)]
