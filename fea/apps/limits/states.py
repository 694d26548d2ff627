"""Safety factors against every mode of failure at an operating point.

Those of a rod of one piece follow from unit solutions. Every place of the rod is evaluated at a few points
only, on rays from rest through speed squared and charge. In these coordinates loads grow in proportion, and a
norm of stress is convex: between two of these rays a place is at most as stressed as the mean of both says.
The places that may be the worst somewhere are evaluated elsewhere, and every place again where a limit is
stated in words.

A cycle is evaluated in two stages: at every few degrees, then at every degree around the instants that
decide.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from itertools import pairwise
from typing import ClassVar

import numpy as np

from fea.analysis.buckling import columns, compression
from fea.analysis.cycle.rows import PartRows
from fea.analysis.cycle.superposition import CycleAnalysis
from fea.analysis.life import COUNTED
from fea.analysis.prepare import PreparedRod
from fea.base.material import Material
from fea.base.units import DEG
from fea.judge.fatigue import LifeLine, criterion_strength, rainflow, reversed_amplitude
from fea.judge.history import signed_equivalent
from fea.machine.threads import side_by_side
from fea.pins.model import Weights
from geometry.arrays import Floats, Ints
from loads.crank_cycle import CrankCycle
from loads.slider_crank import cycle_angles


class Mode(StrEnum):
    """A way to fail."""

    YIELD = "yield"
    FATIGUE = "fatigue"
    BUCKLING = "buckling"
    BOLT_YIELD = "bolt yield"
    BOLT_FATIGUE = "bolt fatigue"
    OPENING = "joint opening"
    SLIP = "joint slip"
    BUSHING = "bushing lifting"
    SHELLS = "shell lifting"
    FILM = "oil film"
    LINING = "lining yield"


# Parts lift off their seats at an edge first, surfaces that touch wear, and a bushing or a shell that yields
# settles in its bore: the answer tells from when on.
ONSETS = frozenset({Mode.BUSHING, Mode.SHELLS, Mode.FILM, Mode.LINING})


@dataclass(frozen=True)
class Worst:
    """The least safety factor against one mode."""

    factor: float
    at: tuple[float, float, float] | None = None  #: mm; None where the mode has no place
    crank_angle: float | None = None  #: rad


State = Mapping[Mode, Worst]
#: Rows of parts with their stress (n, 6, n_instants), and the crank angles of these, rad
Histories = tuple[list[tuple[PartRows, Ints, Floats]], list[float]]

# Degrees from one instant of the first stage to the next, on all places and on those that may be the worst;
# and half the width of the second, whose instants are a degree apart.
EVERY_PLACE, _COARSE, _WINDOW = 10, 12, 6
# Places of a part that are looked at in the second stage against each mode: at most so many.
_CLOSEST = 80
# A place is followed if its utilisation comes as near to the largest, on any of so many rays between two that
# were evaluated; and at most so many of a part for each.
_NEAR, _BETWEEN, _MOST = 0.85, 4, 60
_BLOCK = 500  # nodes evaluated at once
_TINY = 1e-12
STRESSED = (Mode.YIELD, Mode.FATIGUE, Mode.LINING)


class States(ABC):
    """The factors of a rod at any crank cycle."""

    costly: ClassVar[bool] = False  #: whether a state takes as long as several static runs
    unsettled: int = 0  #: number of states whose friction did not settle, and which are estimates

    def __init__(self, rod: PreparedRod) -> None:
        self._column = min(formulas.least for formulas in columns(rod).values())
        self._criterion, self._materials = rod.options.fatigue, rod.materials

    @property
    def rest(self) -> State:
        """Return the factors of the rod that nothing loads but its own bolts and fits."""
        return {}

    @abstractmethod
    def at(self, cycle: CrankCycle) -> State:
        """Return the factor of each mode over a cycle, with its place."""

    def survey(self, cycle: CrankCycle) -> State:
        """Return the factors over a cycle, for a first map."""
        return self.estimate(cycle)

    def estimate(self, cycle: CrankCycle) -> State:
        """Return the factors over a cycle, for a search."""
        return self.at(cycle)

    def certify(self, cycle: CrankCycle, state: State) -> bool:  # noqa: ARG002
        """Look at every place; whether none is worse than those that a state is of, else follow it."""
        return True

    @abstractmethod
    def histories(self, cycle: CrankCycle, *, estimated: bool = False) -> Histories:
        """Return rows of parts with their stress at the instants that decide, and these, rad."""

    @cached_property
    def endless(self) -> bool | None:
        """Whether stress below the endurance limit does no damage; None where no S–N line is known."""
        known = (self._life_line(material, np.ones(1)) for material in self._materials)
        lines = [line for line in known if line is not None]
        return all(line.endless for line in lines) if lines else None

    def lasting(self, cycle: CrankCycle, *, estimated: bool = False) -> float:
        """Crank cycles to failure of the places that decide, as if every range of stress did damage.

        Every range of the places of the largest ranges is counted, as `fea.analysis.life` does.
        """
        (places, angles), most = self.histories(cycle, estimated=estimated), 0.0
        for part, rows, history in places:
            line = self._life_line(part.material, part.surface(rows))
            if line is None:
                continue
            signed = signed_equivalent(history)[:, np.argsort(angles)]
            high, low = signed.max(axis=1), signed.min(axis=1)
            largest = reversed_amplitude(self._criterion, (high + low) / 2, (high - low) / 2, part.material)
            for row in np.argsort(-largest / line.limit)[:COUNTED]:
                amplitude = reversed_amplitude(self._criterion, *rainflow(signed[row]), part.material)
                at_row = replace(line, limit=line.limit[[row]])
                most = max(most, float((1 / at_row.cycles(amplitude[:, None])).sum()))
        return 1 / max(most, _TINY)

    def _life_line(self, material: Material, surface: Floats) -> LifeLine | None:
        """The S–N line with factors of surfaces; None where it, or what mean stress does, is not known."""
        known = criterion_strength(self._criterion, material) is not None
        return LifeLine.of(material, surface) if known else None

    def buckling(self, cycle: CrankCycle) -> Worst:
        """Return the factor against buckling, which depends on the forces alone."""
        pushed = compression(cycle.degrees)
        worst = int(pushed.argmax())
        force = max(float(pushed[worst]), _TINY)
        return Worst(self._column / force, None, float(cycle.degrees.crank_angle[worst]))


class SuperposedStates(States):
    """The factors of a rod of one piece."""

    def __init__(self, rod: PreparedRod, analysis: CycleAnalysis) -> None:
        super().__init__(rod)
        self._analysis = analysis
        self._parts = [PartRows(analysis, number) for number in range(len(analysis.materials))]
        self._followed: list[Ints] = [np.zeros(0, dtype=np.int64) for _ in self._parts]
        # Crank angles around those that decided the last state, rad: they often decide the next one.
        self._decided = np.zeros(0)
        self._surveyed: list[list[Floats]] = []

    def usage(self, cycle: CrankCycle) -> list[Floats]:
        """Utilisations (3, n_rows) of every place of each part, by the modes `STRESSED`."""
        angles = np.append(np.arange(0, 720, EVERY_PLACE) * DEG, gas_peak(cycle))
        weights = self._analysis.weights(cycle, angles)
        return [usage_of(part, weights) for part in self._parts]

    def survey(self, cycle: CrankCycle) -> State:
        """Look at every place, and keep what `follow` needs."""
        self._surveyed.append(self.usage(cycle))
        most = np.max([of_part.max(axis=1) for of_part in self._surveyed[-1]], axis=0)
        found = {mode: Worst(1 / most) for mode, most in zip(STRESSED, most, strict=True) if most > 0}
        return found | {Mode.BUCKLING: self.buckling(cycle)}

    def follow(self) -> None:
        """Follow the places that may be the worst between the rays that were surveyed in their order."""
        rays = self._surveyed
        for before, after in pairwise(rays if len(rays) > 1 else [*rays, *rays]):
            for share in np.linspace(0, 1, _BETWEEN + 1):
                between = [(1 - share) * a + share * b for a, b in zip(before, after, strict=True)]
                self._follow(between, _NEAR)

    def _follow(self, usage: Sequence[Floats], near: float) -> bool:
        """Follow places by their utilisations; whether any of them is new."""
        largest, new = np.max([of_part.max(axis=1) for of_part in usage], axis=0), False
        for number, of_part in enumerate(usage):
            rows = [self._followed[number]]
            for mode, most in zip(of_part, largest, strict=True):
                order = np.argsort(-mode)[:_MOST]
                rows.append(order[(mode[order] >= near * most) & (mode[order] > 0)])
            every = np.unique(np.concatenate(rows))
            new |= len(every) > len(self._followed[number])
            self._followed[number] = every
        return new

    def certify(self, cycle: CrankCycle, state: State) -> bool:
        """Look at every place; whether none is worse than those that a state is of, else follow it."""
        usage, right = self.usage(cycle), True
        for number, mode in enumerate(STRESSED):
            if mode in state:
                right &= max(float(of_part[number].max()) for of_part in usage) <= 1.001 / state[mode].factor
        return right or not self._follow(usage, 0.97)

    def at(self, cycle: CrankCycle) -> State:
        """Return the factor of each mode over a cycle, with its place."""
        return worst(*self.histories(cycle)) | {Mode.BUCKLING: self.buckling(cycle)}

    def histories(self, cycle: CrankCycle, *, estimated: bool = False) -> Histories:  # noqa: ARG002
        """Return the places that may be the worst, with their stress: see `States.histories`."""
        if not any(map(len, self._followed)):
            self.follow()
        coarse = np.append(np.arange(0, 720, _COARSE) * DEG, gas_peak(cycle))
        angles = np.union1d(coarse, self._decided)
        weights = self._analysis.weights(cycle, angles)
        pairs = [(part, rows) for part, rows in zip(self._parts, self._followed, strict=True) if rows.size]
        histories = [part.stress(weights, rows) for part, rows in pairs]
        usage = [judged(part, course, rows) for (part, rows), course in zip(pairs, histories, strict=True)]
        some = [(part, rows[closest(course)]) for (part, rows), course in zip(pairs, usage, strict=True)]
        self._decided = decisive(angles, histories, usage)
        more = np.setdiff1d(self._decided, angles)
        if more.size:
            weights = Weights(*map(np.hstack, zip(weights, self._analysis.weights(cycle, more), strict=True)))
        return [(part, rows, part.stress(weights, rows)) for part, rows in some], [*angles, *more]


def gas_peak(cycle: CrankCycle) -> float:
    """Crank angle of the largest gas pressure, rad."""
    angles = np.concatenate([cycle_angles(), cycle.gas.samples])
    return float(angles[cycle.gas.pressure(angles, np.asarray(cycle.speed)).argmax()])


def usage_of(part: PartRows, weights: Weights) -> Floats:
    """Utilisations (3, n_rows) of every place of a part at instants, by the modes `STRESSED`."""
    rows = np.arange(len(part.points)).reshape(len(part.sides), -1)

    def block(start: int) -> Floats:
        nodes = slice(start, start + _BLOCK)
        stress = part.every(weights, nodes)
        return judged(part, stress, rows[:, nodes].ravel()).reshape(len(STRESSED), len(rows), -1)

    blocks = list(side_by_side(block, range(0, rows.shape[1], _BLOCK)))
    return np.concatenate(blocks, axis=2).reshape(len(STRESSED), -1)


def closest(usage: Floats) -> Ints:
    """Return the rows of the largest of the utilisations (3, n)."""
    used = usage[usage.any(axis=1)] if usage.any() else usage[:1]
    return np.unique(np.argsort(-used, axis=1)[:, :_CLOSEST])


def worst(places: Sequence[tuple[PartRows, Ints, Floats]], angles: Sequence[float]) -> dict[Mode, Worst]:
    """Return the least factors among rows of parts with their histories (n, 6, n_instants)."""
    found = dict[Mode, Worst]()
    for part, rows, history in places:
        for mode, used in zip(STRESSED, judged(part, history, rows), strict=True):
            row = int(used.argmax())
            factor = 1 / max(float(used[row]), _TINY)
            if used[row] > 0 and (mode not in found or factor < found[mode].factor):
                signed = signed_equivalent(history[row : row + 1])[0]
                x, y, z = part.points[rows[row]].tolist()
                found[mode] = Worst(factor, (x, y, z), float(angles[np.abs(signed).argmax()]))
    return found


def judged(part: PartRows, history: Floats, rows: Ints) -> Floats:
    """Utilisations (3, n), by the modes `STRESSED`, of histories (n, 6, n_instants) of some rows."""
    signed = signed_equivalent(history)
    highest, lowest = signed.max(axis=1), signed.min(axis=1)
    factors = [part.yielding_factor(highest, lowest, rows), part.fatigue_factor(highest, lowest, rows)]
    factors.append(part.lining_factor(highest, lowest))
    return np.asarray([1 / np.maximum(np.where(np.isnan(each), np.inf, each), _TINY) for each in factors])


def decisive(
    angles: Floats, histories: Sequence[Floats], usage: Sequence[Floats], window: int = _WINDOW
) -> Floats:
    """Crank angles within so many degrees of the instants at which the worst places have their extremes."""
    found = set[int]()
    for mode in range(len(STRESSED)):
        most = [of_part[mode].max(initial=0.0) for of_part in usage]
        number = int(np.argmax(most))
        if not most[number] and mode:  # no part fails in this way
            continue
        for row in np.argsort(-usage[number][mode])[:3]:
            signed = signed_equivalent(histories[number][row : row + 1])[0]
            found |= {int(signed.argmax()), int(signed.argmin())}
    return around(angles[sorted(found)], window)


def around(angles: Floats, window: int = _WINDOW) -> Floats:
    """Crank angles, a degree apart, within so many degrees of each of some."""
    degrees = np.round(angles / DEG)[:, None] + np.arange(-window, window + 1)
    return np.asarray(np.unique(np.mod(degrees, 720)) * DEG)
