"""The places that may be the worst over many crank cycles, and their stress at the decisive instants.

Every place is evaluated over a few cycles only, which differ in speed or gas load. Loads grow in proportion
to speed squared and to the gas pressure, and a norm of stress is convex: between two of these cycles the
stress is bounded by the mean of both. The places that may be the worst somewhere between are candidates,
which are evaluated over every other cycle; all places are evaluated again where an answer depends on it.

A cycle is evaluated in two stages: at every few degrees, then at every degree around the decisive instants.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from fea.analysis.cycle.rows import PartRows
from fea.analysis.cycle.superposition import CycleAnalysis
from fea.base.units import DEG
from fea.judge.history import signed_equivalent
from fea.machine.threads import side_by_side
from fea.pins.model import Weights
from geometry.arrays import Floats, Ints
from loads.crank_cycle import CrankCycle

# Utilisations are those against yielding, against fatigue, and of the linings of the bores against yielding.
YIELDING, FATIGUE, LINING = CRITERIA = range(3)
# Degrees from one instant of the first stage to the next, for all places and for candidates; and half the
# width of the second stage, whose instants are a degree apart.
ALL_ROWS_STEP, _CANDIDATE_STEP, WINDOW = 10, 12, 6
# Rows of a part that are evaluated in the second stage against each mode.
_CLOSEST = 80
# A row is a candidate if its utilisation is at least this share of the largest, on one of so many cycles
# between two that were surveyed; and at most so many of a part for each.
_NEAR, _BETWEEN, _MOST = 0.85, 4, 60
# Where every place is evaluated again, those with at least this share of the largest utilisation join; and
# how much larger than known that may be.
_JOINING, _LARGER = 0.97, 1.001
_BLOCK = 500  # nodes evaluated at once
_TINY = 1e-12


class RowHistories(NamedTuple):
    """Stress histories of some rows of a part."""

    part: PartRows
    rows: Ints  #: (n,)
    stress: Floats  #: (n, 6, n_instants), MPa, components as in `fea.judge.history`

    @classmethod
    def of(cls, part: PartRows, rows: Ints, weights: Weights) -> "RowHistories":
        """Superpose the stress of some rows."""
        return cls(part, rows, part.stress(weights, rows))

    def some(self, which: Ints) -> "RowHistories":
        """Return those of some of the rows, by their place among these."""
        return RowHistories(self.part, self.rows[which], self.stress[which])

    def extended(self, part: PartRows, weights: Weights) -> "RowHistories":
        """Append further instants, which `part` superposes: this part, or the same one of other solutions."""
        more = part.stress(weights, self.rows)
        return self._replace(stress=np.concatenate([self.stress, more], axis=2))

    @property
    def utilisation(self) -> Floats:
        """Utilisations (3, n) of the rows; 0 where a strength is not known."""
        signed = signed_equivalent(self.stress)
        highest, lowest = signed.max(axis=1), signed.min(axis=1)
        factors = [
            self.part.yielding_factor(highest, lowest),
            self.part.fatigue_factor(highest, lowest, self.rows),
            self.part.lining_factor(highest, lowest),
        ]
        known = [np.where(np.isnan(each), np.inf, each) for each in factors]
        return np.asarray([1 / np.maximum(each, _TINY) for each in known])


class CandidateHistories(NamedTuple):
    """The most stressed candidates of each part over a cycle."""

    parts: tuple[RowHistories, ...]
    angles: Floats  #: (n_instants,) crank angles, rad
    decisive: Floats  #: those of the second stage, rad


class Candidates:
    """The places that may be the worst, as rows of each part.

    Attributes: `parts`: all rows of each part.
    """

    def __init__(self, analysis: CycleAnalysis) -> None:
        self._analysis = analysis
        self.parts = [PartRows(analysis, number) for number in range(len(analysis.materials))]
        self._rows: list[Ints] = [np.zeros(0, dtype=np.int64) for _ in self.parts]
        self._surveyed: list[list[Floats]] = []  # utilisations of every row over each cycle

    def _utilisation(self, cycle: CrankCycle) -> list[Floats]:
        """Utilisations (3, n_rows) of every row of each part."""
        weights = self._analysis.weights(cycle, sampled_angles(cycle, ALL_ROWS_STEP))
        return [utilisation(part, weights) for part in self.parts]

    def survey(self, cycle: CrankCycle) -> Floats:
        """Evaluate every row, and remember it to choose candidates; return the largest utilisations (3,)."""
        self._surveyed.append(self._utilisation(cycle))
        return _largest(self._surveyed[-1])

    def choose(self) -> None:
        """Choose the rows that may be the worst between the cycles that were surveyed, in their order."""
        cycles = self._surveyed
        for before, after in pairwise(cycles if len(cycles) > 1 else [*cycles, *cycles]):
            for share in np.linspace(0, 1, _BETWEEN + 1):
                self._add([(1 - share) * a + share * b for a, b in zip(before, after, strict=True)], _NEAR)

    def _add(self, usage: Sequence[Floats], near: float) -> bool:
        """Add rows with nearly the largest utilisation; return whether any of them is new."""
        largest, new = _largest(usage), False
        for number, of_part in enumerate(usage):
            rows = [self._rows[number]]
            for mode, most in zip(of_part, largest, strict=True):
                order = np.argsort(-mode)[:_MOST]
                rows.append(order[(mode[order] >= near * most) & (mode[order] > 0)])
            every = np.unique(np.concatenate(rows))
            new |= len(every) > len(self._rows[number])
            self._rows[number] = every
        return new

    def confirm(self, cycle: CrankCycle, largest: Floats) -> bool:
        """Whether no row exceeds utilisations (3,), NaN where unknown; any that does becomes a candidate."""
        usage = self._utilisation(cycle)
        confirmed = bool((np.isnan(largest) | (_largest(usage) <= _LARGER * largest)).all())
        return confirmed or not self._add(usage, _JOINING)

    def histories(self, cycle: CrankCycle, known: Floats | None = None) -> CandidateHistories:
        """Return the stress of the most stressed candidates, at `known` crank angles (n,), rad, too."""
        if not any(map(len, self._rows)):
            self.choose()
        angles = np.union1d(sampled_angles(cycle, _CANDIDATE_STEP), np.zeros(0) if known is None else known)
        weights = self._analysis.weights(cycle, angles)
        pairs = [(part, rows) for part, rows in zip(self.parts, self._rows, strict=True) if rows.size]
        first = [RowHistories.of(part, rows, weights) for part, rows in pairs]
        usage = [each.utilisation for each in first]
        decisive = decisive_angles(cycle, angles, first, usage)
        worst = [each.some(most_used(used)) for each, used in zip(first, usage, strict=True)]
        more = np.setdiff1d(decisive, angles)
        if more.size:
            weights = self._analysis.weights(cycle, more)
            worst = [each.extended(each.part, weights) for each in worst]
        return CandidateHistories(tuple(worst), np.append(angles, more), decisive)


def _largest(usage: Sequence[Floats]) -> Floats:
    """Largest utilisations (3,) of all parts."""
    return np.asarray(np.max([of_part.max(axis=1) for of_part in usage], axis=0))


def sampled_angles(cycle: CrankCycle, step: int) -> Floats:
    """Crank angles at every so many degrees, and that of the largest gas pressure, rad."""
    angles = np.concatenate([cycle.engine.cycle_angles, cycle.gas.samples])
    gas_peak = angles[cycle.gas.pressure(angles, np.asarray(cycle.speed)).argmax()]
    return np.append(np.arange(0, cycle.engine.cycle_degrees, step) * DEG, gas_peak)


def utilisation(part: PartRows, weights: Weights) -> Floats:
    """Utilisations (3, n_rows) of every row of a part over instants."""
    rows = np.arange(len(part.points)).reshape(len(part.sides), -1)

    def block(start: int) -> Floats:
        nodes = slice(start, start + _BLOCK)
        histories = RowHistories(part, rows[:, nodes].ravel(), part.every(weights, nodes))
        return histories.utilisation.reshape(len(CRITERIA), len(rows), -1)

    blocks = list(side_by_side(block, range(0, rows.shape[1], _BLOCK)))
    return np.concatenate(blocks, axis=2).reshape(len(CRITERIA), -1)


def most_used(usage: Floats) -> Ints:
    """Return the rows of the largest of the utilisations (3, n)."""
    used = usage[usage.any(axis=1)] if usage.any() else usage[:1]
    return np.unique(np.argsort(-used, axis=1)[:, :_CLOSEST])


def decisive_angles(
    cycle: CrankCycle,
    angles: Floats,
    histories: Sequence[RowHistories],
    usage: Sequence[Floats],
    window: int = WINDOW,
) -> Floats:
    """Crank angles around the extremes of the three worst rows against each mode, rad."""
    found = set[int]()
    for mode in CRITERIA:
        most = [of_part[mode].max(initial=0.0) for of_part in usage]
        number = int(np.argmax(most))
        if not most[number] and mode:  # no part fails in this way
            continue
        for row in np.argsort(-usage[number][mode])[:3]:
            signed = signed_equivalent(histories[number].stress[row : row + 1])[0]
            found |= {int(signed.argmax()), int(signed.argmin())}
    return around(cycle, angles[sorted(found)], window)


def around(cycle: CrankCycle, angles: Floats, window: int = WINDOW) -> Floats:
    """Crank angles of a cycle, a degree apart, within so many degrees of each of some, rad."""
    degrees = np.round(angles / DEG)[:, None] + np.arange(-window, window + 1)
    return np.asarray(np.unique(np.mod(degrees, cycle.engine.cycle_degrees)) * DEG)
