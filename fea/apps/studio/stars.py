"""Weights of designs that are solved, the anchors, at a design between them.

A star is an anchor with lines of others through it, each along one dimension. What a dimension changes alone
is interpolated on its line; what two change together, beyond that, grows with the product of both distances
and is measured at one anchor where both are others: the first terms of an expansion about a point (cut-HDMR,
Rabitz and Alış 1999). On a line, weights are those of kriging with a Gaussian covariance and a linear trend
(Sacks et al. 1989, eqs. 5-7), close to the polynomial through its anchors.

The error of each line is the standard deviation of the kriging, whose scale is what leaving out one anchor at
a time changes (Dubrule 1983). That of two dimensions together, where it is not measured, is the geometric
mean of the products of what two change alone, as where the stress is a product of powers of the dimensions,
and of those of their distances, as where they act together only; where it is measured, shares of that and
of what was measured. The constants are fitted on rods that are solved: tests/benchmarks/studio_gap.py.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Ints, Mask

SAME = 1e-9
_REACH = 2.5  # of the covariance, in units of the scaled dimensions
# Standard deviations on a line that are shown as its error; the square of what two dimensions change together
# over the products of what they change alone and of their distances; and where that is measured, the share of
# it and of the measured that is left.
GAP, _MIXED, _LEFT, _OF_MEASURED = 3.0, 0.12, 0.25, 0.6


@dataclass(frozen=True, eq=False)
class Line:
    """Anchors on a line."""

    on: Ints  #: their numbers
    x: Floats  #: (n,) where they are

    def covers(self, x: float) -> bool:
        """Whether a place is between them."""
        return bool(self.x.min() - SAME <= x <= self.x.max() + SAME)

    @property
    def ends(self) -> tuple[float, float]:
        """The least and the largest of them."""
        return float(self.x.min()), float(self.x.max())

    @cached_property
    def _inverse(self) -> Floats:
        """Inverse of the kriging equations."""
        count, trend = len(self.x), np.column_stack([np.ones(len(self.x)), self.x])
        system = np.zeros((count + 2,) * 2)
        system[:count, :count] = self._covariance(self.x[:, None]) + 1e-10 * np.eye(count)
        system[:count, count:], system[count:, :count] = trend, trend.T
        return np.asarray(np.linalg.pinv(system, hermitian=True))

    def _covariance(self, x: Floats | float) -> Floats:
        return np.asarray(np.exp(-((self.x - x) ** 2) / (2 * _REACH**2)))

    def weights(self, x: float) -> tuple[Floats, float]:
        """Weights (n,) of the anchors at a place, and the standard deviation there over the scale."""
        right = np.concatenate([self._covariance(x), [1.0, x]])
        solution = self._inverse @ right
        return solution[: len(self.x)], float(np.sqrt(max(0.0, 1.0 - right @ solution)))

    def scale(self, values: Floats) -> float:
        """Root mean square of what leaving out one of the anchors changes, of values (n,) at them."""
        own = self._inverse[: len(self.x), : len(self.x)]
        return float(np.sqrt(((own @ values) ** 2 / np.maximum(np.diag(own), 1e-12)).mean()))


class Mix(NamedTuple):
    """What is added up at one design; rows are weights (n_anchors,)."""

    weights: Floats  #: of all
    lines: list[tuple[Line, float]]  #: by dimension that is changed: its line, the standard deviation there
    alone: Floats  #: (n_changed, n_anchors) of what each of them changes alone
    apart: Floats  #: (n_changed,) their distances
    measured: Mask  #: (n_pairs,) of every two of them, whether both together are measured
    together: Floats  #: (n_measured, n_anchors) of what these change beyond what each of them does

    def error(self, values: Floats, direction: Floats) -> float:
        """Estimated error of the length of values (n_anchors, 5), whose direction (5,) is given."""
        first, second = np.triu_indices(len(self.apart), 1)
        alone = np.linalg.norm(self.alone @ values, axis=1)
        changes, apart = alone[first] * alone[second], self.apart[first] * self.apart[second]
        left = [
            share * np.sqrt(_MIXED * np.linalg.norm(changes[some]) * np.linalg.norm(apart[some]))
            for share, some in ((1.0, ~self.measured), (_LEFT, self.measured))
        ]
        along = (GAP * deviation * line.scale(values[line.on] @ direction) for line, deviation in self.lines)
        return float(np.linalg.norm([*left, _OF_MEASURED * np.linalg.norm(self.together @ values), *along]))


@dataclass(frozen=True, eq=False)
class Star:
    """An anchor, and those around it."""

    center: int  #: its number
    x: Floats  #: (n_anchors, n) scaled dimensions of all
    lines: Mapping[int, Line]  #: through it, by dimension
    corners: Mapping[tuple[int, int], int]  #: an anchor where two of these are others

    def changed(self, x: Floats) -> Ints:
        """The dimensions that are others at scaled dimensions (n,)."""
        return np.flatnonzero(np.abs(x - self.x[self.center]) > SAME)

    def covers(self, x: Floats) -> bool:
        """Whether nothing is extrapolated there."""
        return all(i in self.lines and self.lines[i].covers(x[i]) for i in self.changed(x).tolist())

    def away(self, x: Floats) -> float:
        """How far a design is, where two dimensions change: the sum of their squared distances' products."""
        square = (x - self.x[self.center]) ** 2
        return float(square.sum() ** 2 - (square**2).sum())

    def at(self, x: Floats) -> Mix:
        """Return what is added up at scaled dimensions that are covered."""
        own, each, changed = self.x[self.center], np.eye(len(self.x)), self.changed(x).tolist()
        pairs, together = list(combinations(changed, 2)), list[Floats]()
        for i, j in (pair for pair in pairs if pair in self.corners):
            there = self.corners[i, j]
            at = self.x[there]
            beyond = each[there] - each[self.center] - self._alone(i, at[i]) - self._alone(j, at[j])
            together.append(beyond * np.prod((x - own)[[i, j]] / (at - own)[[i, j]]))
        every = [self._alone(i, x[i]) for i in changed], together
        alone, beside = (np.reshape(rows, (-1, len(each))) for rows in every)
        lines = [(self.lines[i], self.lines[i].weights(x[i])[1]) for i in changed]
        measured = np.array([pair in self.corners for pair in pairs], bool)
        weights = each[self.center] + alone.sum(axis=0) + beside.sum(axis=0)
        return Mix(weights, lines, alone, np.abs(x - own)[changed], measured, beside)

    def _alone(self, dimension: int, x: float) -> Floats:
        """Weights of what a dimension changes alone from the center to a place on its line."""
        line = self.lines[dimension]
        weights: Floats = -np.eye(len(self.x))[self.center]
        weights[line.on] += line.weights(x)[0]
        return weights


def stars(x: Floats) -> Iterator[Star]:
    """Yield the star of each anchor, of scaled dimensions (n_anchors, n)."""
    for center in range(len(x)):
        other = np.abs(x - x[center]) > SAME
        count, lines = other.sum(axis=1), dict[int, Line]()
        for i in np.flatnonzero(other[count == 1].any(axis=0)).tolist():
            on = np.flatnonzero((count == 0) | ((count == 1) & other[:, i]))
            if len(on) > 2:
                lines[i] = Line(on, x[on, i])
        corners = dict[tuple[int, int], int]()
        for number in np.flatnonzero(count == 2).tolist():
            i, j = np.flatnonzero(other[number]).tolist()
            if all(k in lines and lines[k].covers(x[number, k]) for k in (i, j)):
                corners[i, j] = number
        yield Star(center, x, lines, corners)
