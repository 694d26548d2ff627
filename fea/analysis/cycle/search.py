"""The worst place of a rod at many speeds, without evaluating every place at each.

Only places with a high enough bound on their largest von Mises stress are evaluated. At a speed ω between two
anchors the weights of every instant are w = (1 − s) w₀ + s w₁ + δ with s linear in ω², like inertia; and the
von Mises stress is convex and positively homogeneous, a norm of the deviator. So

    σ_vM(ω, t) ≤ (1 − s) M₀ + s M₁ + Σ_k max_t |δ_k| σ_vM,k

at every instant t, where M is an upper bound of the stress at the anchor (by the chords of
`fea.analysis.cycle.path`) and σ_vM,k is the equivalent stress of unit load k. The factor against yielding is
at least the yield strength over this bound. With |mean| + amplitude ≤ max σ_vM, the utilisation a/S_e + m/S
by Goodman or Soderberg is at most max(1/S_e, 1/S) times the bound, and so is that by Gerber, which is convex
in (a, m) and not larger at either end of that segment. S_e is that of the place: it depends on the finish of
the surface there.

Places are evaluated at every degree in the order of their bounds, until the next bound is not worse than the
worst place found: the places left out cannot be the worst.

Where contact makes weights dear, they are solved at every few degrees and estimated between these, with an
upper bound of their error (`fea.contact.estimate`). Loads do not depend on it, so that the stress away from
the bores hardly does. A place on a bore could by this bound err by much more than any does: its estimates are
trusted to a part of its largest stress as well, until a solution shows otherwise. Degrees are solved as long
as what estimates may err by leaves the worst place, or the instants that decide on it, in doubt.
"""

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from fea.analysis.cycle.path import Path, norms, path, sizes
from fea.analysis.cycle.screened import Block, distances_from_middle, product, superposed
from fea.analysis.cycle.superposition import CycleAnalysis
from fea.analysis.figures import CaseFigures, PlaceFigures, vector
from fea.base.choices import Region
from fea.judge.fatigue import crossland_factors, fatigue_factor
from fea.judge.history import NO_SIGN, deviator_norm, deviatoric, extreme_principals, signed_equivalent
from fea.judge.verdict import CAP, safety_factor
from fea.pins.model import SampledWeights, Weights
from geometry.arrays import Floats, Ints, Mask, Reals
from loads.cases import peak_cases
from loads.crank_cycle import CrankCycle
from loads.instants import Instants
from loads.slider_crank import cycle_angles

# Number of nodes for which bounds are computed at once.
_NODES = 2000
# What estimates are first allowed to err by, relative to the largest stress of the place. Where a solution
# shows that one errs by more, twice as much is allowed.
ALLOWED = 0.1
# Relative allowance for rounding in the bounds, in single precision.
_ROUNDING = 1e-6
# Of stresses in single precision, MPa.
_TINY = 1e-2
# That for what rounding takes from differences of sums of squares.
_CANCELLED = 1e-6
# Number of sectors of the cycle with bounds of their own.
_SECTORS = 24


class PartRows:
    """The nodes of a part, then their images across y = 0: rows, with their stresses and bounds on them.

    Nodes near a singular place are left out.
    """

    def __init__(self, analysis: CycleAnalysis, number: int) -> None:
        own, self._sides = analysis.units.parts[number], analysis.units.sides
        counts = analysis.counts[own.nodes]
        if not counts.any():  # a part has a worst place
            counts[:] = True
        self._even, self._odd = deviatoric(own.even[counts]), deviatoric(own.odd[counts])
        self.joint = own.joint
        self._norms = [
            norms(units, joint)[0] for units, joint in zip((self._even, self._odd), own.joint, strict=True)
        ]
        self.material = analysis.materials[number]
        self._criterion, self.regions = analysis.fatigue, analysis.regions.at(own.nodes[counts])
        self._surface = np.tile(self.regions.factors(self.material), len(self._sides))
        points = analysis.mesh.cell.points[own.nodes[counts]]
        self.points = np.concatenate([points * [1, side, 1] for side in self._sides])

        self.apart, self.pressed = self._of_errors(analysis.loads.balanced())

    def _of_errors(self, balanced: Weights | None) -> tuple[Floats, Floats]:
        """Largest von Mises and mean stress (n_rows,) that errors of weights of unit length can cause."""
        largest, pressed = np.zeros((2, len(self._sides), len(self._even)))
        if balanced is not None:
            units = [(q, z.astype(q.dtype)) for q, z in zip((self._even, self._odd), balanced, strict=True)]
            for start in range(0, len(self._even), _NODES):
                rows = slice(start, start + _NODES)
                own = [(q[rows, :, : len(z)], z) for q, z in units]
                every = sum(q @ q.swapaxes(1, 2) for q, _ in own)
                even, odd = (q @ z for q, z in own)
                for number, side in enumerate(self._sides):
                    free = even + side * odd
                    squares = every - free @ free.swapaxes(1, 2)
                    rounding = _CANCELLED * np.trace(every, axis1=1, axis2=2)
                    largest[number, rows] = np.linalg.eigvalsh(squares[:, :5, :5])[:, -1] + rounding
                    pressed[number, rows] = squares[:, 5, 5] + rounding
        return np.sqrt(largest.ravel()), np.sqrt(pressed.ravel())

    def stress(self, weights: Weights, rows: Ints) -> Floats:
        """Stress (n, 6, n_instants) of some rows."""
        image, node = np.divmod(rows, len(self._even))
        side = np.asarray(self._sides)[image, None, None]
        return product(self._even[node], weights.even) + side * product(self._odd[node], weights.odd)

    def errors(self, rows: Ints | slice, error: Floats, most: Floats) -> Floats:
        """Bounds (n, n_instants) of the errors of von Mises stress of some rows, at `most` (n,).

        `error` (n_instants,): that of the weights.
        """
        return np.minimum(self.apart[rows][:, None] * error, most[:, None])

    def block(self, along: Path, rows: Ints) -> Block:
        """Return some rows over a path."""
        image, node = np.divmod(rows, len(self._even))
        side = np.asarray(self._sides)[image, None, None]
        return Block(self._even[node], side * self._odd[node], along, (1,), principals=False)

    def every(self, weights: Weights) -> Floats:
        """Stress (n_rows, 6, n_instants) of every row."""
        return np.asarray(superposed(self._even, self._odd, self._sides, weights), np.float64)

    def strayed(self, strays: Weights, rows: Ints | None = None) -> Floats:
        """Upper bound (n, n_chords) of the von Mises stress of rows for weights of at most these sizes."""
        even, odd = self._norms
        node = slice(None) if rows is None else rows % len(self._even)
        bound = even[node] @ strays.even + odd[node] @ strays.odd
        return np.concatenate([bound] * len(self._sides)) if rows is None else bound

    def bound(self, weights: Weights) -> Reals:
        """Upper bound of the largest von Mises stress (n_rows, n_sectors) over each sector."""
        along = path(weights, self.joint)
        strays, ends, first = self.strayed(along.strays), along.at_ends(), _first_chords(along)
        largest = np.empty((len(self.points), len(first)), np.float32)
        for start in range(0, len(largest), _NODES):
            rows = np.arange(start, min(start + _NODES, len(largest)))
            at_ends = deviator_norm(self.stress(ends, rows))
            chords = np.maximum(at_ends[:, :-1], at_ends[:, 1:]) + strays[rows]
            largest[rows] = (1 + _ROUNDING) * np.maximum.reduceat(chords, first, axis=1)
        return largest

    def yielding_bound(self, largest: Floats) -> Floats:
        """Lower bound of the (uncapped) factors against yielding for stresses of at most `largest`."""
        return self.material.yield_strength / np.maximum(largest, np.finfo(float).tiny)

    def yielding_factor(self, highest: Floats, lowest: Floats, rows: Ints) -> Floats:  # noqa: ARG002
        """Factors (n,) against yielding of the extremes of the signed equivalent stress of some rows."""
        return self.yielding_bound(np.maximum(np.abs(highest), np.abs(lowest)))

    def fatigue_factor(self, highest: Floats, lowest: Floats, rows: Ints) -> Floats:
        """Factors (n,) against fatigue of the extremes of the signed equivalent stress of some rows."""
        return self._fatigue((highest + lowest) / 2, (highest - lowest) / 2, self._surface[rows])

    def _fatigue(self, mean: Floats, amplitude: Floats, surface: Floats) -> Floats:
        """Factors against fatigue; infinite if the strengths are not known."""
        factors = fatigue_factor(self._criterion, mean, amplitude, self.material, surface)
        return np.full(len(mean), np.inf) if factors is None else factors

    def fatigue_bound(self, largest: Floats) -> Floats:
        """Lower bound (n_rows,) of the fatigue factors where the von Mises stress is at most `largest`."""
        none, surface = np.zeros_like(largest), self._surface
        return np.minimum(self._fatigue(none, largest, surface), self._fatigue(largest, none, surface))

    def surface(self, row: int) -> tuple[float, Region | None]:
        """Return the factor of the surface of a row, and its region; None inside the solid."""
        node = row % len(self._even)
        return float(self._surface[row]), self.regions.region(node, self.material)


def _first_chords(along: Path) -> Ints:
    """Numbers of the chords with which sectors of a path begin."""
    count = len(along.ends) - 1
    return np.arange(0, count, -(-count // _SECTORS))


class Mode(NamedTuple):
    """A mode of failure."""

    #: Lower bounds of the factors of all rows of a part by their largest von Mises stress
    bound: Callable[[PartRows, Floats], Floats]
    #: Factors of some rows by the highest and lowest signed equivalent stress
    factor: Callable[[PartRows, Floats, Floats, Ints], Floats]


YIELDING = Mode(PartRows.yielding_bound, PartRows.yielding_factor)
FATIGUE = Mode(PartRows.fatigue_bound, PartRows.fatigue_factor)


@dataclass(frozen=True)
class Place:
    """The worst place against one mode of failure."""

    factor: float  #: its safety factor
    crank_angle: float  #: of the largest von Mises stress, rad
    figures: PlaceFigures  #: without the factor against fatigue


@dataclass(frozen=True)
class Worst:
    """The worst of the cycle at one speed."""

    cases: tuple[Instants, ...]  #: the peak cases
    peaks: tuple[CaseFigures, ...]  #: of the cases, superposed
    #: yielding, fatigue: the worst places; fatigue is None if no part's strengths are known
    yielding: Place
    fatigue: Place | None


# Number of speeds at which bounds are computed for every place; between them bounds are interpolated.
ANCHORS = 9
# If δ increases the bounds by more than this fraction on average, they are computed again for every place:
# that is cheaper than evaluating many places.
STRAYED = 0.2
# Places evaluated at once: some 12 MB with their unit stresses, 3.5 kB each, and 50 ends of chords.
ROWS = 2000
# Size of the first batch, which is likely to contain the worst place.
FIRST_ROWS = 50
# Where weights are estimated, places are evaluated at every instant: as many at once.
ESTIMATED_ROWS = 200
# Relative: a place that estimates leave in doubt by less is not looked at more closely.
WITHIN = 5e-5
# Places in doubt for which instants are solved at once, and how many for each.
_AT_ONCE, _INSTANTS = 10, 40
# Crossland's radius is that of the instants that come as near to the ball, relative to its radius.
_NEAR_BALL = 0.1


class SpeedSearch:
    """Finds the worst places at any speed between the first and the last.

    It needs memory for a copy of the unit stresses, and 8 bytes per place and anchor.

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
        self._weights = [Weights(*(w.copy() for w in own.weights)) for own in self._sampled.values()]
        self._largest = [[part.bound(weights) for part in self._parts] for weights in self._weights]
        along = path(self._weights[0], analysis.units.joint)
        self._starts = along.ends[_first_chords(along)]

    @property
    def instants(self) -> int:
        """How many instants of the cycle are looked at."""
        return len(self._degrees)

    def at(self, rpm: float) -> Worst:
        """Find the worst places at a speed between the first and the last, rpm."""
        cases = peak_cases(self._cycles(rpm)).cases
        of_cases = self._analysis.case_weights(cases)
        cyclic = cases.in_cycle
        cycle = self._cycle(rpm, cases[cyclic], of_cases.at(cyclic))
        at_cases = [part.every(of_cases) for part in self._parts]
        at_peaks = [deviator_norm(stress[..., cyclic]).max(axis=1, initial=0.0) for stress in at_cases]
        allowed = 0.0
        while cycle.allowed > allowed:  # solutions may have shown that more must be allowed
            allowed = cycle.allowed
            yielding, fatigue = (self._worst(cycle, at_peaks, mode) for mode in (YIELDING, FATIGUE))
        yielding = dataclasses.replace(yielding, factor=min(yielding.factor, CAP))
        peaks = tuple(self._peak([stress[..., k] for stress in at_cases]) for k in range(len(cases)))
        return Worst(tuple(cases), peaks, yielding, fatigue if np.isfinite(fatigue.factor) else None)

    def _cycle(self, rpm: float, peaks: Instants, of_peaks: Weights) -> "_Cycle":
        sampled = self._sampled.get(rpm) or self._sample(rpm)
        return _Cycle(rpm, self._degrees, sampled, peaks.crank_angle, of_peaks)

    def _sample(self, rpm: float) -> SampledWeights:
        cycle = self._cycles(rpm)
        return self._analysis.loads.sampled(cycle.at(self._degrees), cycle)

    def _in_sectors(self, cycle: "_Cycle") -> list[Reals]:
        """Upper bound (n_rows, n_sectors) of the von Mises stress of every row of each part.

        Where weights are estimated, it is that of the estimates.
        """
        weights, joint = cycle.degrees.weights, self._analysis.units.joint
        above = int(np.clip(np.searchsorted(self._anchors, cycle.rpm), 1, max(len(self._anchors) - 1, 1)))
        if len(self._anchors) == 1:
            return [part.bound(weights) for part in self._parts]
        low, high = self._anchors[above - 1] ** 2, self._anchors[above] ** 2
        share = (cycle.rpm**2 - low) / (high - low)
        before, after = self._weights[above - 1], self._weights[above]
        strays = Weights(
            *(
                np.maximum.reduceat(sizes(w - (1 - share) * b - share * a, own), self._starts, axis=1)
                for w, b, a, own in zip(weights, before, after, joint, strict=True)
            )
        )
        between = zip(self._largest[above - 1], self._largest[above], strict=True)
        straight = [(1 - share) * b + share * a for b, a in between]
        strayed = [part.strayed(strays) for part in self._parts]
        if sum(s.sum() for s in strayed) > STRAYED * sum(s.sum() for s in straight):
            return [part.bound(weights) for part in self._parts]
        return [one + other for one, other in zip(straight, strayed, strict=True)]

    def _worst(self, cycle: "_Cycle", at_peaks: list[Floats], mode: Mode) -> Place:
        """The place of the smallest factor."""
        least = self._least(cycle, at_peaks, mode)
        order = np.argsort(least)
        best, at = np.inf, int(order[0])
        for start, stop in pairwise([0, *range(FIRST_ROWS, len(order), ROWS), len(order)]):
            chosen = order[start:stop]
            chosen = chosen[least[chosen] < best]
            if not chosen.size:
                break
            best, at = self._least_of(chosen, cycle, mode, (best, at))
        return self._place(best, *self._row(at), cycle)

    def _least(self, cycle: "_Cycle", at_peaks: list[Floats], mode: Mode) -> Floats:
        """Lower bounds of the factors of the rows of all parts, one after another."""
        error, least = np.maximum.reduceat(cycle.degrees.error, self._starts), []
        for part, sectors, peak in zip(self._parts, self._in_sectors(cycle), at_peaks, strict=True):
            away = (
                part.errors(slice(None), error, cycle.allowed * sectors.max(axis=1))
                if cycle.estimated
                else 0.0
            )
            least.append(mode.bound(part, np.maximum((sectors + away).max(axis=1), peak)))
        return np.concatenate(least)

    def _row(self, place: int) -> tuple[PartRows, int]:
        """Return the part of a place, numbered over all parts, and its row there."""
        for part in self._parts:
            if place < len(part.points):
                break
            place -= len(part.points)
        return part, place

    def _least_of(
        self, places: Ints, cycle: "_Cycle", mode: Mode, known: tuple[float, int]
    ) -> tuple[float, int]:
        """The smallest factor among some places, and its place; what is known so far if none is smaller."""
        (best, at), start = known, 0
        along = path(cycle.weights, self._analysis.units.joint)
        for part in self._parts:
            rows = places[(places >= start) & (places < start + len(part.points))] - start
            if rows.size:
                if cycle.estimated:
                    factors = _judged(part, rows, cycle, mode, best)
                else:
                    factors = mode.factor(part, *part.block(along, rows).signed(), rows)
                if factors.min() < best:
                    best, at = float(factors.min()), int(rows[factors.argmin()]) + start
            start += len(part.points)
        return best, at

    def _place(self, factor: float, part: PartRows, row: int, cycle: "_Cycle") -> Place:
        history = _settled(part, row, cycle)
        signed = signed_equivalent(history)[0]
        highest, lowest = float(signed.max()), float(signed.min())
        angle = float(cycle.angles[np.abs(signed).argmax()])
        skin, region = part.surface(row)
        limit, spot = part.material.endurance_limit, crossland_factors(history, part.material, skin)
        history_figures = PlaceFigures(
            at_mm=vector(part.points[row]),
            mean_MPa=(highest + lowest) / 2,
            amplitude_MPa=(highest - lowest) / 2,
            stress_ratio=lowest / highest if highest else 0.0,
            fatigue_safety_factor=None,
            crossland_safety_factor=None if spot is None else float(spot[0]),
            endurance_MPa=None if limit is None else skin * limit,
            surface_region=None if region is None else region.value,
        )
        return Place(factor, angle, history_figures)

    def _peak(self, stresses: list[Floats]) -> CaseFigures:
        peaks = []
        for part, stress in zip(self._parts, stresses, strict=True):
            equivalent = deviator_norm(stress[..., None])[:, 0]
            largest, least = (sign * _largest_principal(sign * stress, equivalent) for sign in (1, -1))
            row = int(equivalent.argmax())
            peak = CaseFigures(
                max_von_mises_MPa=float(equivalent[row]),
                at_mm=vector(part.points[row]),
                max_principal_MPa=largest,
                min_principal_MPa=least,
                max_displacement_mm=None,
                min_safety_factor=float(
                    safety_factor(equivalent[row : row + 1], part.material.yield_strength)[0]
                ),
                error_percent=None,
                verdict=None,
            )
            peaks.append(peak)
        return dataclasses.replace(
            max(peaks, key=lambda peak: peak.max_von_mises_MPa),
            max_principal_MPa=max(peak.max_principal_MPa for peak in peaks),
            min_principal_MPa=min(peak.min_principal_MPa for peak in peaks),
            min_safety_factor=min(peak.min_safety_factor for peak in peaks),
        )


class _Cycle:
    """The degrees of a cycle, and its peak cases among them, in the order of time.

    Attributes
    ----------
    angles, weights, error
        Crank angles, rad, and those of `SampledWeights`.
    rpm, degrees
        The speed, and the weights at the degrees alone.
    allowed
        What estimates may err by, relative to the largest stress of the place.
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

    @property
    def estimated(self) -> bool:
        """Whether some weights are not exact."""
        return bool(self.error.any())

    def solve(self, which: Ints) -> None:
        """Make the weights of some instants exact."""
        which = which[self.error[which] > 0]
        degrees = self._order[which]
        self.degrees.solve(degrees)
        for own, exact in zip(self.weights, self.degrees.weights, strict=True):
            own[:, which] = exact[:, degrees]
        self.error[which] = 0.0


def _judged(part: PartRows, rows: Ints, cycle: _Cycle, mode: Mode, best: float) -> Floats:
    """Factors (n,) of some rows, infinite where estimates show that they are not below `best`."""
    factors = np.full(len(rows), np.inf)
    low = np.flatnonzero(_roughly(part, rows, cycle, mode) < best * (1 - WITHIN))
    for start in range(0, len(low), ESTIMATED_ROWS):
        some = low[start : start + ESTIMATED_ROWS]
        factors[some] = _exactly(part, rows[some], cycle, mode, best)
        best = min(best, float(factors[some].min()))
    return factors


def _roughly(part: PartRows, rows: Ints, cycle: _Cycle, mode: Mode) -> Floats:
    """Lower bounds (n,) of the factors of rows: all of a chord is as near to its middle as its ends."""
    along = path(cycle.weights, part.joint)
    at_ends = part.stress(along.at_ends(), rows)
    half = deviator_norm(np.diff(at_ends, axis=2)) / 2
    within = np.maximum(np.maximum.reduceat(cycle.error, along.ends[:-1]), cycle.error[along.ends[1:]])
    largest = deviator_norm(at_ends).max(axis=1)
    error = half + part.strayed(along.strays, rows)
    if cycle.estimated:
        error += part.errors(rows, within, cycle.allowed * largest)
    middle = (at_ends[..., :-1] + at_ends[..., 1:]) / 2
    return _least_factors(part, rows, middle, error * (1 + _ROUNDING), mode)[0]


def _exactly(part: PartRows, rows: Ints, cycle: _Cycle, mode: Mode, best: float) -> Floats:
    """Do so by solving instants, for the rows of the least bounds first, until no row is in doubt."""
    history = part.stress(cycle.weights, rows)
    while True:
        error = part.errors(rows, cycle.error, cycle.allowed * deviator_norm(history).max(axis=1))
        least, needed = _least_factors(part, rows, history, error, mode)
        doubtful = needed.any(axis=1)
        best = min(best, float(least[~doubtful].min(initial=np.inf)))
        low = np.flatnonzero(doubtful & (least < best * (1 - WITHIN)))
        if not low.size:
            return np.where(doubtful, np.inf, least)
        low = low[np.argsort(least[low])[:_AT_ONCE]]
        upper = np.where(needed, deviator_norm(history) + error, 0)[low]
        # The largest first: they may leave the others out of question.
        last = np.sort(upper, axis=1)[:, -min(_INSTANTS, upper.shape[1]), None]
        which = np.flatnonzero((needed[low] & (upper >= last)).any(axis=0))
        cycle.solve(which)
        exact = part.stress(cycle.weights.at(which), rows)
        wrong = deviator_norm(exact - history[..., which]) > error[:, which] * (1 + _ROUNDING) + _TINY
        cycle.allowed *= 2 if wrong.any() else 1
        history[..., which] = exact


def _least_factors(
    part: PartRows, rows: Ints, history: Floats, error: Floats, mode: Mode
) -> tuple[Floats, Mask]:
    """Lower bounds (n,) of factors, and the instants (n, n_instants) that must be solved to know them.

    The stress of a history (n, 6, n_instants) is known to an `error` (n, n_instants) of von Mises stress. The
    longest q is that of one of the instants whose upper bound exceeds the largest lower one. From there the
    sign of q · q* at every instant is known, or not, and with it an interval for the least signed stress. The
    utilisation is convex in it, so that the smaller of the factors at its ends counts.
    """
    size, numbers, tiny = deviator_norm(history), np.arange(len(rows)), np.finfo(float).tiny
    upper, lower = size + error, np.maximum(size - error, 0)
    first, largest = size.argmax(axis=1), upper.max(axis=1)
    longest = (upper > lower.max(axis=1)[:, None]) & (error > 0)
    if mode is YIELDING:
        return mode.factor(part, largest, largest, rows), longest
    worst, reached = history[numbers, :5, first], np.maximum(size[numbers, first], tiny)[:, None]
    along = ((worst / reached)[:, None] @ history[:, :5])[:, 0]
    away = np.sqrt(np.maximum(size**2 + reached**2 - 2 * along * reached, 0)) + error
    margin = error + upper * np.where(longest, away, 0).max(axis=1, keepdims=True) / reached
    least = np.where(along < margin, -upper, lower).min(axis=1)
    most = np.where(along < -margin, -lower, upper).min(axis=1)
    unsettled = longest.any(axis=1)
    deciding = (np.where(along < margin, -upper, lower) <= most[:, None]) & (error > 0)
    compressed = ~unsettled & (history[numbers, 5, first] < -NO_SIGN * reached[:, 0])
    ends = (
        mode.factor(part, np.where(compressed, -end, largest), np.where(compressed, -largest, end), rows)
        for end in (least, most)
    )
    return np.minimum(*ends), np.where(unsettled[:, None], longest, deciding)


def _settled(part: PartRows, row: int, cycle: _Cycle) -> Floats:
    """History (1, 6, n_instants) of a row, exact where it decides Crossland's factor."""
    rows = np.array([row])
    history = part.stress(cycle.weights, rows)
    if cycle.estimated:
        size, mean = deviator_norm(history)[0], history[0, 5]
        most = cycle.allowed * size.max()
        error, pressed = (np.minimum(own[row] * cycle.error, most) for own in (part.apart, part.pressed))
        apart = distances_from_middle(history[:, :5], history[:, :5, size.argmax()])[0]
        outside = apart + error > (1 - _NEAR_BALL) * apart.max()
        tensest = mean + pressed > (mean - pressed).max()
        least = WITHIN / 2 * size.max()
        which = np.flatnonzero((outside & (error > least)) | (tensest & (pressed > least)))
        if which.size:
            cycle.solve(which)
            history[..., which] = part.stress(cycle.weights.at(which), rows)
    return history


def _largest_principal(stress: Floats, equivalent: Floats) -> float:
    """Largest principal stress of all (n, 6), evaluated only where the bound σ_m + ⅔ σ_vM requires it."""
    bound = stress[:, 5] + 2 / 3 * equivalent
    best = [bound.argmax()]
    largest = extreme_principals(stress[best].T, equivalent[best])[0]
    high = bound > largest
    return float(np.append(extreme_principals(stress[high].T, equivalent[high])[0], largest).max())
