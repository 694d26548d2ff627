"""The oil films of the bearings at one speed: how thin, at what pressure and cost, how certain."""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property, partial
from typing import Any

import numpy as np
import numpy.typing as npt

from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.summary_figures import FilmFigures
from fea.base.checks import LIMITS, Check, check
from fea.base.note import Note, doubt, omission, remark, warning
from fea.base.units import BAR, DEG, UM
from fea.film.cycle import HOTTEST, MOST_CYCLES, FilmCycle, between
from fea.machine.isolated import CrashError, begun
from fea.machine.system import CAN_FORK, memory_limit
from fea.machine.threads import threads
from fea.pins.lubrication import (
    COARSE,
    FINE,
    MPAS,
    TOPIC,
    TOPICS,
    Films,
    Lubrication,
    crank_angles,
)
from fea.pins.yielding import End
from fea.solid.errors import FilmError
from fea.study.two_stroke import SMALL
from geometry.arrays import Floats
from loads.instants import Instants

_W, _L_MIN = 1e3, 1e6 / 60  # N·mm/s and mm³/s
# Share of the load above which asperities carry it beside the oil, where λ < 1.
_CARRIED = 0.1
# Pressure at which surfaces flow, MPa: about the hardness of bronze; the asperities of the model are elastic.
_HARDNESS = 1000.0
# How near to its extreme a course over the cycle is looked at for the error of that, relative to it.
_NEAR = 0.1
# Least error of the flow that a round hole feeds, percent: on the fine grid, of that into a strip.
_HOLES = 5.0
# Tilt over the clearance above which it is told.
_TILTED = 1e-3


# Percent: with a wider bar of its highest pressure, a film gets no verdict.
_WIDEST = 50.0


class Regime(StrEnum):
    """How surfaces are kept apart, by the smallest gap over the roughness λ, and whether the oil suffices.

    Full films have λ > 3, asperities carry most of the load where λ < 1 (Hamrock, Schmid & Jacobson 2004,
    Fundamentals of Fluid Film Lubrication, section 3.8). In a bent bore λ may be below 1 at an edge only,
    where asperities carry little: such a film is mixed.
    """

    HYDRODYNAMIC = "hydrodynamic"
    MIXED = "mixed"
    METAL = "metal to metal"
    STARVED = "starved"
    OVERHEATED = "overheated"
    OVERLOADED = "overloaded"
    NOT_DETERMINED = "not determined"  # the error bars are too wide for a verdict

    @classmethod
    def of(cls, ratio: float, share: float) -> "Regime":
        """Judge a ratio λ and the largest share of the load on asperities."""
        touching = cls.METAL if share > _CARRIED else cls.MIXED
        return cls.HYDRODYNAMIC if ratio > 3 else cls.MIXED if ratio > 1 else touching


@dataclass(frozen=True)
class FilmResult:
    """The film of one end at one speed, and a coarser one of the same bearing."""

    cycle: FilmCycle
    coarse: FilmCycle
    #: The coarse one in a bore that yields as on much smaller elements; None where it was not solved
    softer: FilmCycle | None
    lubrication: Lubrication
    displacement: float  #: of the engine's cylinder, mm³
    #: Share of the joint of a rod in parts that opens in load cases, at the big end; None for one piece
    joint: Mapping[str, float] | None = None
    turn: float = 4 * math.pi  #: crank angle of the engine's cycle, rad

    @property
    def end(self) -> End:
        """The end of the rod."""
        return self.lubrication.end

    @property
    def name(self) -> str:
        """How its files begin."""
        return "film" if self.end is End.BIG else f"film_{self.end}"

    @property
    def degrees(self) -> Floats:
        """Crank angle (n,) of the steps."""
        return crank_angles(self.cycle.acting.count, self.turn) / DEG

    @cached_property
    def regime(self) -> Regime:
        """The regime of the film as it was computed, or why there is none."""
        if self.cycle.starved:
            return Regime.STARVED
        if self.cycle.too_hot or abs(self.cycle.unbalanced) > LIMITS["film_heat"]:
            return Regime.OVERHEATED
        if self.cycle.highest.max() > _HARDNESS:
            return Regime.OVERLOADED
        return Regime.of(self.ratio, float(self.cycle.asperities.max()))

    @property
    def sound(self) -> bool:
        """Whether the film was computed to its end, within the model."""
        return self.regime not in (Regime.STARVED, Regime.OVERHEATED, Regime.OVERLOADED)

    @cached_property
    def wide(self) -> float | None:
        """The bar of the highest pressure, percent, if it is too wide for a verdict; None if it is not."""
        if not self.sound:
            return None
        bar = self._error(lambda film: film.highest, partial(extreme_error, np.max))
        return bar if bar > _WIDEST else None

    @property
    def verdict(self) -> Regime:
        """The regime, or why there is none."""
        return self.regime if self.wide is None else Regime.NOT_DETERMINED

    @cached_property
    def ratio(self) -> float:
        """Smallest gap over the roughness."""
        asperities = self.lubrication.asperities
        return math.inf if asperities is None else float(self.cycle.thinnest.min()) / asperities.roughness

    @cached_property
    def figures(self) -> FilmFigures:
        """The figures of `summary.json`."""
        cycle, said, grid = self.cycle, self.lubrication, self.cycle.bearing.reynolds.grid
        share, warm = float(cycle.asperities.max()), cycle.temperature
        flow = self._error(lambda film: film.leaked, figure_error)
        specific = float(np.hypot(*cycle.acting.load.T[:2]).max()) / (2 * grid.radius * grid.width)
        return FilmFigures(
            h_min_um=float(cycle.thinnest.min()) / UM,
            h_min_deg=float(self.degrees[cycle.thinnest.argmin()]),
            h_min_error_percent=self._error(lambda film: film.thinnest, partial(extreme_error, np.min)),
            p_max_MPa=float(cycle.highest.max()),
            p_max_deg=float(self.degrees[cycle.highest.argmax()]),
            p_max_error_percent=self._error(lambda film: film.highest, partial(extreme_error, np.max)),
            power_W=cycle.dissipated / _W,
            power_error_percent=self._error(lambda film: film.dissipated, figure_error),
            friction_mep_bar=cycle.dissipated * cycle.acting.period / self.displacement / BAR,
            flow_l_min=cycle.leaked / _L_MIN,
            flow_error_percent=max(flow, _HOLES if said.pin_hole else 0.0),
            filled_percent=100 * float(cycle.filled.mean()),
            temperature_C=warm if said.temperature is None else said.temperature,
            temperature_error_K=warm and self._warmth_error(warm),
            viscosity_mPas=cycle.bearing.reynolds.oil.viscosity / MPAS,
            radial_clearance_um=said.clearance / UM,
            lambda_min=self.ratio if said.asperities else None,
            asperity_percent=100 * share,
            asperity_error_percent=share * self._error(lambda film: film.asperities.max(), figure_error),
            specific_load_MPa=specific,
            lining_factor=said.lining and said.lining / specific,
            verdict=self.verdict.value,
        )

    def _error(self, read: Callable[[FilmCycle], Any], error: Callable[[Any, Any, Any], float]) -> float:
        """Error of what is read, percent; all of it where the softer bore's film was not solved."""
        if self.softer is None:
            return 100.0
        return error(read(self.cycle), read(self.coarse), read(self.softer))

    def _warmth_error(self, warm: float) -> float:
        """Error of the temperature, K; the softer bore's film has that of the coarse one."""
        change = abs(warm - (self.coarse.temperature or warm))
        return warm * film_error(warm, change) / 100 + abs(self.cycle.unbalanced)

    @property
    def columns(self) -> dict[str, npt.ArrayLike]:
        """Columns of ``film.csv``; those of the small end are named after it."""
        cycle, own = self.cycle, "" if self.end is End.BIG else f"{self.end}_"
        x, y = cycle.eccentricity.T
        return {
            "crank_deg": self.degrees,
            f"{own}h_min_um": cycle.thinnest / UM,
            f"{own}p_max_MPa": cycle.highest,
            f"{own}eccentricity_x": x,
            f"{own}eccentricity_y": y,
            f"{own}power_W": cycle.friction[1] / _W,
            f"{own}asperity_percent": 100 * cycle.asperities,
            f"{own}filled_percent": 100 * cycle.filled,
        }

    @property
    def checks(self) -> dict[str, Check]:
        """Balances of force, oil, power and heat, and repetition; of a film that fails, the first only."""
        cycle = self.cycle
        pressures = np.array([state.pressure for state in cycle.states])
        off = cycle.bearing.reynolds.grid.resultants(pressures) - cycle.acting.load
        values = {"film_force": float(np.abs(off).max() / np.abs(cycle.acting.load).max())}
        if self.sound:
            values |= {
                "film_repeats": cycle.unrepeated,
                "film_oil": abs(cycle.supplied / cycle.leaked - 1),
                "film_power": abs(cycle.driven / cycle.dissipated - 1),
                "film_heat": abs(cycle.unbalanced),
            }
        return {name: check(name, value) for name, value in values.items()}

    @property
    def notes(self) -> tuple[Note, ...]:
        """What a reader must know."""
        topic, found = TOPICS[self.end], self.figures
        notes = [*self.lubrication.notes, *(doubt(text, topic) for text in self._doubts(found))]
        if self.cycle.tilted > _TILTED * self.lubrication.clearance:
            text = f"{self.end.pin} and bore tilt by up to {self.cycle.tilted / UM:.2g} µm over the width"
            notes.append(remark(text, topic))
        if self.joint is not None:
            notes.append(self._of_joint(self.joint))
        if self.wide is not None:
            text = (
                f"not determined: its highest pressure is known to ± {self.wide:.0f} % only, and as computed "
                f"it is {self.regime}. Smaller elements (--size) narrow that"
            )
            notes.append(doubt(text, topic))
        if self.verdict == Regime.MIXED:
            text = f"asperities touch; they carry up to {found.asperity_percent:.2g} % of the load"
            notes.append(warning(text, topic))
        if self.cycle.temperature is not None and self.sound:
            text = (
                f"{100 * self.lubrication.heat:.0f} % of {found.power_W:.0f} W heat {found.flow_l_min:.2g} "
                f"l/min of oil from {self.lubrication.inlet_temperature:.0f} to {found.temperature_C:.0f} "
                f"°C, where it has {found.viscosity_mPas:.2f} mPa·s"
            )
            notes.append(remark(text, topic))
        return tuple(notes)

    @staticmethod
    def _of_joint(joint: Mapping[str, float]) -> Note:
        text = "loads do not open the joint: the bore yields with the parts held together"
        if joint:
            share, case = max((share, case) for case, share in joint.items())
            text = (
                f"the joint opens, {100 * share:.2g} % of it in {case}: at each crank angle the bore "
                "yields with the parts as open as under contact, and what is closed sticks"
            )
        return remark(text, TOPIC)

    def _doubts(self, found: FilmFigures) -> Iterator[str]:
        match self.verdict:
            case Regime.STARVED:
                remedy = "Turn the oil hole away from the load (film.hole_deg), or raise film.inlet_bar"
                yield (
                    f"starved: the supply cannot keep the film full. Oil fills {found.filled_percent:.0f} % "
                    f"of the gap; in the last cycle {self.cycle.supplied / _L_MIN:.2g} l/min came in and "
                    f"{found.flow_l_min:.2g} left, and the other figures are of that cycle. "
                    f"{remedy if self.end is End.BIG else 'Raise film.small_end_inlet_bar'}"
                )
            case Regime.OVERHEATED:
                yield (
                    f"overheated: the heat of friction and of the oil do not balance below {HOTTEST:.0f} °C, "
                    f"where the model ends; the last cycle was computed at {found.temperature_C:.0f} °C"
                )
            case Regime.OVERLOADED:
                yield (
                    f"overloaded: oil and asperities press with up to {found.p_max_MPa:.0f} MPa, where "
                    f"bearing metals flow ({_HARDNESS:.0f} MPa is the hardness of bronze), and the model ends"
                )
            case Regime.METAL:
                yield (
                    "the film is thinner than the surfaces are rough: they touch, and wear or seize; its "
                    "figures depend on the model of the asperities more than on that of the oil"
                )
        if not self.cycle.repeats and self.sound:
            yield f"it does not repeat itself in {MOST_CYCLES} cycles, although oil comes in as it leaks"
        if found.lining_factor is not None and found.lining_factor < 1:
            yield (
                f"the specific load, {found.specific_load_MPa:.0f} MPa, exceeds what the lining endures, "
                f"{self.lubrication.lining:g} MPa (film.lining_MPa)"
            )


def films_at(rod: PreparedRod, rpm: float) -> tuple[tuple[FilmResult, ...], tuple[Note, ...]]:
    """Films of both ends at a speed, rpm, and why there is none at the small end, if so.

    Raises `InvalidValue`: [film] does not suit the rod; `FilmError`: that of the big end was not solved.
    """
    topic = TOPICS[End.SMALL]
    if End.SMALL.pressed_in(rod.structure):
        fit = rod.structure.contact.small_end_clearance_mm
        why = f"the pin is pressed into the bore (contact.small_end_clearance_mm = {fit:g})"
        return (film_at(rod, rpm),), (omission(topic, why),)
    if SMALL in rod.engine.table.roller_bearings:
        return (film_at(rod, rpm),), (omission(topic, "it runs on rollers (engine.roller_bearings)"),)
    cycle = rod.crank_cycle(rpm)
    if cycle.engine.strokes == 2 and _never_reverses(cycle.degrees):
        why = (
            "in this two-stroke engine the pin presses on one side of the bore throughout the cycle, so that "
            "nothing refills a film that is squeezed there: no verdict"
        )
        return (film_at(rod, rpm),), (omission(topic, why),)
    small = rod.small_end_films
    _ = small.lubrication  # refuses what does not suit before a film is solved
    with ExitStack() as block:
        other = None
        if CAN_FORK and threads() > 1 and memory_limit() is None:
            for films in (rod.films, small):
                films.prepare(cycle)
            other = block.enter_context(begun(partial(small.at, cycle)))
        big = film_at(rod, rpm)
        try:
            if other is not None:
                with rod.clock("film"), suppress(CrashError):  # whatever ended it, that film is solved here
                    small.remember(cycle, other.result())
            return (big, film_at(rod, rpm, small)), ()
        except FilmError as error:
            return (big,), (doubt(f"none was found: {error}", topic),)


def _never_reverses(instants: Instants) -> bool:
    """Whether the force along the rod at the piston pin has one direction at all instants."""
    return bool(instants.pin_axial.max() <= 0 or instants.pin_axial.min() >= 0)


def film_at(rod: PreparedRod, rpm: float, films: Films | None = None) -> FilmResult:
    """Film of an end, by default the big one, at a speed, rpm; errors as of `films_at`, of either end."""
    cycle, films = rod.crank_cycle(rpm), films or rod.films
    every = films.at(cycle)
    engine = cycle.engine
    displacement = 2 * engine.crank_radius * math.pi / 4 * engine.bore**2
    joint = films.openings(cycle) if films.end is End.BIG and films.parts is not None else None
    return FilmResult(*every, films.lubrication, displacement, joint, engine.cycle)


def figure_error(fine: float, coarse: float, softer: float) -> float:
    """Error of a figure of the fine film that is no extreme over the cycle, percent: see `film_error`."""
    return film_error(fine, abs(fine - coarse), abs(softer - coarse))


def extreme_error(extreme: Callable[[Floats], float], fine: Floats, coarse: Floats, softer: Floats) -> float:
    """Error of the extreme of the fine film's course over the cycle, percent, 100 at most.

    Changes are those in the mean square where a course is near its extreme: that of the extreme itself may
    vanish by chance.
    """

    def change(course: Floats, other: Floats) -> float:
        peak = extreme(course)
        near = np.abs(course - peak) <= _NEAR * abs(peak)
        return float(np.sqrt(((other - course)[near] ** 2).mean()))

    there = np.arange(len(fine)) * len(coarse) / len(fine)
    return film_error(float(extreme(fine)), change(fine, between(coarse, there)), change(coarse, softer))


def film_error(figure: float, of_grid: float, of_mesh: float = 0.0) -> float:
    """Error of a figure, percent, 100 at most, by its changes from a coarser grid and to a softer bore.

    Of first order in cells and steps, by which it holds 34 smallest gaps and 36 highest pressures of 36
    random films against finer grids and meshes, by second order 30 and 23: oil that ruptures and holes move
    from cell to cell, loads jump within a step, and voids that close in one take up power.
    """
    error = of_grid / (FINE[0] / COARSE[0] - 1) + of_mesh
    return 100 * min(1.0, error / abs(figure)) if figure else 100.0
