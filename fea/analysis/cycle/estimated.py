"""A cycle of which most instants are estimates, and its worst place in spite of that.

Where contact makes weights dear, they are solved at every few degrees and estimated between these, with an
upper bound of their error (`fea.contact.estimate`). Loads do not depend on it, so that the stress away from
the bores hardly does. A place on a bore could by this bound err by much more than any does: its estimates are
trusted to a part of its largest stress as well, until a solution shows otherwise. Degrees are solved as long
as what estimates may err by leaves the worst place, or the instants that decide on it, in doubt.
"""

import numpy as np

from fea.analysis.cycle.path import path
from fea.analysis.cycle.rows import ROUNDING, YIELDING, Mode, PartRows
from fea.analysis.cycle.screened import distances_from_middle
from fea.judge.history import NO_SIGN, deviator_norm
from fea.pins.model import SampledWeights, Weights
from geometry.arrays import Floats, Ints, Mask

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
