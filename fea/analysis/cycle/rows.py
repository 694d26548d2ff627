"""The places of a part, with their stresses over cycles, and bounds on these that need few instants.

Most instants of a cycle may be estimates. Where contact makes weights dear, they are solved at every few
degrees and estimated between these, with an upper bound of their error (`PressureEstimator` in
`fea.contact.active_set`). Loads do not depend on it, so that the stress away from the bores hardly does. A
place on a bore could by this bound err by much more than any does: its estimates are trusted to a part of its
largest stress as well, until a solution shows otherwise. Degrees are solved as long as what estimates may err
by leaves the worst place, or the instants that decide on it, in doubt.
"""

from collections.abc import Callable
from copy import copy
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fea.analysis.cycle.screened import Block, Path, distances_from_middle, norms, path, product, superposed
from fea.analysis.cycle.superposition import CycleAnalysis
from fea.base.choices import Region
from fea.base.material import Material
from fea.judge.fatigue import fatigue_factor
from fea.judge.history import NO_SIGN, deviator_norm, deviatoric
from fea.pins.model import SampledWeights, Weights
from geometry.arrays import Floats, Ints, Mask, Reals

# Number of nodes for which bounds are computed at once.
_NODES = 2000
# Relative allowance for rounding in the bounds, in single precision.
ROUNDING = 1e-6
# That for what rounding takes from differences of sums of squares.
_CANCELLED = 1e-6
# Number of sectors of the cycle with bounds of their own.
_SECTORS = 24


class PartRows:
    """A part's nodes, then their images across y = 0, as rows with stresses; singular places left out."""

    def __init__(self, analysis: CycleAnalysis, number: int) -> None:
        own, self._sides = analysis.units.parts[number], analysis.units.sides
        counts = analysis.counts[own.nodes]
        if not counts.any():  # a part has a worst place
            counts[:] = True
        self._even, self._odd = deviatoric(own.even[counts]), deviatoric(own.odd[counts])
        self.joint, self._balanced = own.joint, analysis.loads.balanced
        self.material = analysis.materials[number]
        self._criterion, self.regions = analysis.fatigue, analysis.regions.at(own.nodes[counts])
        self._surface = np.tile(self.regions.factors(self.material), len(self._sides))
        points = analysis.mesh.cell.points[own.nodes[counts]]
        self.points = np.concatenate([points * [1, side, 1] for side in self._sides])

    def made_of(self, material: Material) -> "PartRows":
        """Return the same rows of another material, whose stresses under the unit loads are the same."""
        other = copy(self)
        other.material = material
        other._surface = np.tile(self.regions.factors(material), len(self._sides))  # noqa: SLF001
        return other

    @cached_property
    def _norms(self) -> list[Reals]:
        units = zip((self._even, self._odd), self.joint, strict=True)
        return [norms(own, joint)[0] for own, joint in units]

    @cached_property
    def of_errors(self) -> tuple[Floats, Floats]:
        """Largest von Mises and mean stress (n_rows,) that errors of weights of unit length can cause."""
        balanced = self._balanced()
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
        return np.minimum(self.of_errors[0][rows][:, None] * error, most[:, None])

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
        strays, ends, first = self.strayed(along.strays), along.at_ends(), first_chords(along)
        largest = np.empty((len(self.points), len(first)), np.float32)
        for start in range(0, len(largest), _NODES):
            rows = np.arange(start, min(start + _NODES, len(largest)))
            at_ends = deviator_norm(self.stress(ends, rows))
            chords = np.maximum(at_ends[:, :-1], at_ends[:, 1:]) + strays[rows]
            largest[rows] = (1 + ROUNDING) * np.maximum.reduceat(chords, first, axis=1)
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


def first_chords(along: Path) -> Ints:
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


# What estimates are first allowed to err by, relative to the largest stress of the place. Where a solution
# shows that one errs by more, twice as much is allowed.
ALLOWED = 0.1
# Of stresses in single precision, MPa.
_TINY = 1e-2
# Where weights are estimated, places are evaluated at every instant: as many at once.
ESTIMATED_ROWS = 200
# Relative: a place that estimates leave in doubt by less is not looked at more closely.
WITHIN = 5e-5
# Places in doubt for which instants are solved at once, and how many for each.
_AT_ONCE, _INSTANTS = 10, 40
# Crossland's radius is that of the instants that come as near to the ball, relative to its radius.
_NEAR_BALL = 0.1


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


def judged(part: PartRows, rows: Ints, cycle: EstimatedCycle, mode: Mode, best: float) -> Floats:
    """Factors (n,) of some rows, infinite where estimates show that they are not below `best`."""
    factors = np.full(len(rows), np.inf)
    low = np.flatnonzero(_roughly(part, rows, cycle, mode) < best * (1 - WITHIN))
    for start in range(0, len(low), ESTIMATED_ROWS):
        some = low[start : start + ESTIMATED_ROWS]
        factors[some] = _exactly(part, rows[some], cycle, mode, best)
        best = min(best, float(factors[some].min()))
    return factors


def _roughly(part: PartRows, rows: Ints, cycle: EstimatedCycle, mode: Mode) -> Floats:
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
    return _least_factors(part, rows, middle, error * (1 + ROUNDING), mode)[0]


def _exactly(part: PartRows, rows: Ints, cycle: EstimatedCycle, mode: Mode, best: float) -> Floats:
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
        wrong = deviator_norm(exact - history[..., which]) > error[:, which] * (1 + ROUNDING) + _TINY
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


def settled(part: PartRows, row: int, cycle: EstimatedCycle) -> Floats:
    """History (1, 6, n_instants) of a row, exact where it decides Crossland's factor."""
    rows = np.array([row])
    history = part.stress(cycle.weights, rows)
    if cycle.estimated:
        size, mean = deviator_norm(history)[0], history[0, 5]
        most = cycle.allowed * size.max()
        error, pressed = (np.minimum(own[row] * cycle.error, most) for own in part.of_errors)
        apart = distances_from_middle(history[:, :5], history[:, :5, size.argmax()])[0]
        outside = apart + error > (1 - _NEAR_BALL) * apart.max()
        tensest = mean + pressed > (mean - pressed).max()
        least = WITHIN / 2 * size.max()
        which = np.flatnonzero((outside & (error > least)) | (tensest & (pressed > least)))
        if which.size:
            cycle.solve(which)
            history[..., which] = part.stress(cycle.weights.at(which), rows)
    return history
