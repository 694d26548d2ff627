"""The search for limits on rays from rest and along lines of operation.

Along a ray all loads grow together, so that each factor falls steadily and passes the required one once. A
line of operation, such as one speed or full load at every speed, may cross a mode's limit several times: gas
relieves inertia. A survey of a few rays shows between which points, and roots are found there: the answer in
words needs no more. The map has more rays, with the limit of every mode on each.

Factors of a rod of separate parts are costly. Until the map is there, its limits are estimates. The map has
the rays of the survey, and utilisations between the few solved points of a ray and rest are interpolated.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from fea.apps.limits.engine import ScaledEngine
from fea.apps.limits.factors import BY_FORCE, PLASTIC, Factors, FailureMode, ModeFactor, RodFactors
from fea.apps.limits.limit_map import ELASTIC, LimitMap, LimitPoint, Point, RayAxes, ending
from fea.base.root import ALMOST, STEPS, WITHIN, Root, leap, root
from fea.solid.errors import ContactError
from geometry.arrays import Floats
from loads.crank_cycle import CrankCycle

# How closely a limit is found where factors are costly: the factor there relative to that required.
_OF_COSTLY = 3e-3
# The next load to solve on a ray, at most, over the largest that was solved.
_NEXT = 1.5
# Stands for the factors where no state of contact carries the load.
_NO_STATE = ModeFactor(0.75)
_WITHOUT: Factors = {FailureMode.YIELD: _NO_STATE}
# Rays of the map, and of the survey.
RAYS, SURVEYED = 13, 5
# By which factor a load that cannot be carried is reduced, and the least load.
_LESS, _LEAST_LOAD = 0.7, 0.1
# Points of a line of operation between which the limits of the rays are compared.
_POINTS = 240
# Relative distance of a costly point from a limit of its ray at which no other one is solved, and that at
# which a limit counts as interpolated.
_NEAR, _SOLVED = 0.04, 5e-3
# An estimated limit is solved and moved at most so often, or until the factor there is the required one to
# within this share.
_CHECKS, _CLOSE = 3, 0.02
# By which share of the coordinate the slope is measured there, and the least relative uncertainty of
# estimates: another mode, place or instant may govern.
_STEP, _LEAST_SPREAD = 0.03, 0.015
# The same where friction did not settle: without its history, factors of one rod erred by 5 %.
_NO_HISTORY = 0.1
# The line of operation of a vehicle that drives its engine, which has one limit.
_CLOSED = "closed throttle"
# Relative distance within which a limit that was found earlier is the same one.
_SAME = 0.03


class OperatingLine(NamedTuple):
    """A line of operation."""

    name: str
    engine: ScaledEngine
    point: Callable[[float], Point]  #: of a coordinate of the line, such as the speed
    ends: tuple[float, float]  #: of the coordinate


def _crossing(usage: Mapping[float, float]) -> tuple[float, float] | None:
    """Load at which utilisations pass 1, and d ln load/d ln f there: between samples or beyond the last.

    None if the utilisation does not grow there.
    """
    loads = sorted(usage)
    for low, high in pairwise(loads):
        rise = (usage[high] - usage[low]) / (high - low)
        if rise > 0 and (usage[high] >= 1 or high == loads[-1]):
            load = max(low + (1 - usage[low]) / rise, 0.0)
            return load, -1 / max(rise * load, 1e-12)
    return None


class LimitSearch:
    """Finds limits. `axes`: those of the rays; `required`: the safety factor; `show` reports progress."""

    def __init__(
        self,
        model: RodFactors,
        engine: ScaledEngine,
        axes: RayAxes,
        required: float,
        show: Callable[[str], None],
    ) -> None:
        self._model, self.engine, self._axes = model, engine, axes
        self._required, self._show = required, show
        self._within = _OF_COSTLY if model.costly else WITHIN
        self.certain = not model.costly  #: whether factors are more than estimates
        self._evaluated: dict[tuple[ScaledEngine, Point, bool], Factors] = {}
        self._without_history: set[tuple[ScaledEngine, Point, bool]] = set()  # friction did not settle
        self._rays: dict[float, dict[float, Factors]] = {}  # of the survey, by angle and load
        self._found: list[tuple[str, float, LimitPoint, bool]] = []  # by line: coordinate, limit, certain
        self.rest = {mode: required / worst.factor for mode, worst in model.rest.items()}

    def _factors(self, point: Point, engine: ScaledEngine, *, certain: bool) -> Factors:
        """Factors at a point; none where no state of contact carries the load."""
        key = (engine, point, certain)
        if key not in self._evaluated:
            evaluate, before = self._model.at if certain else self._model.estimate, self._model.unsettled
            self._evaluated[key] = _carried(evaluate, engine, point)
            if self._model.unsettled > before:
                self._without_history.add(key)
        return self._evaluated[key]

    def survey(self) -> LimitMap:
        """Estimate the limits of the modes from one point on each of a few rays."""
        angles = self._axes.angles(self.engine, SURVEYED)
        order = list(range(len(angles)))
        if self._model.costly:  # the limits of the outer rays show about where those of the inner ones are
            order = [0, *order[:0:-1]]
        for done, number in enumerate(order):
            self._show(f"surveying every node of the rod, {done + 1} of {len(order)}")
            angle = float(angles[number])
            load = self._first(angle) if self._model.costly and done > 1 else 1.0
            load = min(load, self._axes.furthest(self.engine, angle))
            factors = self._on_survey(angle, load)
            while factors is _WITHOUT and load > _LEAST_LOAD:
                load *= _LESS
                factors = self._on_survey(angle, load)
            self._rays[angle] = {load: factors}
        return self._surveyed()

    def _on_survey(self, angle: float, load: float) -> Factors:
        return _carried(self._model.survey, self.engine, self._axes.point(angle, load)) or _WITHOUT

    def _surveyed(self) -> LimitMap:
        angles = sorted(self._rays)
        modes = {mode for ray in self._rays.values() for factors in ray.values() for mode in factors}
        loads = {mode: np.array([self._limit_load(angle, mode) for angle in angles]) for mode in modes}
        ordered = {mode: np.maximum(loads[mode], 1e-9) for mode in FailureMode if mode in modes}
        return LimitMap(self._axes, np.array(angles), ordered, self.rest)

    def _limit_load(self, angle: float, mode: FailureMode) -> float:
        crossing = self._crossing_on(angle, mode)
        return math.inf if crossing is None else crossing[0]

    def _crossing_on(self, angle: float, mode: FailureMode) -> tuple[float, float] | None:
        """Where a mode limits a ray of the survey, from its solved points and rest."""
        ray = self._rays[angle].items()
        usage = {load: self._required / factors[mode].factor for load, factors in ray if mode in factors}
        return _crossing({0.0: self.rest.get(mode, 0.0), **usage}) if usage else None

    def _first(self, angle: float) -> float:
        """Load of the first limit of a ray by the survey; 1 if nothing limits it."""
        factors = self._surveyed().ending_factors(*self._axes.point(angle, 1.0))
        still = {mode: self.rest.get(mode, 0.0) for mode in factors}
        loads = [
            (1 - still[mode]) / (1 / factor - still[mode])
            for mode, factor in factors.items()
            if 1 / factor > still[mode]
        ]
        return float(min(loads, default=1.0)) or 1.0

    def map(self) -> LimitMap:
        """Find the limit of each mode on every ray, after a survey."""
        if self._model.costly:
            angles = np.array(sorted(self._rays))
            self._solve_near_limits()
            return self._mapped(angles, [dict(self._interpolated(angle)) for angle in angles.tolist()])
        angles, found = self._axes.angles(self.engine, RAYS), []
        for number, angle in enumerate(angles.tolist(), 1):
            self._show(f"limits on ray {number} of {len(angles)}")
            found.append(self._on_ray(angle))
        return self._mapped(angles, found)

    def _mapped(self, angles: Floats, found: Sequence[Mapping[FailureMode, LimitPoint]]) -> LimitMap:
        modes = [mode for mode in FailureMode if any(mode in on_ray for on_ray in found)]
        limits = {mode: tuple(on_ray.get(mode) for on_ray in found) for mode in modes}
        loads = {mode: np.array([self._load(limit) for limit in line]) for mode, line in limits.items()}
        return LimitMap(self._axes, angles, loads, self.rest, limits)

    def _load(self, limit: LimitPoint | None) -> float:
        return math.inf if limit is None else float(self._axes.ray(limit.rpm, limit.scale)[1])

    def _solve_near_limits(self) -> None:
        """Solve points near the first limit of each ray of the survey and near that of yielding.

        The place that yields first changes along a ray, so that its utilisation bends upwards: extrapolated
        from points where the stress of the press fits is the largest, the limit would lie too far out.
        """
        for number, angle in enumerate(sorted(self._rays), 1):
            solved, most = self._rays[angle], self._axes.furthest(self.engine, angle)
            load = min(self._first(angle), most)
            for step in range(STEPS):
                if min(abs(load / other - 1) for other in solved) > _NEAR:
                    self._show(f"limits on ray {number} of {len(self._rays)}")
                    solved[load] = self._on_survey(angle, load)
                elif step:
                    break
                load = min(self._limit_load(angle, FailureMode.YIELD), _NEXT * max(solved), most)

    def _interpolated(self, angle: float) -> Iterable[tuple[FailureMode, LimitPoint]]:
        """Limits between the solved points of a ray."""
        furthest = self._axes.furthest(self.engine, angle)
        most = min(ELASTIC * self._limit_load(angle, FailureMode.YIELD), furthest)
        for mode in FailureMode:
            crossing = self._crossing_on(angle, mode)
            if crossing is None or not 0 < crossing[0] <= (furthest if mode in PLASTIC else most):
                continue
            load, slope = crossing
            solved = {at: factors[mode] for at, factors in self._rays[angle].items() if mode in factors}
            near = min(solved, key=lambda at: abs(at - load))
            apart, point = abs(near / load - 1) > _SOLVED, self._axes.point(angle, load)
            yield mode, LimitPoint(mode, *point, self.engine.peak(*point), solved[near], slope, apart)

    def _on_ray(self, angle: float) -> dict[FailureMode, LimitPoint]:
        """Find the limits on a ray where factors are cheap."""
        axes, solved = self._axes, dict[float, Factors]()
        most = furthest = axes.furthest(self.engine, angle)

        def worst(mode: FailureMode, load: float) -> ModeFactor | None:
            point = axes.point(angle, load)
            if mode in BY_FORCE and load not in solved:
                return self._model.by_force(self.engine.cycle(*point))[mode]
            solved[load] = self._factors(point, self.engine, certain=self.certain)
            return solved[load].get(mode) if solved[load] else _NO_STATE

        found: dict[FailureMode, LimitPoint] = {}
        start = min(self._first(angle), most)
        while not (worst(FailureMode.YIELD, start) and solved[start]) and start > _LEAST_LOAD:
            start *= _LESS  # no state of contact carries the load
        for mode in solved[start]:  # yield comes first
            ends = 0.0, furthest if mode in PLASTIC else most
            edge = root(lambda load: self._level(worst(mode, load)), list(solved), -1.0, ends)  # noqa: B023 - called at once
            if edge is None or edge.left > ALMOST:
                continue
            if (there := worst(mode, edge.x)) is not None:
                point = axes.point(angle, edge.x)
                found[mode] = LimitPoint(mode, *point, self.engine.peak(*point), there, edge.slope)
            if mode is FailureMode.YIELD:
                most = min(most, ELASTIC * edge.x)
        return found

    def _level(self, worst: ModeFactor | None) -> float:
        return math.inf if worst is None else math.log(worst.factor / self._required)

    def safe(self, of_rays: LimitMap, line: OperatingLine) -> list[tuple[float, float, LimitPoint | None]]:
        """Return the intervals of a line of operation on which the least factor is above the required one.

        Each by its coordinates (low, high) and the limit that ends it; None at the end of the line.
        """
        x = np.linspace(*line.ends, _POINTS)
        level = np.log(of_rays.least(*np.array([line.point(float(each)) for each in x]).T))
        bounds: list[tuple[float, LimitPoint | None]] = [(line.ends[0], None)] if level[0] > 0 else []
        for number in np.flatnonzero(np.diff(level > 0)):
            low, high = x[number : number + 2].tolist()
            slope = math.log(high / low) / float(level[number + 1] - level[number])
            bounds.append(self._refined(line, low * math.exp(-slope * float(level[number])), slope))
        if level[-1] > 0:
            bounds.append((line.ends[1], None))
        between = zip(bounds[::2], bounds[1::2], strict=True)
        return [(low, high, limit) for (low, _), (high, limit) in between if low < high]

    def _refined(self, line: OperatingLine, start: float, slope: float) -> tuple[float, LimitPoint | None]:
        """Find the limit near a coordinate, d ln x/d level there; every row of the rod is evaluated.

        Returns its coordinate and the limit; without one, the end of the line towards which it would lie.
        """
        for name, x, limit, certain in self._found:
            if name == line.name and abs(x / start - 1) < _SAME:
                if certain or not self.certain:
                    return x, limit
                start, slope = x, limit.slope

        def level(at: float) -> float:
            return self._least(line, at, certain=self.certain)[0]

        while True:
            edge = root(level, [start], slope, line.ends, self._within)
            if edge is None:
                return line.ends[(level(start) > 0) is (slope < 0)], None
            if not self.certain:
                x, limit = self._checked(line, edge, level)
                break
            x, point = edge.x, line.point(edge.x)
            factors = self._factors(point, line.engine, certain=True)
            if self._model.certify(line.engine.cycle(*point), factors):
                _, mode, worst = self._least(line, x, certain=True)
                spread = self._unsettled(line, x)
                limit = LimitPoint(mode, *point, line.engine.peak(*point), worst, edge.slope, spread=spread)
                break
            start, slope = edge.x, edge.slope
            self._evaluated.clear()
        self._found.insert(0, (line.name, x, limit, self.certain))
        return x, limit

    def _checked(
        self, line: OperatingLine, edge: Root, level: Callable[[float], float]
    ) -> tuple[float, LimitPoint]:
        """Solve an estimated limit, and move it accordingly: the history differs with the load."""
        x, slope = edge.x, edge.slope
        for _ in range(_CHECKS):
            solved = x
            left, mode, worst = self._least(line, x, certain=True)
            if abs(left) < self._within:
                break
            change = level(x * (1 + _STEP)) - left
            slope = math.log1p(_STEP) / change if change and math.isfinite(change) else 0.0
            slope = slope if slope * edge.slope > 0 else edge.slope
            x = min(max(leap(x, slope, left), line.ends[0]), line.ends[1])
            if abs(left) < _CLOSE:
                break
        point = line.point(x)
        least = max(self._unsettled(line, solved), _LEAST_SPREAD)
        spread = max(abs(math.log(x / solved)), abs(slope) * self._within, least)
        return x, LimitPoint(mode, *point, line.engine.peak(*point), worst, slope, spread=spread)

    def _unsettled(self, line: OperatingLine, x: float) -> float:
        """Relative uncertainty of a coordinate where friction did not settle; 0 where it did."""
        return _NO_HISTORY if (line.engine, line.point(x), True) in self._without_history else 0.0

    def _least(
        self, line: OperatingLine, at: float, *, certain: bool
    ) -> tuple[float, FailureMode, ModeFactor]:
        factors = self._factors(line.point(at), line.engine, certain=certain) or _WITHOUT
        return min((self._level(worst), mode, worst) for mode, worst in ending(factors).items())

    def fastest(self, of_rays: LimitMap, engine: ScaledEngine) -> LimitPoint | None:
        """Find the highest speed of another engine, whose gas hardly counts; None if any is safe."""
        most, rpm = engine.fastest, self._axes.rpm
        start = min(rpm * math.sqrt(float(of_rays.least(rpm, 0.0))), most)
        start = next((x for name, x, *_ in self._found if name == _CLOSED), start)
        line = OperatingLine(_CLOSED, engine, lambda at: (at, 1.0), (engine.idle, most))
        return self._refined(line, start, -0.5)[1]


def _carried(evaluate: Callable[[CrankCycle], Factors], engine: ScaledEngine, point: Point) -> Factors:
    """Factors at a point; none where no state of contact carries the load."""
    try:
        return evaluate(engine.cycle(*point))
    except ContactError:
        return {}
