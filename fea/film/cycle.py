"""A film through the cycle of its engine, step by step until it repeats itself and its heat balances."""

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from fea.base.units import UM
from fea.film.constitutive import Oil, WarmOil
from fea.film.journal import Bearing, JournalState
from fea.film.reynolds import Conditions, Supply
from fea.solid.errors import FilmError
from geometry.arrays import Floats

# Share of a cycle over which loads and displacements are brought up before the first whole cycle.
_RAMP = 0.25
# Most parts of a step that fails, and most failures in about a cycle: a film has a few, while one whose
# asperities are pressed flat has them at every other step.
_MOST_PARTS, _MOST_FAILED = 64, 20
# Relative change of the film from one cycle to the next at which it repeats itself, and within how many it
# must: two are usual at the big end; what refills the small end fades from one to the next.
REPEATED = 1e-3
MOST_CYCLES = 48
# Part of a cycle after which the film is looked at again.
_PART = 1 / 12
# What the heat balance may leave, K: of a first film, and of one that begins at the temperature of a coarser
# one, which differs by the grids only; and the highest temperature, °C.
_SETTLED, _SETTLED_AGAIN, HOTTEST = 0.5, 0.9, 250.0
# First guess of the film's temperature above that of the inlet, K, and of the power of the viscosity in
# proportion to which the oil warms up: thinner oil rubs less and flows faster.
_WARMER, _POWER, _POWERS = 25.0, 1.25, (0.3, 3.0)
# Most temperatures that are tried: of films that asperities carry, the heat may have no balance.
_MOST_TRIED = 16
# Change of the logarithm of the viscosity that tells that power; and what is unbalanced so far, K, that the
# temperature changes after one cycle, although the film still depends on how it began.
_TOLD, _FAR_OFF = 0.005, 5.0
# Supplied films are more than half full in the mean; with less than this after some cycles, they starve; one
# that is as hot as the model allows after as many has no heat balance.
_STARVED, _SOON = 1 / 3, 4


def between(values: Floats, places: Floats | float) -> Floats:
    """Values (…) at places between the steps (n, …) of a cycle, which repeats, by linear interpolation."""
    first = np.floor(places).astype(int)
    share = np.reshape(places - first, (*np.shape(places), *(1,) * (values.ndim - 1)))
    one, other = values[first % len(values)], values[(first + 1) % len(values)]
    return np.asarray(one + share * (other - one))


@dataclass(frozen=True, kw_only=True)
class JournalLoads:
    """What acts at n equal steps of a cycle, which repeats; in the axes of the bore."""

    period: float  #: s
    load: Floats  #: (n, 2) force of the film on the bore, N; (n, 4) with tilts: see `Bearing.solve`
    speed: Floats  #: (n,) of the journal's surface relative to the bore's, mm/s
    inlet: float  #: pressure of the oil that is supplied, MPa above the surroundings
    above: Floats | float = 0.0  #: (n_angle, n_width) by how much it is higher in some of the cells
    hole_diameter: float = 0.0  #: of the oil hole in the journal, mm; 0 for none
    hole_angle: Floats | None = None  #: (n,) of it from +x, rad
    grooves: Floats | None = None  #: (n_angle, n_width) share of each cell that grooves of the bore cover
    #: The same of grooves in the journal, from the angle of its hole
    turning: Callable[[float], Floats] | None = None
    flooded: bool = False  #: whether the ends of the bearing stand in oil of the inlet's pressure
    loaded: Floats | None = None  #: (n, n_functions) g of `fea.film.journal.ElasticBore`
    #: (n, n_functions, n_functions) C of it where that changes; otherwise it is the bearing's
    compliance: Floats | None = None

    @property
    def count(self) -> int:
        """Number of steps of a cycle."""
        return len(self.speed)

    def supply(self, bearing: Bearing, place: float) -> Supply | None:
        """Return the holes and grooves at a place between steps."""
        share = self.grooves
        if self.hole_angle is not None and self.hole_diameter:
            turned = complex(between(np.exp(1j * self.hole_angle), place))
            angle = math.atan2(turned.imag, turned.real)
            hole = bearing.reynolds.grid.hole(angle, self.hole_diameter)
            hole = hole if self.turning is None else np.maximum(hole, self.turning(angle))
            share = hole if share is None else np.maximum(share, hole)
        if share is None and self.flooded:
            share = np.zeros(bearing.reynolds.grid.shape)
        if share is None:
            return None
        return Supply(share, self.inlet + self.above, self.inlet if self.flooded else 0.0)

    def solve(
        self, bearing: Bearing, guess: JournalState, place: float, rate: float, before: Floats
    ) -> JournalState:
        """Solve at a place; `rate` and `before` as of `Conditions`. Raises `FilmError`: no convergence."""
        brought_up = min(1.0, 1 + place / (_RAMP * self.count))
        speed, supply = float(between(self.speed, place)), self.supply(bearing, place)
        if self.compliance is not None:
            bearing = bearing.yielding_by(between(self.compliance, place))
        return bearing.solve(
            guess,
            Conditions(speed, supply, rate, before),
            load=brought_up * between(self.load, place),
            loaded=None if self.loaded is None else brought_up * between(self.loaded, place),
        )


@dataclass(frozen=True)
class FilmCycle:
    """A film at n steps of a cycle that repeats itself."""

    bearing: Bearing
    acting: JournalLoads
    states: Sequence[JournalState]  #: n
    #: How far the last state is from that a cycle before: `fea.film.journal.JournalState.unlike`
    unrepeated: float
    temperature: float | None = None  #: of the film, °C, where the heat balance gives it
    unbalanced: float = 0.0  #: temperature that the heat balance asks for less that of the film, K

    @property
    def repeats(self) -> bool:
        """Whether the film is that of the cycle before, and as much oil came in as left."""
        change = self.bearing.slack * REPEATED
        return self.unrepeated <= change and abs(self.supplied - self.leaked) <= change * self.leaked

    @cached_property
    def starved(self) -> bool:
        """Whether the supply cannot keep the film full: little is left, or it goes on losing oil."""
        losing = not self.repeats and self.supplied < 0.98 * self.leaked
        return losing or bool(self.filled.mean() < _STARVED)

    @property
    def too_hot(self) -> bool:
        """Whether the film reaches the highest temperature of the model."""
        return self.temperature is not None and self.temperature > HOTTEST - 1

    @cached_property
    def thinnest(self) -> Floats:
        """Smallest gap (n,), mm."""
        return np.array([state.thinnest for state in self.states])

    @cached_property
    def highest(self) -> Floats:
        """Highest pressure (n,), MPa."""
        return np.array([state.pressure.max() for state in self.states])

    @cached_property
    def asperities(self) -> Floats:
        """Share (n,) of the pressure on the bore that asperities carry."""
        total = self.bearing.reynolds.grid.total
        return np.array([total(state.touching) / total(state.pressure) for state in self.states])

    @cached_property
    def filled(self) -> Floats:
        """Share (n,) of the gap that is full of oil."""
        total = self.bearing.reynolds.grid.total
        return np.array([total(state.volume) / total(state.gap) for state in self.states])

    @cached_property
    def eccentricity(self) -> Floats:
        """Position (n, 2) of the journal's centre over the clearance."""
        return np.array([state.position[:2] for state in self.states]) / self.bearing.clearance

    @cached_property
    def tilted(self) -> float:
        """Largest tilt of the journal: by how much its axis moves across the bore from end to end, mm."""
        return max(2 * float(np.linalg.norm(state.position[2:])) for state in self.states)

    @cached_property
    def friction(self) -> Floats:
        """Force (n,) against the journal's motion, N, and power (n,) that the film dissipates, N·mm/s."""
        force, sheared = np.array([state.friction for state in self.states]).T
        return np.stack([force, sheared + [state.balance.pressed for state in self.states]])

    @cached_property
    def dissipated(self) -> float:
        """Mean power that the film turns into heat, N·mm/s."""
        return float(self.friction[1].mean())

    @cached_property
    def driven(self) -> float:
        """Mean power of rotation, motions, voids and inlet, N·mm/s, which `dissipated` should equal.

        Voids that close take up power by the differences in time, less of it the shorter the steps are, and
        so do asperities, which give back what they took up, and oil that presses where they leave no space.
        """
        acting, step, grid = self.acting, self.acting.period / self.acting.count, self.bearing.reynolds.grid
        places = np.array([state.position[: acting.load.shape[1]] for state in self.states])
        power = self.friction[0] * acting.speed + (acting.load * _rate(places, step)).sum(axis=1)
        if self.bearing.bore is not None:
            bulges = np.array([state.bulge for state in self.states])
            power -= (self.weights * _rate(bulges, step)).sum(axis=1)
        fields = zip(*((s.planes, s.volume, s.film.pressure, s.touching) for s in self.states), strict=True)
        planes, volumes, pressures, touching = (np.array(each) for each in fields)
        kept = touching * _rate(planes, step) + pressures * _rate(planes - volumes, step)
        power += [grid.total(each) for each in kept]
        return float(power.mean() + self._flows[2])

    @cached_property
    def weights(self) -> Floats:
        """Weights (n, n_functions) of the pressures in the functions of the elastic bore, N."""
        if self.bearing.bore is None:
            return np.zeros((len(self.states), 0))
        pressures = np.array([state.pressure for state in self.states])
        return self.bearing.reynolds.grid.resultants(pressures, self.bearing.bore.functions)

    @cached_property
    def supplied(self) -> float:
        """Mean flow of oil through holes, grooves and flooded ends, mm³/s."""
        return float(self._flows[0])

    @cached_property
    def leaked(self) -> float:
        """Mean flow of oil out of the ends, mm³/s."""
        return float(self._flows[1])

    @cached_property
    def _flows(self) -> Floats:
        return np.asarray(np.mean([state.flows for state in self.states], axis=0))


def _rate(values: Floats, step: float) -> Floats:
    """Time derivative (n, …) of values (n, …) that repeat, by the differences of the steps."""
    return np.asarray((3 * values - 4 * np.roll(values, 1, 0) + np.roll(values, 2, 0)) / (2 * step))


@dataclass
class _Integration:
    """A film on its way through its steps."""

    bearing: Bearing
    acting: JournalLoads
    place: int  #: of the last state, in steps; below 0 the loads are brought up
    states: deque[JournalState]  #: at whole steps up to the last one, over a cycle at most
    #: 3/2 of the oil (n_angle, n_width) less 1/2 of that a step before, mm: its sum changes by what flows in
    #: and out in the steps of the second order, and so it must in those of Euler's method that replace them.
    oil: Floats
    failed: float = 0.0  #: times that a step, or its parts, was not solved, fewer the longer ago

    @classmethod
    def begun(cls, bearing: Bearing, acting: JournalLoads, before: FilmCycle | None) -> "_Integration":
        """Bring up the loads, or begin a quarter before the end of a cycle of the same bearing."""
        count, lead = acting.count, math.ceil(_RAMP * acting.count)
        if before is not None:
            start = round((1 - lead / count) * len(before.states))
            if before.acting.count == count and before.bearing.reynolds.grid == bearing.reynolds.grid:
                states = [*before.states[start:], *before.states[: start + 1]]
                oil = 1.5 * states[-1].volume - states[-2].volume / 2
            else:
                states = [bearing.taken_over(before.states[start])]
                oil = states[0].volume
            return cls(bearing, acting, count - lead, deque(states, count + 1), oil)
        rest, rate = bearing.start(), count / acting.period
        first = acting.solve(bearing, rest, -lead, rate, rate * rest.volume)
        course = cls(bearing, acting, -lead, deque([first], 2), first.volume)
        while course.place < -1:
            course.advance()
        course.states = deque(course.states, count + 1)
        return course

    def advance(self) -> None:
        """Go on by a step: by second backward differences, or by Euler's method if they fail."""
        step, states, guesses = self.acting.period / self.acting.count, self.states, []
        last, self.place = states[-1], self.place + 1
        self.failed *= 1 - 1 / self.acting.count
        if len(states) > 1:  # as a cycle before, or as in the last step
            like = (states[0], states[1]) if len(states) == states.maxlen else (states[-2], last)
            guesses = [replace(guess, response=like[1].response) for guess in (last.ahead(*like), last)]
        oil = self.oil + last.volume / 2
        # Differences leave less than nothing in a cell that drains fast; or it is empty, and owes that.
        ways = [oil] if oil.min() >= 0 else [oil, np.maximum(oil, 0.0)]
        for guess, kept in [(guess, kept) for kept in ways for guess in guesses]:
            try:
                states.append(self.acting.solve(self.bearing, guess, self.place, 1.5 / step, kept / step))
            except FilmError as error:
                self._failed(last, error, _MOST_FAILED)
                continue
            self.oil = 1.5 * states[-1].volume - last.volume / 2 + oil - kept
            return
        states.append(self._in_parts(last, 1))
        self.oil = self.oil + states[-1].volume - last.volume

    def _in_parts(self, last: JournalState, parts: int) -> JournalState:
        """Go on by Euler's method in equal parts of a step, or in twice as many where that fails."""
        rate, states = parts * self.acting.count / self.acting.period, [last]
        try:
            for place in self.place - 1 + np.arange(1, parts + 1) / parts:
                oil = rate * states[-1].volume
                states.append(self.acting.solve(self.bearing, states[-1], float(place), rate, oil))
        except FilmError as error:
            self._failed(states[-1], error, _MOST_FAILED if parts < _MOST_PARTS else 0)
            return self._in_parts(last, 2 * parts)
        return replace(states[-1], parts=states[1:-1])

    def _failed(self, last: JournalState, error: FilmError, most: int) -> None:
        """Count what was not solved after a state, and raise `FilmError` beyond the most."""
        self.failed += 1
        if self.failed > most:
            grid = self.bearing.reynolds.grid
            gap, pressure = max(last.thinnest, 0.0) / UM, last.pressure
            specific = np.hypot(*self.acting.load.T[:2]).max() / (2 * grid.radius * grid.width)
            text = f"{gap:.2g} µm at {pressure.max():.3g} MPa under up to {specific:.3g} MPa of specific load"
            if last.touching.any():
                text += f", with asperities at up to {last.touching.max():.3g} MPa"
            raise FilmError(f"the oil film was not solved beyond {text}: {error}") from error


@dataclass(frozen=True)
class HeatBalance:
    """The film is as warm as the oil that leaves it, which carries away a share of the friction power."""

    oil: WarmOil
    inlet: float  #: temperature of the oil that is supplied, °C
    share: float


@dataclass
class _HeatSearch:
    """The film's temperature on its way to the heat balance."""

    heat: HeatBalance
    temperature: float
    changes: int = 0
    _power: float = _POWER
    _tried: tuple[float, float] | None = None

    @property
    def oil(self) -> Oil:
        """The oil at the temperature."""
        return self.heat.oil.at(self.temperature)

    def judged(self, cycle: FilmCycle) -> FilmCycle:
        """A cycle with its temperature, and that of oil that leaves with its heat less it."""
        heat, found = self.heat, replace(cycle, temperature=self.temperature)
        rise = heat.share * cycle.dissipated / (cycle.leaked * heat.oil.carried(self.temperature))
        return replace(found, unbalanced=min(heat.inlet + rise, HOTTEST) - self.temperature)

    def change(self, unbalanced: float) -> None:
        """Take the temperature at which the heat balances if it is in proportion to a power of viscosity."""
        inlet, viscosity, self.changes = self.heat.inlet, self.oil.viscosity, self.changes + 1
        rise = max(self.temperature + unbalanced - inlet, 0.0)
        if self._tried is not None and min(rise, self._tried[0]) > 0:
            rises, thickens = math.log(rise / self._tried[0]), math.log(viscosity / self._tried[1])
            if abs(thickens) > _TOLD:
                self._power = float(np.clip(rises / thickens, *_POWERS))
        self._tried = rise, viscosity

        def lacking(temperature: float) -> float:
            thickness = self.heat.oil.at(temperature).viscosity / viscosity
            return float(inlet + rise * thickness**self._power - temperature)

        self.temperature = float(brentq(lacking, inlet, HOTTEST))


def integrate(
    bearing: Bearing,
    acting: JournalLoads,
    *,
    heat: HeatBalance | None = None,
    before: FilmCycle | None = None,
    most: int = MOST_CYCLES,
) -> FilmCycle:
    """Integrate a film until its cycle repeats itself and its heat balances, and return the last cycle.

    `heat`: what the temperature of the oil follows from; without it the oil is that of the bearing; `before`:
    a cycle of the same bearing with other cells or steps, to begin with; `most`: largest number of cycles, at
    least one. Raises `FilmError`: a step was not solved, however short it was made.
    """
    count, warming, settled = acting.count, None, _SETTLED if before is None else _SETTLED_AGAIN
    if heat is not None:
        guess = None if before is None else before.temperature
        warming = _HeatSearch(heat, heat.inlet + _WARMER if guess is None else guess)
        bearing = bearing.with_oil(warming.oil)
    course = _Integration.begun(bearing, acting, before)
    unchanged, left = 0, most * count
    while True:
        course.advance()
        unchanged, left = unchanged + 1, left - 1
        if unchanged < count or left % math.ceil(_PART * count):
            continue
        of_0, (first, *states) = count - 1 - course.place % count, course.states
        ordered, unrepeated = states[of_0:] + states[:of_0], states[-1].unlike(first)
        cycle = FilmCycle(course.bearing, acting, ordered, unrepeated)
        if warming is not None:
            cycle = warming.judged(cycle)
        off, fails = abs(cycle.unbalanced), cycle.too_hot or cycle.filled.mean() < _STARVED
        ends = left <= 0 or (fails and left < (most - _SOON) * count)
        if warming is not None and off > settled:
            ends = ends or warming.changes >= _MOST_TRIED
        if ends or (cycle.repeats and off <= settled):
            return cycle
        known = unchanged >= (1 + _RAMP) * count or off > _FAR_OFF
        if warming is not None and left >= count and off > settled and known:
            warming.change(cycle.unbalanced)
            course.bearing, unchanged = bearing.with_oil(warming.oil), 0
