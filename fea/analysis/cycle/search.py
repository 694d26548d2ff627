"""The worst place of a rod at many speeds, without evaluating every place at each.

Only places with a high enough bound on their largest von Mises stress are evaluated. At a speed ω between two
anchors the weights of every instant are w = (1 − s) w₀ + s w₁ + δ with s linear in ω², like inertia; and the
von Mises stress is convex and positively homogeneous, a norm of the deviator. So

    σ_vM(ω, t) ≤ (1 − s) M₀ + s M₁ + Σ_k max_t |δ_k| σ_vM,k

at every instant t, where M is an upper bound of the stress at the anchor (by the chords of
`fea.analysis.cycle.screened`) and σ_vM,k is the equivalent stress of unit load k. The factor against yielding
is at least the yield strength over this bound. With |mean| + amplitude ≤ max σ_vM, the utilisation a/S_e +
m/S by Goodman or Soderberg is at most max(1/S_e, 1/S) times the bound, and so is that by Gerber, which is
convex in (a, m) and not larger at either end of that segment. S_e is that of the place: it depends on the
finish of the surface there.

Places are evaluated at every degree in the order of their bounds, until the next bound is not worse than the
worst place found: the places left out cannot be the worst.

Where contact makes weights costly, they are solved at every few degrees of the anchors and estimated between
these and between the anchors, with an upper bound of their error (`PressureEstimator` in
`fea.contact.active_set`). Loads do not depend on it, so that the stress away from the bores hardly does. A
place on a bore could by this bound err by much more than any does: its estimates are trusted to a part of its
largest stress as well, until a solution shows otherwise. Degrees are solved as long as what estimates may err
by leaves the worst place, or the instants that decide on it, in doubt (`fea.analysis.cycle.criteria`).
"""

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from fea.analysis.cycle.basis import joined
from fea.analysis.cycle.criteria import Judge, crossland, tiring, yielding
from fea.analysis.cycle.rows import ROUNDING, PartRows, first_chords
from fea.analysis.cycle.screened import Path, path, sizes, stress_measures
from fea.analysis.cycle.superposition import CycleAnalysis
from fea.analysis.figures import CaseFigures, PlaceFigures
from fea.judge.fatigue import crossland_factors
from fea.judge.history import deviator_norm, signed_equivalent
from fea.judge.safety_factor import SafetyFactor, without_bar
from fea.judge.verdict import CAP, safety_factor
from fea.machine.threads import side_by_side
from fea.pins.model import JointBounds, SampledWeights, Weights
from geometry.arrays import Floats, Ints, Reals, vector
from loads.crank_cycle import CrankCycle
from loads.instants import Instants
from loads.slider_crank import cycle_angles

# What estimates are first allowed to err by, relative to the largest stress of the place. Where a solution
# shows that one errs by more, twice as much is allowed.
ALLOWED = 0.1
# Of stresses in single precision, MPa.
_TINY = 1e-2
# Places evaluated at every instant at once: the first are likely to exclude the others.
EXACT_ROWS = 16
# How many instants are solved at once for each place in doubt.
_INSTANTS = 40


class EstimatedCycle:
    """The degrees of a cycle, and its peak cases among them, in the order of time.

    Attributes: `angles`, `weights`, `error`: crank angles, rad, and those of `SampledWeights`; `rpm`,
    `degrees`: the speed, and the weights at the degrees alone; `allowed`: what estimates may err by, relative
    to the largest stress of the place.
    """

    def __init__(
        self, rpm: float, angles: Floats, degrees: SampledWeights, peaks: Floats, of_peaks: Weights
    ) -> None:
        self.rpm, self.degrees, self.allowed = rpm, degrees, ALLOWED
        every = np.append(angles, peaks)
        self._order = np.argsort(every)
        self.angles = every[self._order]
        pairs = zip(degrees.weights, of_peaks, strict=True)
        self.weights = Weights(*(np.append(w, c, axis=1)[:, self._order] for w, c in pairs))
        self.error = np.append(degrees.error, np.zeros(len(peaks)))[self._order]
        self._along: Path | None = None

    @property
    def estimated(self) -> bool:
        """Whether some weights are not exact."""
        return bool(self.error.any())

    def solve(self, which: Ints) -> None:
        """Make the weights of some instants exact."""
        which = which[self.error[which] > 0]
        degrees = self._order[which]
        self.degrees.solve(degrees)
        for known, exact in zip(self.weights, self.degrees.weights, strict=True):
            known[:, which] = exact[:, degrees]
        self.error[which], self._along = 0.0, None

    def along(self, joint: JointBounds) -> Path:
        """Return the path of all instants."""
        self._along = self._along or path(self.weights, joint)
        return self._along


def judged(part: PartRows, rows: Ints, cycle: EstimatedCycle, judge: Judge, best: float) -> Floats:
    """Factors (n,) of some rows, infinite where estimates show that they are not below `best`."""
    factors = np.full(len(rows), np.inf)
    least = _roughly(part, rows, cycle, judge)
    order = np.argsort(least)
    for start in range(0, len(order), EXACT_ROWS):
        some = order[start : start + EXACT_ROWS]
        some = some[least[some] < best]
        if not some.size:
            break
        factors[some] = exactly(part, rows[some], cycle, judge, best)
        best = min(best, float(factors[some].min()))
    return factors


def _roughly(part: PartRows, rows: Ints, cycle: EstimatedCycle, judge: Judge) -> Floats:
    """Lower bounds (n,) of the factors of rows: all of a chord is as near to its middle as its ends."""
    along = cycle.along(part.joint)
    at_ends = part.stress(along.at_ends(), rows)
    half = deviator_norm(np.diff(at_ends, axis=2)) / 2
    within = np.maximum(np.maximum.reduceat(cycle.error, along.ends[:-1]), cycle.error[along.ends[1:]])
    largest = deviator_norm(at_ends).max(axis=1)
    error = half + part.strayed(along.strays, rows)
    if cycle.estimated:
        error += part.errors(rows, within, cycle.allowed * largest)[0]
    middle = (at_ends[..., :-1] + at_ends[..., 1:]) / 2
    return judge(part, rows, middle, np.stack([error * (1 + ROUNDING)] * 2)).least


def exactly(part: PartRows, rows: Ints, cycle: EstimatedCycle, judge: Judge, best: float = np.inf) -> Floats:
    """Factors as of `judged`: instants are solved, for the least bounds first, until no row is in doubt."""
    history = part.stress(cycle.weights, rows)
    while True:
        size = deviator_norm(history)
        errors = part.errors(rows, cycle.error, cycle.allowed * size.max(axis=1))
        known = judge(part, rows, history, errors)
        best, low = known.doubtful(best)
        if not low.size:
            return np.where(known.needed.any(axis=1), np.inf, known.least)
        upper = np.where(known.needed, size + errors[0], 0)[low]
        # The largest first: they may leave the others out of question.
        last = np.sort(upper, axis=1)[:, -min(_INSTANTS, upper.shape[1]), None]
        which = np.flatnonzero((known.needed[low] & (upper >= last)).any(axis=0))
        cycle.solve(which)
        exact = part.stress(cycle.weights.at(which), rows)
        wrong = deviator_norm(exact - history[..., which]) > errors[0][:, which] * (1 + ROUNDING) + _TINY
        cycle.allowed *= 2 if wrong.any() else 1
        history[..., which] = exact


@dataclass(frozen=True)
class Place:
    """The worst place against one mode of failure."""

    factor: float  #: its safety factor
    crank_angle: float  #: of the largest von Mises stress, rad
    figures: PlaceFigures  #: without the factor against fatigue


class PeakStress(NamedTuple):
    """The peak cases at one speed, superposed."""

    cases: Instants
    weights: Weights
    figures: tuple[CaseFigures, ...]
    largest: list[Reals]  #: (n_rows,) of each part: upper bound of the von Mises stress of those in the cycle


@dataclass(frozen=True)
class Worst:
    """The worst of the cycle at one speed."""

    cases: tuple[Instants, ...]  #: the peak cases
    peaks: tuple[CaseFigures, ...]  #: of the cases, superposed
    #: yielding, fatigue: the worst places; fatigue is None if no part's strengths are known
    yielding: Place
    fatigue: Place | None


class Mode(NamedTuple):
    """A mode of failure."""

    #: Lower bounds of the factors of all rows of a part by their largest von Mises stress
    bound: Callable[[PartRows, Floats], Floats]
    judge: Judge


YIELDING, FATIGUE = Mode(PartRows.yielding_bound, yielding), Mode(PartRows.fatigue_bound, tiring)


# Number of speeds at which bounds are computed for every place; between them bounds are interpolated.
ANCHORS = 9
# If δ increases the bounds by more than this fraction on average, they are computed again for every place:
# that is cheaper than evaluating many places.
STRAYED = 0.2
# Places evaluated at once: some 12 MB with their unit stresses, 3.5 kB each, and 50 ends of chords.
ROWS = 2000
# Size of the first batch, which is likely to contain the worst place.
FIRST_ROWS = 50
# Speeds whose peak cases are superposed at once.
AT_ONCE = 10


class SpeedSearch:
    """Finds the worst places at any speed between the first and the last.

    It needs memory for a copy of the unit stresses, and per place 100 bytes an anchor and 4 a speed.

    `cycles`: the crank cycle at a speed, rpm; `speeds`: rpm; at least one.
    """

    def __init__(
        self, analysis: CycleAnalysis, cycles: Callable[[float], CrankCycle], speeds: Sequence[float]
    ) -> None:
        self._analysis, self._cycles = analysis, cycles
        self._degrees = cycle_angles()
        self._parts = [PartRows(analysis, number) for number in range(len(analysis.units.parts))]
        places = np.unique(np.linspace(0, len(speeds) - 1, min(ANCHORS, len(speeds))).round().astype(int))
        self._anchors = np.sort(np.asarray(speeds, float))[places]
        self._sampled = {rpm: self._sample(rpm) for rpm in self._anchors}
        # Copies: what is solved later does not change what the bounds are of.
        self._weights = [Weights(*(w.copy() for w in sample.weights)) for sample in self._sampled.values()]
        self._largest = [[part.bound(weights) for part in self._parts] for weights in self._weights]
        along = path(self._weights[0], analysis.units.joint)
        self._starts = along.ends[first_chords(along)]
        blocks = [speeds[start : start + AT_ONCE] for start in range(0, len(speeds), AT_ONCE)]
        found = [peaks for block in side_by_side(self._at_peaks, blocks) for peaks in block]
        self._peaks = dict(zip(speeds, found, strict=True))

    def at(self, rpm: float) -> Worst:
        """Find the worst places at a speed between the first and the last, rpm."""
        peaks = self._peaks.get(rpm) or self._at_peaks([rpm])[0]
        cases, cyclic = peaks.cases, peaks.cases.in_cycle
        sampled = self._sampled.get(rpm) or self._sample(rpm, self._estimates(rpm))
        angles = cases[cyclic].crank_angle
        cycle = EstimatedCycle(rpm, self._degrees, sampled, angles, peaks.weights.at(cyclic))
        allowed = 0.0
        while cycle.allowed > allowed:  # solutions may have shown that more must be allowed
            allowed, largest = cycle.allowed, self._bounds(cycle, peaks.largest)
            yielding, fatigue = (self._worst(cycle, largest, mode) for mode in (YIELDING, FATIGUE))
        yielding = dataclasses.replace(yielding, factor=min(yielding.factor, CAP))
        return Worst(tuple(cases), peaks.figures, yielding, fatigue if np.isfinite(fatigue.factor) else None)

    def _at_peaks(self, speeds: Sequence[float]) -> list[PeakStress]:
        """Superpose the peak cases of some speeds: many are hardly more work than those of one."""
        cases = [self._cycles(rpm).peaks.cases for rpm in speeds]
        weights = [self._analysis.basis.weights(of_speed) for of_speed in cases]
        found, stop = list[PeakStress](), 0
        stress = [part.measured(joined(*weights), stress_measures) for part in self._parts]
        for own, at in zip(cases, weights, strict=True):
            start, stop = stop, stop + len(own)
            figures = tuple(self._figures([of_part[:, k] for of_part in stress]) for k in range(start, stop))
            cyclic = np.flatnonzero(own.in_cycle) + start
            largest = ((1 + ROUNDING) * sizes[cyclic].max(axis=0, initial=0.0) for sizes, *_ in stress)
            found.append(PeakStress(own, at, figures, [most.astype(np.float32) for most in largest]))
        return found

    def _sample(self, rpm: float, like: Sequence[tuple[float, SampledWeights]] = ()) -> SampledWeights:
        cycle = self._cycles(rpm)
        return self._analysis.loads.sampled(cycle.at(self._degrees), cycle, like)

    def _estimates(self, rpm: float) -> list[tuple[float, SampledWeights]]:
        """Shares of the anchors on either side of a speed, of which the loads at it are nearly the sum."""
        above, share = self._between(rpm)
        low, high = (self._sampled[anchor] for anchor in self._anchors[above - 1 : above + 1])
        return [(1 - share, low), (share, high)]

    def _between(self, rpm: float) -> tuple[int, float]:
        """Number of the anchor above a speed, and the share that it has in the forces of inertia."""
        above = int(np.clip(np.searchsorted(self._anchors, rpm), 1, len(self._anchors) - 1))
        low, high = self._anchors[above - 1 : above + 1] ** 2
        return above, (rpm**2 - low) / (high - low)

    def _in_sectors(self, cycle: EstimatedCycle) -> list[Reals]:
        """Bound (n_rows, n_sectors) of the von Mises stress of each part, or of its estimate."""
        weights, joint = cycle.degrees.weights, self._analysis.units.joint
        if len(self._anchors) == 1:
            return [part.bound(weights) for part in self._parts]
        above, share = self._between(cycle.rpm)
        before, after = self._weights[above - 1], self._weights[above]
        strays = Weights(
            *(
                np.maximum.reduceat(sizes(w - (1 - share) * b - share * a, norms), self._starts, axis=1)
                for w, b, a, norms in zip(weights, before, after, joint, strict=True)
            )
        )
        between = zip(self._largest[above - 1], self._largest[above], strict=True)
        straight = [(1 - share) * b + share * a for b, a in between]
        strayed = [part.strayed(strays) for part in self._parts]
        if sum(s.sum() for s in strayed) > STRAYED * sum(s.sum() for s in straight):
            return [part.bound(weights) for part in self._parts]
        return [one + other for one, other in zip(straight, strayed, strict=True)]

    def _bounds(self, cycle: EstimatedCycle, at_peaks: list[Reals]) -> list[Floats]:
        """Upper bounds (n_rows,) of the von Mises stress of each part; those of its peak cases are known."""
        error, bounds = np.maximum.reduceat(cycle.degrees.error, self._starts), []
        for part, sectors, peak in zip(self._parts, self._in_sectors(cycle), at_peaks, strict=True):
            away: Floats | float = 0.0
            if cycle.estimated:
                away = part.errors(slice(None), error, cycle.allowed * sectors.max(axis=1))[0]
            bounds.append(np.maximum((sectors + away).max(axis=1), peak))
        return bounds

    def _worst(self, cycle: EstimatedCycle, largest: list[Floats], mode: Mode) -> Place:
        """Find the worst place against a mode of failure, given what the stress of each part is at most."""
        bounds = [mode.bound(part, most) for part, most in zip(self._parts, largest, strict=True)]
        least = np.concatenate(bounds)  # lower bounds of the factors of the rows of all parts
        order, numbers = np.argsort(least), range(len(self._parts))
        part_of = np.repeat(numbers, [len(part.points) for part in self._parts])
        row_of = np.concatenate([np.arange(len(part.points)) for part in self._parts])
        best, worst = np.inf, (self._parts[part_of[order[0]]], int(row_of[order[0]]))
        for start, stop in pairwise([0, *range(FIRST_ROWS, len(order), ROWS), len(order)]):
            chosen = order[start:stop]
            chosen = chosen[least[chosen] < best]
            if not chosen.size:
                break
            for number, part in zip(numbers, self._parts, strict=True):
                rows = row_of[chosen[part_of[chosen] == number]]
                if rows.size and (factors := judged(part, rows, cycle, mode.judge, best)).min() < best:
                    best, worst = float(factors.min()), (part, int(rows[factors.argmin()]))
        return self._place(best, *worst, cycle)

    def _place(self, factor: float, part: PartRows, row: int, cycle: EstimatedCycle) -> Place:
        rows = np.array([row])
        if cycle.estimated:
            exactly(part, rows, cycle, crossland)
        history = part.stress(cycle.weights, rows)
        signed = signed_equivalent(history)[0]
        highest, lowest = float(signed.max()), float(signed.min())
        angle = float(cycle.angles[np.abs(signed).argmax()])
        skin, region = float(part.surface(rows)[0]), part.region(row)
        limit, spot = part.material.endurance_limit, crossland_factors(history, part.material, skin)
        history_figures = PlaceFigures(
            at_mm=vector(part.points[row]),
            mean_MPa=(highest + lowest) / 2,
            amplitude_MPa=(highest - lowest) / 2,
            stress_ratio=lowest / highest if highest else 0.0,
            fatigue_safety_factor=None,
            crossland_safety_factor=None if spot is None else without_bar(float(spot[0])),
            endurance_MPa=None if limit is None else skin * limit,
            surface_region=None if region is None else region.value,
        )
        return Place(factor, angle, history_figures)

    def _figures(self, stress: Sequence[Floats]) -> CaseFigures:
        """Figures of a case, from the measures (3, n_rows) of `screened` of each part."""
        peaks = []
        for part, (equivalent, largest, opposite) in zip(self._parts, stress, strict=True):
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
