"""A film through the cycle of its engine, step by step until it repeats itself and its heat balances."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fea.film.journal import Bearing, JournalState
from fea.film.oil import WarmOil
from fea.film.reynolds import Conditions, Supply
from fea.machine.threads import one_blas_thread
from fea.solid.errors import FilmError
from geometry.arrays import Floats

# Share of a cycle over which loads and displacements are brought up before the first whole cycle.
_RAMP = 0.25
# How often a step that fails is halved.
_HALVINGS = 6
# Relative change of the film from one cycle to the next at which it repeats itself; two cycles are usual.
REPEATED = 1e-3
MOST_CYCLES = 12
# Difference of temperature to which the heat balance is solved, K, and the highest temperature, °C.
_SETTLED, HOTTEST = 0.2, 250.0
# First guess of the film's temperature above that of the inlet, and of the slope of what is unbalanced over
# the temperature: hotter oil rubs less and flows faster. Secants of this range replace the guess.
_WARMER, _SLOPE, _SLOPES = 25.0, -1.8, (-8.0, -1.0)
# Largest change of the temperature from one cycle to the next, K.
_LARGEST_CHANGE = 40.0
# Supplied films are more than half full in the mean; with less than this after some cycles, they starve.
_STARVED, _SOON = 1 / 3, 4


@dataclass(frozen=True, kw_only=True)
class JournalLoads:
    """What acts at n equal steps of a cycle, which repeats; in the axes of the bore."""

    period: float  #: s
    load: Floats  #: (n, 2) force of the film on the bore, N
    speed: Floats  #: (n,) of the journal's surface relative to the bore's, mm/s
    inlet: float  #: pressure of the oil that is supplied, MPa above the surroundings
    hole_diameter: float = 0.0  #: of the oil hole in the journal, mm; 0 for none
    hole_angle: Floats | None = None  #: (n,) of it from +x, rad
    grooves: Floats | None = None  #: (n_angle, n_width) share of each cell that grooves of the bore cover
    loaded: Floats | None = None  #: (n, n_functions) g of `fea.film.journal.ElasticBore`

    @property
    def count(self) -> int:
        """Number of steps of a cycle."""
        return len(self.speed)

    def _at(self, values: Floats, place: float) -> Floats:
        """Values at a place between steps, by linear interpolation."""
        first = math.floor(place)
        one, other = values[first % self.count], values[(first + 1) % self.count]
        return np.asarray(one + (place - first) * (other - one))

    def supply(self, bearing: Bearing, place: float) -> Supply | None:
        """Return the holes and grooves at a place between steps."""
        share = self.grooves
        if self.hole_angle is not None and self.hole_diameter:
            turned = complex(self._at(np.exp(1j * self.hole_angle), place))
            hole = bearing.reynolds.grid.hole(math.atan2(turned.imag, turned.real), self.hole_diameter)
            share = hole if share is None else np.maximum(share, hole)
        return None if share is None else Supply(share, self.inlet)

    def solve(
        self, bearing: Bearing, guess: JournalState, place: float, rate: float, before: Floats
    ) -> JournalState:
        """Solve at a place; `rate` and `before` as of `Conditions`. Raises `FilmError`: no convergence."""
        brought_up = min(1.0, 1 + place / (_RAMP * self.count))
        speed, supply = float(self._at(self.speed, place)), self.supply(bearing, place)
        return bearing.solve(
            guess,
            Conditions(speed, supply, rate, before),
            load=brought_up * self._at(self.load, place),
            loaded=None if self.loaded is None else brought_up * self._at(self.loaded, place),
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
        """Whether the film is that of the cycle before."""
        return self.unrepeated <= REPEATED

    @cached_property
    def starved(self) -> bool:
        """Whether the supply cannot keep the film full: little is left, or it goes on losing oil."""
        losing = not self.repeats and self.supplied < 0.98 * self.leaked
        return losing or bool(self.filled.mean() < _STARVED)

    @cached_property
    def thinnest(self) -> Floats:
        """Smallest gap (n,), mm."""
        return np.array([state.gap.min() for state in self.states])

    @cached_property
    def highest(self) -> Floats:
        """Highest pressure (n,), MPa."""
        return np.array([state.pressure.max() for state in self.states])

    @cached_property
    def asperities(self) -> Floats:
        """Share (n,) of the pressure on the bore that asperities carry."""
        return np.array([state.touching.sum() / state.pressure.sum() for state in self.states])

    @cached_property
    def filled(self) -> Floats:
        """Share (n,) of the gap that is full of oil."""
        return np.array([state.volume.sum() / state.gap.sum() for state in self.states])

    @cached_property
    def eccentricity(self) -> Floats:
        """Position (n, 2) of the journal's centre over the clearance."""
        return np.array([state.position for state in self.states]) / self.bearing.clearance

    @cached_property
    def friction(self) -> Floats:
        """Force (n,) against the journal's motion, N, and power (n,) that the film dissipates, N·mm/s."""
        of_shear = [
            self.bearing.friction(state, float(speed))
            for state, speed in zip(self.states, self.acting.speed, strict=True)
        ]
        force, sheared = np.array(of_shear).T
        return np.stack([force, sheared + [state.balance.pressed for state in self.states]])

    @cached_property
    def dissipated(self) -> float:
        """Mean power that the film turns into heat, N·mm/s."""
        return float(self.friction[1].mean())

    @cached_property
    def driven(self) -> float:
        """Mean power of rotation, motions and inlet, N·mm/s, which `dissipated` should equal."""
        acting, step = self.acting, self.acting.period / self.acting.count
        places = np.array([state.position for state in self.states])
        power = self.friction[0] * acting.speed + (acting.load * _slope(places, step)).sum(axis=1)
        if self.bearing.bore is not None:
            bulges = np.array([state.bulge for state in self.states])
            power -= (self.weights * _slope(bulges, step)).sum(axis=1)
        return float(power.mean() + acting.inlet * self.supplied)

    @cached_property
    def weights(self) -> Floats:
        """Weights (n, n_functions) of the pressures in the functions of the elastic bore, N."""
        if self.bearing.bore is None:
            return np.zeros((len(self.states), 0))
        whole = self.bearing.reynolds.grid.area * self.bearing.reynolds.grid.images
        pressures = np.array([state.pressure for state in self.states])
        return whole * np.tensordot(pressures, self.bearing.bore.functions, axes=2)

    @cached_property
    def supplied(self) -> float:
        """Mean flow of oil through holes and grooves, mm³/s."""
        return float(np.mean([state.balance.supplied for state in self.states]))

    @cached_property
    def leaked(self) -> float:
        """Mean flow of oil out of the ends, mm³/s."""
        return float(np.mean([state.balance.leaked for state in self.states]))


def _slope(values: Floats, step: float) -> Floats:
    """Time derivative (n, …) of values (n, …) that repeat."""
    return np.asarray((np.roll(values, -1, 0) - np.roll(values, 1, 0)) / (2 * step))


@dataclass
class _Course:
    """A film on its way through its steps."""

    bearing: Bearing
    acting: JournalLoads
    last: JournalState
    earlier: Floats | None = None  #: oil (n_angle, n_width) a whole step before the last state

    def advance(self, place: int) -> JournalState:
        """Go on to a whole place: by second backward differences, or by Euler's method if they fail."""
        step, volume = self.acting.period / self.acting.count, self.last.volume
        try:
            if self.earlier is None:
                self._halve(place - 1.0, float(place), _HALVINGS)
            else:
                before = (4 * volume - self.earlier) / (2 * step)
                self.last = self.acting.solve(self.bearing, self.last, place, 1.5 / step, before)
        except FilmError:
            if self.earlier is None:
                raise
            self._halve(place - 1.0, float(place), _HALVINGS)
        self.earlier = volume
        return self.last

    def _halve(self, start: float, end: float, times: int) -> None:
        """Go from place to place by Euler's method in one step, or in halves where that fails."""
        rate = self.acting.count / (self.acting.period * (end - start))
        try:
            self.last = self.acting.solve(self.bearing, self.last, end, rate, rate * self.last.volume)
        except FilmError:
            if not times:
                raise
            middle = (start + end) / 2
            self._halve(start, middle, times - 1)
            self._halve(middle, end, times - 1)


@dataclass(frozen=True)
class HeatBalance:
    """The film is as warm as the oil that leaves it, which carries away a share of the friction power."""

    oil: WarmOil
    inlet: float  #: temperature of the oil that is supplied, °C
    share: float

    def asked(self, cycle: FilmCycle, temperature: float) -> float:
        """Temperature of oil that leaves with the heat of a cycle, °C."""
        heated = self.share * cycle.dissipated / (cycle.leaked * self.oil.carried(temperature))
        return min(self.inlet + heated, HOTTEST)


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
    slope, tried = _SLOPE, None
    count, lead = acting.count, math.ceil(_RAMP * acting.count)
    temperature = None if heat is None else heat.inlet + _WARMER
    if before is not None and heat is not None:
        temperature = before.temperature
    with one_blas_thread():
        if heat is not None and temperature is not None:
            bearing = bearing.with_oil(heat.oil.at(temperature))
        if before is None:
            start, first = bearing.start(), -lead
            course = _Course(bearing, acting, acting.solve(bearing, start, first, 1.0, start.volume))
        else:
            first = count - lead
            start = before.states[round(first / count * len(before.states))]
            course = _Course(bearing, acting, bearing.taken_over(start))
        for place in range(first + 1, first + lead):
            course.advance(place)
        for number in range(most):
            begun = course.last
            states = [course.advance(place) for place in range(count)]
            cycle = FilmCycle(bearing, acting, states, course.last.unlike(begun), temperature)
            if heat is not None and temperature is not None:
                cycle = replace(cycle, unbalanced=heat.asked(cycle, temperature) - temperature)
            settled = abs(cycle.unbalanced) <= _SETTLED
            if (cycle.repeats and settled) or (number >= _SOON and cycle.filled.mean() < _STARVED):
                break
            if heat is not None and temperature is not None and not settled:
                if tried is not None and abs(temperature - tried[0]) > 1.0:
                    secant = (cycle.unbalanced - tried[1]) / (temperature - tried[0])
                    slope = float(np.clip(secant, *_SLOPES))
                tried = temperature, cycle.unbalanced
                temperature -= float(np.clip(cycle.unbalanced / slope, -_LARGEST_CHANGE, _LARGEST_CHANGE))
                course.bearing = bearing = bearing.with_oil(heat.oil.at(temperature))
    return cycle
