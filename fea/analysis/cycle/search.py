"""The worst places of a rod at many speeds, without evaluating every place at every instant of each.

The candidates for the worst place follow from a few speeds (see `fea.analysis.cycle.candidates`): between two
of them the stress is bounded by the mean of both in speed squared. Every place is evaluated again at the
worst speeds.
"""

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fea.analysis.cycle.basis import joined
from fea.analysis.cycle.candidates import (
    FATIGUE,
    MODES,
    YIELDING,
    Candidates,
    Histories,
    RowHistories,
    around,
)
from fea.analysis.cycle.screened import stress_measures
from fea.analysis.cycle.superposition import CycleAnalysis
from fea.analysis.figures import CaseFigures, PlaceFigures
from fea.judge.fatigue import crossland_factors, enclosing_balls
from fea.judge.history import signed_equivalent
from fea.judge.safety_factor import SafetyFactor, without_bar
from fea.judge.verdict import CAP, safety_factor
from fea.machine.threads import side_by_side
from geometry.arrays import Floats, vector
from loads.crank_cycle import CrankCycle
from loads.instants import Instants


@dataclass(frozen=True)
class WorstPlace:
    """The worst place against one mode of failure."""

    factor: float  #: its safety factor
    crank_angle: float  #: of the largest von Mises stress, rad
    figures: PlaceFigures  #: without the factor against fatigue


@dataclass(frozen=True)
class WorstOfSpeed:
    """The worst of the cycle at one speed."""

    cases: tuple[Instants, ...]  #: the peak cases
    peaks: tuple[CaseFigures, ...]  #: of the cases, superposed
    #: yielding, fatigue: the worst places; fatigue is None if no part's strengths are known
    yielding: WorstPlace
    fatigue: WorstPlace | None


# Number of speeds at which every place is evaluated first.
SURVEYED = 5
# Speeds whose peak cases are superposed at once.
AT_ONCE = 10
# Share of the largest distance from its centre, and of the largest mean stress, from which on an instant may
# decide on Crossland's factor of a place.
_DECIDING = 0.98


class SpeedSearch:
    """Finds the worst places at any speed between the first and the last.

    `cycles`: the crank cycle at a speed, rpm; `speeds`: rpm; at least one.
    """

    def __init__(
        self, analysis: CycleAnalysis, cycles: Callable[[float], CrankCycle], speeds: Sequence[float]
    ) -> None:
        self._analysis, self._cycles, self._candidates = analysis, cycles, Candidates(analysis)
        count = min(SURVEYED, len(speeds))
        surveyed = np.unique(np.linspace(0, len(speeds) - 1, count).round().astype(int))
        for rpm in np.sort(np.asarray(speeds, float))[surveyed]:
            self._candidates.survey(cycles(rpm))
        self._candidates.choose()
        blocks = [speeds[start : start + AT_ONCE] for start in range(0, len(speeds), AT_ONCE)]
        found = [peaks for block in side_by_side(self._at_peaks, blocks) for peaks in block]
        self._peaks = dict(zip(speeds, found, strict=True))

    def at(self, rpm: float) -> WorstOfSpeed:
        """Find the worst places at a speed between the first and the last, rpm."""
        cycle = self._cycles(rpm)
        cases = cycle.peaks.cases
        figures = self._peaks[rpm] if rpm in self._peaks else self._at_peaks([rpm])[0]
        histories = self._candidates.histories(cycle, cases.crank_angle[cases.in_cycle])
        yielding, fatigue = (self._worst(cycle, histories, mode) for mode in (YIELDING, FATIGUE))
        yielding = dataclasses.replace(yielding, factor=min(yielding.factor, CAP))
        return WorstOfSpeed(tuple(cases), figures, yielding, fatigue if np.isfinite(fatigue.factor) else None)

    def confirmed(self, rpm: float, found: WorstOfSpeed) -> bool:
        """Look at every place at a speed, rpm; if any is worse than what was found there, search again."""
        known = np.full(len(MODES), np.nan)
        known[YIELDING] = 1 / found.yielding.factor
        if found.fatigue is not None:
            known[FATIGUE] = 1 / found.fatigue.factor
        return self._candidates.confirm(self._cycles(rpm), known)

    def _worst(self, cycle: CrankCycle, histories: Histories, mode: int) -> WorstPlace:
        """Find the worst candidate against a mode of failure."""
        usage = [of_part.utilisation[mode] for of_part in histories.parts]
        number = int(np.argmax([used.max() for used in usage]))
        row = int(usage[number].argmax())
        of_part = histories.parts[number]
        factor = 1 / usage[number][row] if usage[number][row] > 0 else np.inf
        worst = RowHistories(of_part.part, of_part.rows[[row]], of_part.stress[[row]])
        return self._place(factor, worst, cycle, histories.angles)

    def _place(self, factor: float, worst: RowHistories, cycle: CrankCycle, angles: Floats) -> WorstPlace:
        part, row = worst.part, int(worst.rows[0])
        signed = signed_equivalent(worst.stress)[0]
        highest, lowest = float(signed.max()), float(signed.min())
        skin, region = float(part.surface(worst.rows)[0]), part.region(row)
        limit = part.material.endurance_limit
        spot = crossland_factors(self._around_decisive(worst, cycle, angles), part.material, skin)
        figures = PlaceFigures(
            at_mm=vector(part.points[row]),
            mean_MPa=(highest + lowest) / 2,
            amplitude_MPa=(highest - lowest) / 2,
            stress_ratio=lowest / highest if highest else 0.0,
            fatigue_safety_factor=None,
            crossland_safety_factor=None if spot is None else without_bar(float(spot[0])),
            endurance_MPa=None if limit is None else skin * limit,
            surface_region=None if region is None else region.value,
        )
        return WorstPlace(factor, float(angles[np.abs(signed).argmax()]), figures)

    def _around_decisive(self, worst: RowHistories, cycle: CrankCycle, angles: Floats) -> Floats:
        """Stress (1, 6, n_instants) of a row, also around the instants that decide on Crossland's factor."""
        history = worst.stress
        _, center = enclosing_balls(history[:, :5])
        away, mean = np.linalg.norm(history[0, :5] - center[0, :, None], axis=0), history[0, 5]
        deciding = (away >= _DECIDING * away.max()) | (mean == mean.max())
        more = np.setdiff1d(around(angles[deciding]), angles)
        added = worst.part.stress(self._analysis.weights(cycle, more), worst.rows)
        return np.concatenate([history, added], axis=2)

    def _at_peaks(self, speeds: Sequence[float]) -> list[tuple[CaseFigures, ...]]:
        """Superpose the peak cases of some speeds: many are hardly more work than those of one."""
        cases = [self._cycles(rpm).peaks.cases for rpm in speeds]
        weights = joined(*(self._analysis.basis.weights(of_speed) for of_speed in cases))
        stress = [part.measured(weights, stress_measures) for part in self._candidates.parts]
        ends = np.cumsum([0, *map(len, cases)])
        return [
            tuple(self._figures([of_part[:, k] for of_part in stress]) for k in range(start, stop))
            for start, stop in pairwise(ends)
        ]

    def _figures(self, stress: Sequence[Floats]) -> CaseFigures:
        """Figures of a case, from the measures (3, n_rows) of `screened` of each part."""
        peaks = []
        for part, (equivalent, largest, opposite) in zip(self._candidates.parts, stress, strict=True):
            row = int(equivalent.argmax())
            factor = safety_factor(equivalent[row : row + 1], part.material.yield_strength)
            peaks.append(
                CaseFigures(
                    max_von_mises_MPa=float(equivalent[row]),
                    at_mm=vector(part.points[row]),
                    max_principal_MPa=float(largest.max()),
                    min_principal_MPa=-float(opposite.max()),
                    max_displacement_mm=None,
                    min_safety_factor=SafetyFactor(float(factor[0])),
                    error_percent=None,
                    verdict=None,
                )
            )
        return dataclasses.replace(
            max(peaks, key=lambda peak: peak.max_von_mises_MPa),
            max_principal_MPa=max(peak.max_principal_MPa for peak in peaks),
            min_principal_MPa=min(peak.min_principal_MPa for peak in peaks),
            min_safety_factor=min(peak.min_safety_factor for peak in peaks),
        )
