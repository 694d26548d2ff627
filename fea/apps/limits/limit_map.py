"""The map of limits: on rays from rest through speed squared and charge, and along lines of operation.

Along a ray all loads grow together, so that each factor falls steadily and passes the required one once. A
line of operation, such as one speed or the full load of every speed, may cross a mode's limit several times:
gas relieves inertia. The limits of the rays tell between which points; root finding on the states does the
rest.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from fea.apps.limits.operation import Operation
from fea.apps.limits.states import Mode, State, States, Worst
from fea.solid.errors import ContactError
from geometry.arrays import Floats
from loads.gas import LARGEST_PEAK

# How exactly an edge is found: the factor there relative to that required; and steps at most.
_FACTOR, _STEPS, _ALMOST = 1e-3, 8, 5e-3
# Relative distance of places from which a slope is taken, at least.
_APART = 2e-3
# A step of the search changes the logarithm of a load by so much at most.
_LEAP = 1.5
# Where no state of contact carries the load: as if a factor were so small.
_NO_STATE = Worst(0.75)
# Rays through the map, and those on which every place is evaluated.
RAYS, ANCHORS = 21, 5
# By how much a load is less with which it is tried again, and the least.
_LESS, _LEAST_LOAD = 0.7, 0.1
# Loads over that at yield beyond which stress is no longer elastic, and nothing is drawn.
ELASTIC = 1.2
# Loads on a ray are at most so many times those of about its limit.
_FURTHEST = 3.0
# Charge beside inertia alone, relative to the one of the limit by gas alone.
_NO_CHARGE = 0.02
# Points of a line of operation between which the limits of the rays are compared.
_POINTS = 240
# Just below the largest pressure of any engine, MPa: the highest that is looked at.
MOST_PEAK = 0.999 * LARGEST_PEAK

Point = tuple[float, float]  # speed, rpm, and multiple of the charge


@dataclass(frozen=True)
class Limit:
    """A point at which a factor is the required one."""

    mode: Mode
    rpm: float
    scale: float  #: multiple of the charge
    peak: float  #: absolute peak pressure, MPa
    worst: Worst
    slope: float  #: d ln x/d ln f of the coordinate x along which it was found


@dataclass(frozen=True)
class Axes:
    """Speed, rpm, and charge that are about the limits by inertia alone and by gas alone."""

    rpm: float
    charge: float

    def point(self, angle: float, load: float) -> Point:
        """Return the point of a ray at a distance from rest."""
        return self.rpm * math.sqrt(load * math.cos(angle)), load * self.charge * math.sin(angle)

    def ray(self, rpm: Floats, charge: Floats) -> tuple[Floats, Floats]:
        """Angles, rad, and distances from rest of points."""
        along, up = (np.asarray(rpm) / self.rpm) ** 2, np.asarray(charge) / self.charge
        return np.arctan2(up, along), np.hypot(along, up)


@dataclass(frozen=True)
class LimitMap:
    """The limits of a rod in an engine."""

    axes: Axes
    angles: Floats  #: (n,) of the rays, rad
    limits: Mapping[Mode, tuple[Limit | None, ...]]  #: on each ray; None where none was found

    def factors(self, rpm: Floats, charge: Floats) -> dict[Mode, Floats]:
        """Estimate the factors over that required at points (n,): linear between rays, as loads are."""
        angle, load = self.axes.ray(rpm, charge)
        found = {}
        for mode, limits in self.limits.items():
            usage = [0.0 if one is None else 1 / self._load(one) for one in limits]
            with np.errstate(divide="ignore"):
                found[mode] = 1 / (np.interp(angle, self.angles, usage) * load)
        return found

    def least(self, rpm: Floats, charge: Floats) -> Floats:
        """Return the least of them (n,); infinite where nothing limits the rod."""
        return least_of(self.factors(rpm, charge), rpm)

    def _load(self, limit: Limit) -> float:
        return float(self.axes.ray(np.asarray(limit.rpm), np.asarray(limit.scale))[1])


def least_of(factors: Mapping[Mode, Floats], points: Floats) -> Floats:
    """Return the least of the factors at points; infinite where nothing limits the rod."""
    return np.min(list(factors.values()), axis=0) if factors else np.full(np.shape(points), np.inf)


def most_charge(operation: Operation, rpm: float) -> float:
    """Return the charge at which the largest pressure of any engine is reached."""
    return operation.scale(rpm, MOST_PEAK)


def ray_angles(operation: Operation, axes: Axes) -> Floats:
    """Angles (n,) of the rays, from inertia alone to gas at idling speed, rad."""
    if not operation.burns:
        return np.zeros(1)
    last = math.atan2(1.0, (operation.idle / axes.rpm) ** 2)
    return np.linspace(math.atan(_NO_CHARGE), last, RAYS)


class Explorer:
    """Finds limits.

    `axes`: those of the rays; `required`: the safety factor; `show` tells of progress.
    """

    def __init__(
        self,
        states: States,
        operation: Operation,
        axes: Axes,
        *,
        required: float,
        show: Callable[[str], None],
    ) -> None:
        self._states, self.operation, self._axes = states, operation, axes
        self._required, self._show = required, show
        self._known: dict[tuple[Operation, Point], State] = {}

    def state(self, point: Point, operation: Operation | None = None) -> State:
        """Return the factors at a point; none where no state of contact carries the load."""
        operation = operation or self.operation
        key = (operation, point)
        if key not in self._known:
            try:
                self._known[key] = self._states.at(operation.cycle(*point))
            except ContactError:
                self._known[key] = {}
        return self._known[key]

    def map(self) -> LimitMap:
        """Find the limit of each mode on rays."""
        self._show("looking at every place of the rod")
        axes, angles = self._axes, ray_angles(self.operation, self._axes)
        anchors = np.unique(np.linspace(0, len(angles) - 1, ANCHORS).round().astype(int))
        points = [axes.point(float(angles[number]), 1.0) for number in anchors]
        self._states.follow([self._states.usage(self.operation.cycle(*point)) for point in points])
        found = []
        for number, angle in enumerate(angles, 1):
            self._show(f"limits on ray {number} of {len(angles)}")
            found.append(self._on_ray(float(angle), axes))
        modes = [mode for mode in Mode if any(mode in own for own in found)]
        return LimitMap(axes, angles, {mode: tuple(own.get(mode) for own in found) for mode in modes})

    def _on_ray(self, angle: float, axes: Axes) -> dict[Mode, Limit]:
        most, known = self._furthest(angle, axes), dict[float, State]()

        def worst(mode: Mode, load: float) -> Worst | None:
            point = axes.point(angle, load)
            if mode is Mode.BUCKLING and load not in known:
                return self._states.buckling(self.operation.cycle(*point))
            known[load] = self.state(point)
            return known[load].get(mode) if known[load] else _NO_STATE

        found: dict[Mode, Limit] = {}
        start = min(1.0, most)
        while not (worst(Mode.YIELD, start) and known[start]) and start > _LEAST_LOAD:
            start *= _LESS  # no state of contact carries so much
        for mode in known[start]:  # yield comes first
            edge = root(lambda load: self._level(worst(mode, load)), most, known)  # noqa: B023 - called at once
            if edge is None:
                continue
            load, slope = edge
            point = axes.point(angle, load)
            if (there := worst(mode, load)) is not None:
                found[mode] = Limit(mode, *point, self.operation.peak(*point), there, slope)
            if mode is Mode.YIELD:
                most = min(most, ELASTIC * load)
        return found

    def _furthest(self, angle: float, axes: Axes) -> float:
        """Load on a ray that no engine exceeds by its speed or its pressure."""
        most = min(_FURTHEST, (self.operation.fastest / axes.rpm) ** 2 / max(math.cos(angle), 1e-9))
        if self.operation.burns:
            rpm, _ = axes.point(angle, most)
            most = min(most, most_charge(self.operation, rpm) / axes.charge / math.sin(angle))
        return most

    def _level(self, worst: Worst | None) -> float:
        return math.inf if worst is None else math.log(worst.factor / self._required)

    def edges(
        self,
        of_rays: LimitMap,
        points: Callable[[float], Point],
        ends: tuple[float, float],
    ) -> tuple[list[Limit], list[tuple[float, float]]]:
        """Find where the least factor passes the required one along a line of operation.

        `points`: the point of a coordinate of the line, such as the speed, between its `ends`.

        Returns
        -------
        limits, safe
            One limit per edge of the intervals (low, high) of the coordinate that are safe.
        """
        x = np.linspace(*ends, _POINTS)
        line = np.array([points(float(each)) for each in x])
        above = of_rays.least(*line.T) > 1
        limits, bounds = list[Limit](), [ends[0]] if above[0] else []
        for number in np.flatnonzero(np.diff(above)):
            limit, at = self._refined(points, float(x[number]), float(x[number + 1]), ends)
            limits.append(limit)
            bounds.append(at)
        if above[-1]:
            bounds.append(ends[1])
        return limits, list(zip(bounds[::2], bounds[1::2], strict=True))

    def _refined(
        self, points: Callable[[float], Point], low: float, high: float, ends: tuple[float, float]
    ) -> tuple[Limit, float]:
        """Find the edge near an interval; every place is looked at there."""
        while True:
            x, slope = _secant(lambda at: self._least(points(at))[0], low, high, ends)
            point = points(x)
            if self._states.certify(self.operation.cycle(*point), self.state(point)):
                return self._limit(point, slope), x
            self._known.clear()

    def _least(self, point: Point, operation: Operation | None = None) -> tuple[float, Mode]:
        """The level of the least factor at a point, and its mode."""
        state = self.state(point, operation) or {Mode.YIELD: _NO_STATE}
        return min((self._level(worst), mode) for mode, worst in state.items())

    def _limit(self, point: Point, slope: float, operation: Operation | None = None) -> Limit:
        """Return the limit by the least factor at a point."""
        of, (_, mode) = operation or self.operation, self._least(point, operation)
        return Limit(mode, *point, of.peak(*point), self.state(point, operation)[mode], slope)

    def fastest(self, operation: Operation, start: float) -> Limit | None:
        """Find the highest speed of another engine, from a speed near it; None if any is safe."""
        most = self.operation.fastest
        known = [min(start, most)]
        edge = root(lambda rpm: self._least((rpm, 1.0), operation)[0], most, known)
        if edge is None:
            return None
        return self._limit((edge[0], 1.0), edge[1], operation)


def _secant(level: Callable[[float], float], low: float, high: float, ends: tuple[float, float]) -> Point:
    """Find where a level passes 0 near an interval; the place x and d ln x/d level there."""
    a, b = low, high
    values = {a: level(a), b: level(b)}
    slope = math.log(b / a) / ((values[b] - values[a]) or 1e-12)
    for _ in range(_STEPS):
        x = min(values, key=lambda at: abs(values[at]))
        if abs(values[x]) < _FACTOR:
            break
        step = min(max(x * math.exp(-slope * values[x]), ends[0]), ends[1])
        above, below = ([at for at, value in values.items() if (value > 0) is side] for side in (True, False))
        if above and below:
            near = min(((p, q) for p in above for q in below), key=lambda pair: abs(pair[0] - pair[1]))
            if not min(near) < step < max(near):
                step = math.sqrt(near[0] * near[1])
        if step in values:
            break
        values[step] = level(step)
        slope = math.log(step / x) / ((values[step] - values[x]) or 1e-12)
    x = min(values, key=lambda at: abs(values[at]))
    return x, _slope(values, x)


def _slope(values: Mapping[float, float], x: float) -> float:
    """D ln x/d level at a place, from the nearest other one that is not so near that rounding counts."""
    others = [at for at in values if abs(math.log(at / x)) >= _APART and math.isfinite(values[at])]
    if not others:
        return -1.0
    other = min(others, key=lambda at: abs(math.log(at / x)))
    change = values[other] - values[x]
    return math.log(other / x) / change if change else -1.0


def root(
    level: Callable[[float], float],
    most: float,
    known: Mapping[float, object] | list[float],
) -> Point | None:
    """Find where a level that falls passes 0, by secants in ln x within a bracket.

    `known`: places whose level is at hand. Returns the place and d ln x/d level there; None where the level
    is above 0 up to `most`, or the place is not found.
    """
    values = {x: level(x) for x in list(known)}
    slope = -1.0
    for _ in range(_STEPS):
        x = min(values, key=lambda at: abs(values[at]))
        if abs(values[x]) < _FACTOR:
            break
        above = max((at for at, value in values.items() if value > 0), default=0.0)
        below = min((at for at, value in values.items() if value <= 0), default=math.inf)
        if above >= most or not math.isfinite(values[x]):
            return None
        step = x * math.exp(min(max(-slope * values[x], -_LEAP), _LEAP))
        if not above < step < below and above and math.isfinite(below):
            step = math.sqrt(above * below)
        step = min(step, most)
        if step in values:
            return None
        values[step] = level(step)
        change = values[step] - values[x]
        slope = math.log(step / x) / change if change and math.isfinite(change) else -1.0
    x = min(values, key=lambda at: abs(values[at]))
    return (x, _slope(values, x)) if x <= most and abs(values[x]) < _ALMOST else None
