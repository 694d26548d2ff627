"""Places judged over cycles of which most instants are estimates.

Where contact makes weights costly, they are solved at every few degrees and estimated between these, with an
upper bound of their error (`PressureEstimator` in `fea.contact.active_set`). Loads do not depend on it, so
that the stress away from the bores hardly does. A place on a bore could by this bound err by much more than
any does: its estimates are trusted to a part of its largest stress as well, until a solution shows otherwise.
Degrees are solved as long as what estimates may err by leaves the worst place, or the instants that decide on
it, in doubt (`fea.analysis.cycle.criteria`).
"""

import numpy as np

from fea.analysis.cycle.criteria import Judge
from fea.analysis.cycle.rows import ROUNDING, PartRows
from fea.analysis.cycle.screened import path
from fea.judge.history import deviator_norm
from fea.pins.model import SampledWeights, Weights
from geometry.arrays import Floats, Ints

# What estimates are first allowed to err by, relative to the largest stress of the place. Where a solution
# shows that one errs by more, twice as much is allowed.
ALLOWED = 0.1
# Of stresses in single precision, MPa.
_TINY = 1e-2
# Where weights are estimated, places are evaluated at every instant: as many at once.
ESTIMATED_ROWS = 200
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


def judged(part: PartRows, rows: Ints, cycle: EstimatedCycle, judge: Judge, best: float) -> Floats:
    """Factors (n,) of some rows, infinite where estimates show that they are not below `best`."""
    factors = np.full(len(rows), np.inf)
    low = np.flatnonzero(_roughly(part, rows, cycle, judge) < best)
    for start in range(0, len(low), ESTIMATED_ROWS):
        some = low[start : start + ESTIMATED_ROWS]
        factors[some] = exactly(part, rows[some], cycle, judge, best)
        best = min(best, float(factors[some].min()))
    return factors


def _roughly(part: PartRows, rows: Ints, cycle: EstimatedCycle, judge: Judge) -> Floats:
    """Lower bounds (n,) of the factors of rows: all of a chord is as near to its middle as its ends."""
    along = path(cycle.weights, part.joint)
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
    """Do so by solving instants, for the rows of the least bounds first, until no row is in doubt."""
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
