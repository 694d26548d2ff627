"""Safety factors against every mode of failure at an operating point, from superposed unit solutions.

Every row of the rod is evaluated only on a few rays from rest through speed squared and gas load. In these
coordinates loads grow in proportion, and a norm of stress is convex: between two of these rays the stress is
bounded by the mean of both. Rows that may be the worst somewhere are candidates, which are evaluated
elsewhere; every row is evaluated again where a limit is stated in words.

A cycle is evaluated in two stages: at every few degrees, then at every degree around the decisive instants.
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
from fea.judge.fatigue import criterion_strength, reversed_amplitude
from fea.judge.history import signed_equivalent
from fea.judge.life_line import LifeLine, rainflow
from fea.machine.threads import side_by_side
from fea.pins.model import Weights
from geometry.arrays import Floats, Ints
from loads.crank_cycle import CrankCycle
from loads.slider_crank import cycle_angles


class FailureMode(StrEnum):
    """A mode of failure."""

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


# Modes that do not end the rod, whose onset is reported: parts lift off their seats at an edge first,
# surfaces in contact wear, and a bushing or a shell that yields settles in its bore.
ONSETS = frozenset({FailureMode.BUSHING, FailureMode.SHELLS, FailureMode.FILM, FailureMode.LINING})
# Modes that stress decides, in the order of utilisations (3, n).
STRESSED = (FailureMode.YIELD, FailureMode.FATIGUE, FailureMode.LINING)


@dataclass(frozen=True)
class ModeFactor:
    """The least safety factor against one mode."""

    factor: float
    at: tuple[float, float, float] | None = None  #: mm; None where the mode has no place
    crank_angle: float | None = None  #: rad


Factors = Mapping[FailureMode, ModeFactor]


@dataclass(frozen=True, eq=False)
class RowHistories:
    """Stress of some rows of a part at instants."""

    part: PartRows
    rows: Ints
    stress: Floats  #: (n, 6, n_instants)

    @classmethod
    def of(cls, part: PartRows, rows: Ints, weights: Weights) -> "RowHistories":
        """Superpose it."""
        return cls(part, rows, part.stress(weights, rows))

    @cached_property
    def signed(self) -> Floats:
        """Signed equivalent stress (n, n_instants)."""
        return signed_equivalent(self.stress)

    @cached_property
    def usage(self) -> Floats:
        """Utilisations (3, n), by the modes `STRESSED`."""
        extremes, part = (self.signed.max(axis=1), self.signed.min(axis=1)), self.part
        factors = [judge(*extremes, self.rows) for judge in (part.yielding_factor, part.fatigue_factor)]
        factors.append(part.lining_factor(*extremes))
        return np.asarray(1 / np.maximum(np.nan_to_num(np.stack(factors), nan=np.inf, posinf=np.inf), _TINY))

    @property
    def most_used(self) -> "RowHistories":
        """The rows of the largest utilisations against each mode."""
        rows = most_used(self.usage)
        return RowHistories(self.part, self.rows[rows], self.stress[rows])

    def extended(self, part: PartRows, weights: Weights) -> "RowHistories":
        """Append instants of the same rows of the part."""
        return replace(self, stress=np.concatenate([self.stress, part.stress(weights, self.rows)], axis=2))


Histories = tuple[list[RowHistories], Floats]  # of the parts, and the crank angles of their instants, rad

# Degrees from one instant of the first stage to the next, for all rows and for candidates; and half the width
# of the second stage, whose instants are a degree apart.
ALL_ROWS_STEP, _CANDIDATE_STEP, _WINDOW = 10, 12, 6
# Rows of a part that are evaluated in the second stage against each mode.
_CLOSEST = 80
# A row is a candidate if its utilisation is at least this share of the largest, on one of so many rays
# between two that were surveyed; and at most so many of a part for each.
_NEAR, _BETWEEN, _MOST = 0.85, 4, 60
_BLOCK = 500  # nodes evaluated at once
_TINY = 1e-12


class RodFactors(ABC):
    """The safety factors of a rod over any crank cycle."""

    costly: ClassVar[bool] = False  #: whether one evaluation takes as long as several static runs
    unsettled: int = 0  #: number of evaluations that are estimates, because friction did not settle

    def __init__(self, rod: PreparedRod) -> None:
        self._column = min(formulas.least for formulas in columns(rod).values())
        self._criterion, self._materials = rod.options.fatigue, rod.materials

    @property
    def rest(self) -> Factors:
        """Factors under the preload of bolts and press fits alone."""
        return {}

    @abstractmethod
    def at(self, cycle: CrankCycle) -> Factors:
        """Return the factors over a cycle, with their places."""

    def survey(self, cycle: CrankCycle) -> Factors:
        """Return the factors over a cycle for a first map."""
        return self.estimate(cycle)

    def estimate(self, cycle: CrankCycle) -> Factors:
        """Return the factors over a cycle for a search."""
        return self.at(cycle)

    def certify(self, cycle: CrankCycle, factors: Factors) -> bool:  # noqa: ARG002
        """Check that no row is worse than `factors`; any that is becomes a candidate."""
        return True

    @abstractmethod
    def histories(self, cycle: CrankCycle, *, estimated: bool = False) -> Histories:
        """Return the stress of the most stressed rows at the decisive instants."""

    @cached_property
    def endurance(self) -> bool | None:
        """Whether stress below the endurance limit does no damage; None where no S–N line is known."""
        lines = [self._life_line(material, np.ones(1)) for material in self._materials]
        known = [line.endless for line in lines if line is not None]
        return all(known) if known else None

    def life(self, cycle: CrankCycle, *, estimated: bool = False) -> float:
        """Return the crank cycles to failure as `fea.analysis.life`, as if every range did damage."""
        (histories, angles), damage = self.histories(cycle, estimated=estimated), _TINY
        for each in histories:
            material, signed = each.part.material, each.signed[:, np.argsort(angles)]
            line = self._life_line(material, each.part.surface(each.rows))
            if line is None:
                continue
            high, low = signed.max(axis=1), signed.min(axis=1)
            largest = reversed_amplitude(self._criterion, (high + low) / 2, (high - low) / 2, material)
            for row in np.argsort(-largest / line.limit)[:COUNTED]:
                amplitude = reversed_amplitude(self._criterion, *rainflow(signed[row]), material)
                at_row = replace(line, limit=line.limit[[row]])
                damage = max(damage, float((1 / at_row.cycles(amplitude[:, None])).sum()))
        return 1 / damage

    def _life_line(self, material: Material, surface: Floats) -> LifeLine | None:
        """S–N line with surface factors; None where it or the effect of mean stress is not known."""
        known = criterion_strength(self._criterion, material) is not None
        return LifeLine.of(material, surface) if known else None

    def buckling(self, cycle: CrankCycle) -> ModeFactor:
        """Return the factor against buckling, which depends on the forces alone."""
        pushed = compression(cycle.degrees)
        worst = int(pushed.argmax())
        force = max(float(pushed[worst]), _TINY)
        return ModeFactor(self._column / force, None, float(cycle.degrees.crank_angle[worst]))


class SuperposedFactors(RodFactors):
    """The safety factors of a rod of one piece."""

    def __init__(self, rod: PreparedRod, analysis: CycleAnalysis) -> None:
        super().__init__(rod)
        self._analysis = analysis
        self._parts = [PartRows(analysis, number) for number in range(len(analysis.materials))]
        self._candidates: list[Ints] = [np.zeros(0, dtype=np.int64) for _ in self._parts]
        # Decisive crank angles of the last evaluation, rad: they often decide the next one.
        self._decisive = np.zeros(0)
        self._surveyed: list[list[Floats]] = []  # utilisations of every row on each ray

    def _utilisation(self, cycle: CrankCycle) -> list[Floats]:
        """Utilisations (3, n_rows) of every row of each part."""
        weights = self._analysis.weights(cycle, sampled_angles(cycle, ALL_ROWS_STEP))
        return [utilisation(part, weights) for part in self._parts]

    def survey(self, cycle: CrankCycle) -> Factors:
        """Evaluate every row, and remember it to choose candidates."""
        self._surveyed.append(self._utilisation(cycle))
        most = np.max([of_part.max(axis=1) for of_part in self._surveyed[-1]], axis=0)
        found = {mode: ModeFactor(1 / used) for mode, used in zip(STRESSED, most, strict=True) if used > 0}
        return found | {FailureMode.BUCKLING: self.buckling(cycle)}

    def choose_candidates(self) -> None:
        """Choose the rows that may be the worst between the rays that were surveyed in their order."""
        rays = self._surveyed
        for before, after in pairwise(rays if len(rays) > 1 else [*rays, *rays]):
            for share in np.linspace(0, 1, _BETWEEN + 1):
                between = [(1 - share) * a + share * b for a, b in zip(before, after, strict=True)]
                self._add_candidates(between, _NEAR)

    def _add_candidates(self, usage: Sequence[Floats], near: float) -> bool:
        """Add rows with nearly the largest utilisation; return whether any of them is new."""
        largest, new = np.max([of_part.max(axis=1) for of_part in usage], axis=0), False
        for number, of_part in enumerate(usage):
            rows = [self._candidates[number]]
            for mode, most in zip(of_part, largest, strict=True):
                order = np.argsort(-mode)[:_MOST]
                rows.append(order[(mode[order] >= near * most) & (mode[order] > 0)])
            every = np.unique(np.concatenate(rows))
            new |= len(every) > len(self._candidates[number])
            self._candidates[number] = every
        return new

    def certify(self, cycle: CrankCycle, factors: Factors) -> bool:
        """Check that no row is worse than `factors`; any that is becomes a candidate."""
        usage = self._utilisation(cycle)
        largest = np.max([of_part.max(axis=1) for of_part in usage], axis=0)
        pairs = [
            (used, factors[mode]) for used, mode in zip(largest, STRESSED, strict=True) if mode in factors
        ]
        confirmed = all(used <= 1.001 / worst.factor for used, worst in pairs)
        return confirmed or not self._add_candidates(usage, 0.97)

    def at(self, cycle: CrankCycle) -> Factors:
        """Return the factors over a cycle, with their places."""
        return worst_of(*self.histories(cycle)) | {FailureMode.BUCKLING: self.buckling(cycle)}

    def histories(self, cycle: CrankCycle, *, estimated: bool = False) -> Histories:  # noqa: ARG002
        """Return the stress of the candidates that are worst: see `RodFactors.histories`."""
        if not any(map(len, self._candidates)):
            self.choose_candidates()
        angles = np.union1d(sampled_angles(cycle, _CANDIDATE_STEP), self._decisive)
        weights = self._analysis.weights(cycle, angles)
        pairs = [(part, rows) for part, rows in zip(self._parts, self._candidates, strict=True) if rows.size]
        first = [RowHistories.of(part, rows, weights) for part, rows in pairs]
        self._decisive = decisive_angles(angles, first)
        worst = [each.most_used for each in first]
        more = np.setdiff1d(self._decisive, angles)
        if more.size:
            weights = self._analysis.weights(cycle, more)
            worst = [each.extended(each.part, weights) for each in worst]
        return worst, np.append(angles, more)


def sampled_angles(cycle: CrankCycle, step: int) -> Floats:
    """Crank angles at every so many degrees, and that of the largest gas pressure, rad."""
    angles = np.concatenate([cycle_angles(), cycle.gas.samples])
    gas_peak = angles[cycle.gas.pressure(angles, np.asarray(cycle.speed)).argmax()]
    return np.append(np.arange(0, 720, step) * DEG, gas_peak)


def utilisation(part: PartRows, weights: Weights) -> Floats:
    """Utilisations (3, n_rows) of every row of a part over instants, by the modes `STRESSED`."""
    rows = np.arange(len(part.points)).reshape(len(part.sides), -1)

    def block(start: int) -> Floats:
        nodes = slice(start, start + _BLOCK)
        stress = part.every(weights, nodes)
        usage = RowHistories(part, rows[:, nodes].ravel(), stress).usage
        return usage.reshape(len(STRESSED), len(rows), -1)

    blocks = list(side_by_side(block, range(0, rows.shape[1], _BLOCK)))
    return np.concatenate(blocks, axis=2).reshape(len(STRESSED), -1)


def most_used(usage: Floats) -> Ints:
    """Return the rows of the largest of the utilisations (3, n)."""
    used = usage[usage.any(axis=1)] if usage.any() else usage[:1]
    return np.unique(np.argsort(-used, axis=1)[:, :_CLOSEST])


def worst_of(histories: Sequence[RowHistories], angles: Floats) -> dict[FailureMode, ModeFactor]:
    """Return the least factors among rows with their histories at crank angles."""
    found = dict[FailureMode, ModeFactor]()
    for each in histories:
        for mode, used in zip(STRESSED, each.usage, strict=True):
            row = int(used.argmax())
            factor = 1 / max(float(used[row]), _TINY)
            if used[row] > 0 and (mode not in found or factor < found[mode].factor):
                x, y, z = each.part.points[each.rows[row]].tolist()
                angle = float(angles[np.abs(each.signed[row]).argmax()])
                found[mode] = ModeFactor(factor, (x, y, z), angle)
    return found


def decisive_angles(angles: Floats, histories: Sequence[RowHistories], window: int = _WINDOW) -> Floats:
    """Crank angles within so many degrees of the extremes of the three worst rows against each mode."""
    found = set[int]()
    for mode in range(len(STRESSED)):
        most = [each.usage[mode].max(initial=0.0) for each in histories]
        worst = histories[int(np.argmax(most))]
        if not max(most) and mode:  # no part fails in this way
            continue
        for row in np.argsort(-worst.usage[mode])[:3]:
            found |= {int(worst.signed[row].argmax()), int(worst.signed[row].argmin())}
    return around(angles[sorted(found)], window)


def around(angles: Floats, window: int = _WINDOW) -> Floats:
    """Crank angles, a degree apart, within so many degrees of each of some."""
    degrees = np.round(angles / DEG)[:, None] + np.arange(-window, window + 1)
    return np.asarray(np.unique(np.mod(degrees, 720)) * DEG)
