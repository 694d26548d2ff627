"""The map of limits: on rays from rest through speed squared and charge, and along lines of operation.

Along a ray all loads grow together, so that each factor falls steadily and passes the required one once. A
line of operation, such as one speed or the full load of every speed, may cross a mode's limit several times:
gas relieves inertia. A survey of a few rays tells between which points, and root finding on the states does
the rest: the answer in words needs no more. The map has more rays, with the limit of every mode on each.

States of a rod in parts are costly. Until the map is there, its limits are estimates. The map has the rays of
the survey, and utilisations between the few states of a ray, and between these and the rod at rest, are
interpolated.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple, TypeVar

import numpy as np

from fea.apps.limits.operation import Operation
from fea.apps.limits.states import ONSETS, Mode, State, States, Worst
from fea.base.root import ALMOST, STEPS, WITHIN, Root, leap, root
from fea.solid.errors import ContactError
from geometry.arrays import Floats
from loads.crank_cycle import CrankCycle
from loads.gas import LARGEST_PEAK

# How exactly an edge is found where states are costly: the factor there relative to that required.
_OF_COSTLY = 3e-3
# Of the largest load of a ray that was solved: the largest that is next.
_NEXT = 1.5
# Where no state of contact carries the load: as if a factor were so small.
_NO_STATE = Worst(0.75)
_WITHOUT: State = {Mode.YIELD: _NO_STATE}
# Rays of the map, and of the survey.
RAYS, ANCHORS = 13, 5
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
# Relative distance of a costly state from a limit of its ray at which no other one is solved, and that
# at which a limit counts as interpolated.
_NEAR, _SOLVED = 0.04, 5e-3
# An estimated edge is solved and moved at most so often, or until the factor there is the required one to
# within this share.
_CHECKS, _CLOSE = 3, 0.02
# By which share of the coordinate the slope there is measured, and the least relative uncertainty of what is
# estimated: another mode, place or instant may end the rod.
_STEP, _LEAST_SPREAD = 0.03, 0.015
# Relative distance within which an edge that was found is that of another map, too.
_SAME = 0.03
# Just below the largest pressure of any engine, MPa: the highest that is looked at.
MOST_PEAK = 0.999 * LARGEST_PEAK

T = TypeVar("T")
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
    interpolated: bool = False  #: between states that were solved
    spread: float = 0.0  #: relative uncertainty of the coordinate where it is estimated


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
    loads: Mapping[Mode, Floats]  #: (n,) distances of the limit of each mode from rest; infinite without one
    rest: Mapping[Mode, float]  #: utilisation of the required factor at rest, where it is not 0
    #: on each ray; None where none was found. Empty in a survey
    limits: Mapping[Mode, tuple[Limit | None, ...]] = field(default_factory=dict)

    def factors(self, rpm: Floats, charge: Floats) -> dict[Mode, Floats]:
        """Estimate the factors over that required at points (n,): utilisations are linear between rays."""
        angle, load = self.axes.ray(rpm, charge)
        angle = np.clip(angle, self.angles[0], self.angles[-1])
        after = np.clip(np.searchsorted(self.angles, angle), 1, max(len(self.angles) - 1, 1))
        ends = np.append(self.angles, self.angles[-1] + 1.0)[np.stack([after - 1, after])]
        # A point is the sum of vectors along the rays beside it.
        shares = np.sin([ends[1] - angle, angle - ends[0]]) / np.sin(ends[1] - ends[0])
        factors = {}
        for mode, loads in self.loads.items():
            inverse, still = np.append(1 / loads, 0.0), self.rest.get(mode, 0.0)
            usage = (shares[0] * inverse[after - 1] + shares[1] * inverse[after]) * load
            with np.errstate(divide="ignore"):
                factors[mode] = 1 / (still + max(1 - still, 0.0) * usage)
        return factors

    def least(self, rpm: Floats, charge: Floats) -> Floats:
        """Return the least of them (n,); infinite where nothing limits the rod."""
        return least_of(ending(self.factors(rpm, charge)), rpm)


def ending(of_modes: Mapping[Mode, T]) -> dict[Mode, T]:
    """Return what belongs to the modes that end a rod."""
    return {mode: own for mode, own in of_modes.items() if mode not in ONSETS}


def least_of(factors: Mapping[Mode, Floats], points: Floats) -> Floats:
    """Return the least of the factors at points; infinite where nothing limits the rod."""
    return np.min(list(factors.values()), axis=0) if factors else np.full(np.shape(points), np.inf)


def furthest(operation: Operation, axes: Axes, angle: float) -> float:
    """Return the load on a ray that no engine exceeds by its speed or its pressure."""
    most = min(_FURTHEST, (operation.fastest / axes.rpm) ** 2 / max(math.cos(angle), 1e-9))
    if operation.burns:
        rpm, _ = axes.point(angle, most)
        most = min(most, operation.scale(rpm, MOST_PEAK) / axes.charge / math.sin(angle))
    return most


def ray_angles(operation: Operation, axes: Axes, count: int) -> Floats:
    """Angles (n,) of the rays, from inertia alone to gas at idling speed, rad."""
    if not operation.burns:
        return np.zeros(1)
    last = math.atan2(1.0, (operation.idle / axes.rpm) ** 2)
    return np.linspace(math.atan(_NO_CHARGE), last, count)


class Line(NamedTuple):
    """A line of operation."""

    name: str
    operation: Operation
    point: Callable[[float], Point]  #: of a coordinate of the line, such as the speed
    ends: tuple[float, float]  #: of the coordinate


class _Crossing(NamedTuple):
    """Where utilisations along a ray pass 1: the load, d ln load/d ln f there, and the nearest sample."""

    load: float
    slope: float
    near: float


def _crossing(usage: Mapping[float, float]) -> _Crossing | None:
    """Find it between samples, or beyond the last; None if the utilisation does not grow there."""
    loads = sorted(usage)
    for low, high in pairwise(loads):
        rise = (usage[high] - usage[low]) / (high - low)
        if rise > 0 and (usage[high] >= 1 or high == loads[-1]):
            load = max(low + (1 - usage[low]) / rise, 0.0)
            near = min((at for at in loads if at > 0), key=lambda at: abs(at - load))
            return _Crossing(load, -1 / max(rise * load, 1e-12), near)
    return None


class Explorer:
    """Finds limits. `axes`: those of the rays; `required`: the safety factor; `show` tells of progress."""

    def __init__(
        self, states: States, operation: Operation, axes: Axes, required: float, show: Callable[[str], None]
    ) -> None:
        self._states, self.operation, self._axes = states, operation, axes
        self._required, self._show = required, show
        self._within = _OF_COSTLY if states.costly else WITHIN
        self.certain = not states.costly  #: whether states are more than estimates
        self._known: dict[tuple[Operation, Point, bool], State] = {}
        self._rays: dict[float, dict[float, State]] = {}  # by angle and load, those of the survey
        self._edges: list[tuple[str, float, Limit, bool]] = []
        self.rest = {mode: required / worst.factor for mode, worst in states.rest.items()}

    def state(self, point: Point, operation: Operation) -> State:
        """Return the factors at a point; none where no state of contact carries the load."""
        return self._found(point, operation, certain=self.certain)

    def _found(self, point: Point, operation: Operation, *, certain: bool) -> State:
        key = (operation, point, certain)
        if key not in self._known:
            find = self._states.at if certain else self._states.estimate
            self._known[key] = self._tried(find, operation, point)
        return self._known[key]

    def _tried(self, find: Callable[[CrankCycle], State], operation: Operation, point: Point) -> State:
        try:
            return find(operation.cycle(*point))
        except ContactError:
            return {}

    def survey(self) -> LimitMap:
        """Estimate the limits of the modes from one state on each of a few rays."""
        angles = ray_angles(self.operation, self._axes, ANCHORS)
        order = list(range(len(angles)))
        if self._states.costly:  # the outer ones tell about where the limits of the inner ones are
            order = [0, *order[:0:-1]]
        for done, number in enumerate(order):
            self._show(f"surveying every node of the rod, {done + 1} of {len(order)}")
            angle = float(angles[number])
            load = self._first(angle) if self._states.costly and done > 1 else 1.0
            load = min(load, furthest(self.operation, self._axes, angle))
            state = self._on(angle, load)
            while state is _WITHOUT and load > _LEAST_LOAD:
                load *= _LESS
                state = self._on(angle, load)
            self._rays[angle] = {load: state}
        return self._surveyed()

    def _on(self, angle: float, load: float) -> State:
        """The factors on a ray of the survey."""
        return self._tried(self._states.survey, self.operation, self._axes.point(angle, load)) or _WITHOUT

    def _surveyed(self) -> LimitMap:
        angles = sorted(self._rays)
        every = {mode for ray in self._rays.values() for own in ray.values() for mode in own}
        modes = [mode for mode in Mode if mode in every]
        crossings = {mode: [self._edge(angle, mode) for angle in angles] for mode in modes}
        loads = {
            mode: np.array([math.inf if one is None else max(one.load, 1e-9) for one in own])
            for mode, own in crossings.items()
        }
        return LimitMap(self._axes, np.array(angles), loads, self.rest)

    def _edge(self, angle: float, mode: Mode) -> _Crossing | None:
        """Where a mode limits a ray of the survey, between its states and rest."""
        samples = {load: own[mode] for load, own in self._rays[angle].items() if mode in own}
        if not samples:
            return None
        usage = {load: self._required / worst.factor for load, worst in samples.items()}
        return _crossing({0.0: self.rest.get(mode, 0.0), **usage})

    def _first(self, angle: float) -> float:
        """Load of the first limit of a ray, as far as is known; 1 if nothing limits it."""
        rpm, charge = self._axes.point(angle, 1.0)
        of_rays = self._surveyed()
        loads = [
            (1 - self.rest.get(mode, 0.0)) / (1 / factor - self.rest.get(mode, 0.0))
            for mode, factor in ending(of_rays.factors(np.array(rpm), np.array(charge))).items()
            if 1 / factor > self.rest.get(mode, 0.0)
        ]
        return float(min(loads, default=1.0)) or 1.0

    def map(self) -> LimitMap:
        """Find the limit of each mode on every ray, after a survey."""
        if self._states.costly:
            return self._interpolated()
        angles = ray_angles(self.operation, self._axes, RAYS)
        found = []
        for number, angle in enumerate(angles.tolist(), 1):
            self._show(f"limits on ray {number} of {len(angles)}")
            found.append(self._on_ray(angle))
        return self._mapped(angles, found)

    def _mapped(self, angles: Floats, found: Sequence[Mapping[Mode, Limit]]) -> LimitMap:
        modes = [mode for mode in Mode if any(mode in own for own in found)]
        limits = {mode: tuple(own.get(mode) for own in found) for mode in modes}
        loads = {mode: np.array([self._load(one) for one in own]) for mode, own in limits.items()}
        return LimitMap(self._axes, angles, loads, self.rest, limits)

    def _load(self, limit: Limit | None) -> float:
        if limit is None:
            return math.inf
        return float(self._axes.ray(np.asarray(limit.rpm), np.asarray(limit.scale))[1])

    def _interpolated(self) -> LimitMap:
        """Solve states near the first limit of each ray of the survey and near that of yielding.

        Which place yields first changes along a ray, so that its utilisation bends upwards: extrapolated
        from states where the stress of the press fits is the largest, the limit would lie too far out.
        """
        angles = sorted(self._rays)
        for number, angle in enumerate(angles, 1):
            known, most = self._rays[angle], furthest(self.operation, self._axes, angle)
            load = min(self._first(angle), most)
            for step in range(STEPS):
                if min(abs(load / one - 1) for one in known) > _NEAR:
                    self._show(f"limits on ray {number} of {len(angles)}")
                    known[load] = self._on(angle, load)
                elif step:
                    break
                edge = self._edge(angle, Mode.YIELD)
                load = min(math.inf if edge is None else edge.load, _NEXT * max(known), most)
        return self._mapped(np.array(angles), [dict(self._limits_on(angle)) for angle in angles])

    def _limits_on(self, angle: float) -> Iterable[tuple[Mode, Limit]]:
        yielding = self._edge(angle, Mode.YIELD)
        most = math.inf if yielding is None else ELASTIC * yielding.load
        most = min(most, furthest(self.operation, self._axes, angle))
        for mode in Mode:
            edge = self._edge(angle, mode)
            if edge is None or not 0 < edge.load <= most:
                continue
            point, worst = self._axes.point(angle, edge.load), self._rays[angle][edge.near].get(mode)
            if worst is not None:
                apart = abs(edge.near / edge.load - 1) > _SOLVED
                peak = self.operation.peak(*point)
                yield mode, Limit(mode, *point, peak, worst, edge.slope, interpolated=apart)

    def _on_ray(self, angle: float) -> dict[Mode, Limit]:
        axes, known = self._axes, dict[float, State]()
        most = furthest(self.operation, axes, angle)

        def worst(mode: Mode, load: float) -> Worst | None:
            point = axes.point(angle, load)
            if mode is Mode.BUCKLING and load not in known:
                return self._states.buckling(self.operation.cycle(*point))
            known[load] = self.state(point, self.operation)
            return known[load].get(mode) if known[load] else _NO_STATE

        found: dict[Mode, Limit] = {}
        start = min(self._first(angle), most)
        while not (worst(Mode.YIELD, start) and known[start]) and start > _LEAST_LOAD:
            start *= _LESS  # no state of contact carries so much
        for mode in known[start]:  # yield comes first
            edge = root(lambda load: self._level(worst(mode, load)), list(known), -1.0, (0.0, most))  # noqa: B023 - called at once
            if edge is None or edge.left > ALMOST:
                continue
            point = axes.point(angle, edge.x)
            if (there := worst(mode, edge.x)) is not None:
                found[mode] = Limit(mode, *point, self.operation.peak(*point), there, edge.slope)
            if mode is Mode.YIELD:
                most = min(most, ELASTIC * edge.x)
        return found

    def _level(self, worst: Worst | None) -> float:
        return math.inf if worst is None else math.log(worst.factor / self._required)

    def safe(self, of_rays: LimitMap, line: Line) -> list[tuple[float, float, Limit | None]]:
        """Return the intervals of a line of operation on which the least factor is above the required one.

        Each by its coordinates (low, high) and the limit that ends it; None at the end of the line.
        """
        x = np.linspace(*line.ends, _POINTS)
        level = np.log(of_rays.least(*np.array([line.point(float(each)) for each in x]).T))
        bounds: list[tuple[float, Limit | None]] = [(line.ends[0], None)] if level[0] > 0 else []
        for number in np.flatnonzero(np.diff(level > 0)):
            low, high = x[number : number + 2].tolist()
            slope = math.log(high / low) / float(level[number + 1] - level[number])
            bounds.append(self._refined(line, low * math.exp(-slope * float(level[number])), slope))
        if level[-1] > 0:
            bounds.append((line.ends[1], None))
        between = zip(bounds[::2], bounds[1::2], strict=True)
        return [(low, high, limit) for (low, _), (high, limit) in between if low < high]

    def _refined(self, line: Line, start: float, slope: float) -> tuple[float, Limit | None]:
        """Find the edge near a coordinate, d ln x/d level there; every place is looked at.

        Returns its coordinate and the limit; without one, the end of the line towards which it would lie.
        """
        for name, x, limit, certain in self._edges:
            if name == line.name and abs(x / start - 1) < _SAME:
                if certain or not self.certain:
                    return x, limit
                start, slope = x, limit.slope

        def level(at: float) -> float:
            return self._least(line, at)[0]

        while True:
            edge = root(level, [start], slope, line.ends, self._within)
            if edge is None:
                return line.ends[(level(start) > 0) is (slope < 0)], None
            if not self.certain:
                x, limit = self._checked(line, edge, level)
                self._edges.insert(0, (line.name, x, limit, False))
                return x, limit
            point = line.point(edge.x)
            if self._states.certify(line.operation.cycle(*point), self.state(point, line.operation)):
                _, mode, worst = self._least(line, edge.x)
                limit = Limit(mode, *point, line.operation.peak(*point), worst, edge.slope)
                self._edges.insert(0, (line.name, edge.x, limit, self.certain))
                return edge.x, limit
            start, slope = edge.x, edge.slope
            self._known.clear()

    def _checked(self, line: Line, edge: Root, level: Callable[[float], float]) -> tuple[float, Limit]:
        """Solve an estimated edge, and move it by what that shows: the history differs with the load."""
        x, slope = edge.x, edge.slope
        for _ in range(_CHECKS):
            solved = x
            left, mode, worst = self._least_of(
                self._found(line.point(x), line.operation, certain=True) or _WITHOUT
            )
            if abs(left) < self._within:
                break
            slope = self._slope_at(level, x, edge.slope)
            x = min(max(leap(x, slope, left), line.ends[0]), line.ends[1])
            if abs(left) < _CLOSE:
                break
        spread = max(abs(math.log(x / solved)), abs(slope) * self._within, _LEAST_SPREAD)
        point = line.point(x)
        return x, Limit(mode, *point, line.operation.peak(*point), worst, slope, spread=spread)

    @staticmethod
    def _slope_at(level: Callable[[float], float], x: float, otherwise: float) -> float:
        """D ln x/d level at a place; that of the edge where the level passes another way."""
        change = level(x * (1 + _STEP)) - level(x)
        slope = math.log1p(_STEP) / change if change and math.isfinite(change) else 0.0
        return slope if slope * otherwise > 0 else otherwise

    def _least(self, line: Line, at: float) -> tuple[float, Mode, Worst]:
        return self._least_of(self.state(line.point(at), line.operation) or _WITHOUT)

    def _least_of(self, state: State) -> tuple[float, Mode, Worst]:
        return min((self._level(worst), mode, worst) for mode, worst in ending(state).items())

    def fastest(self, of_rays: LimitMap, operation: Operation) -> Limit | None:
        """Find the highest speed of another engine, whose gas hardly counts; None if any is safe."""
        most, rpm = operation.fastest, self._axes.rpm
        least = float(of_rays.least(np.array(rpm), np.array(0.0)))
        line = Line("closed throttle", operation, lambda at: (at, 1.0), (operation.idle, most))
        return self._refined(line, min(rpm * math.sqrt(least), most), -0.5)[1]
