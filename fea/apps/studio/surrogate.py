"""Weights of sampled designs at a design between them: a cut-HDMR expansion about one of them.

A stencil is a sampled design with lines of others through it, each along one dimension. The effect of one
dimension alone is interpolated on its line; that of two together, beyond that, grows with the product of both
distances and is measured at one sampled design where both change (cut-HDMR of second order, Rabitz and Alış
1999). On a line, weights are those of kriging with a Gaussian covariance and a linear trend (Sacks et al.
1989, eqs. 5-7), close to the polynomial through its designs.

The error of a line is the standard deviation of the kriging, scaled by cross-validation that leaves out one
design at a time (Dubrule 1983). That of two dimensions together, where it is not measured, is the geometric
mean of the products of their effects, exact for products of powers, and of those of their distances, exact
where they act together only; where it is measured, shares of that and of the measured effect. The constants
are fitted on solved rods: tests/benchmarks/studio_gap.py.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Ints, Mask

SAME = 1e-9
_RANGE = 2.5  # of the covariance, in units of the scaled dimensions
# Standard deviations on a line that count as its error; the square of the effect of two dimensions together
# over the products of their effects and of their distances; and, where it is measured, the share of that
# estimate and of the measured effect that remains.
_DEVIATIONS, _MIXED, _REMAINDER, _OF_MEASURED = 3.0, 0.12, 0.25, 0.6


@dataclass(frozen=True, eq=False)
class SampledLine:
    """Sampled designs along one dimension."""

    designs: Ints  #: their numbers
    x: Floats  #: (n,) their scaled dimension

    @property
    def ends(self) -> tuple[float, float]:
        """The least and the largest dimension."""
        return float(self.x.min()), float(self.x.max())

    def covers(self, x: float) -> bool:
        """Whether nothing is extrapolated at a dimension."""
        return bool(self.x.min() - SAME <= x <= self.x.max() + SAME)

    @cached_property
    def _inverse(self) -> Floats:
        """Inverse of the kriging equations."""
        count, trend = len(self.x), np.column_stack([np.ones(len(self.x)), self.x])
        covariance = self._covariance(self.x[:, None]) + 1e-10 * np.eye(count)
        system = np.block([[covariance, trend], [trend.T, np.zeros((2, 2))]])
        return np.asarray(np.linalg.pinv(system, hermitian=True))

    def _covariance(self, x: Floats | float) -> Floats:
        return np.asarray(np.exp(-((self.x - x) ** 2) / (2 * _RANGE**2)))

    def weights(self, x: float) -> tuple[Floats, float]:
        """Weights (n,) of the designs at a dimension, and the standard deviation there over the scale."""
        right = np.concatenate([self._covariance(x), [1.0, x]])
        solution = self._inverse @ right
        return solution[: len(self.x)], float(np.sqrt(max(0.0, 1.0 - right @ solution)))

    def scale(self, values: Floats) -> float:
        """Root mean square of the cross-validation errors of values (n,) at the designs."""
        inverse = self._inverse[: len(self.x), : len(self.x)]
        return float(np.sqrt(((inverse @ values) ** 2 / np.maximum(np.diag(inverse), 1e-12)).mean()))


class SurrogateWeights(NamedTuple):
    """Weights (n_designs,) at one design, and the terms that they consist of."""

    weights: Floats
    lines: list[
        tuple[SampledLine, float]
    ]  #: of each dimension that differs, and the standard deviation there
    single: Floats  #: (n_changed, n_designs) effect of each of them alone
    distances: Floats  #: (n_changed,)
    measured: Mask  #: (n_pairs,) of every two of them, whether their joint effect is measured
    joint: Floats  #: (n_measured, n_designs) these effects, beyond those of each of the two

    def error(self, values: Floats, direction: Floats) -> float:
        """Estimated error of the length of values (n_designs, 5), whose direction (5,) is given."""
        first, second = np.triu_indices(len(self.distances), 1)
        single = np.linalg.norm(self.single @ values, axis=1)
        effects, distances = single[first] * single[second], self.distances[first] * self.distances[second]
        joint = [
            share * np.sqrt(_MIXED * np.linalg.norm(effects[pairs]) * np.linalg.norm(distances[pairs]))
            for share, pairs in ((1.0, ~self.measured), (_REMAINDER, self.measured))
        ]
        measured = _OF_MEASURED * np.linalg.norm(self.joint @ values)
        along = (
            _DEVIATIONS * deviation * line.scale(values[line.designs] @ direction)
            for line, deviation in self.lines
        )
        return float(np.linalg.norm([*joint, measured, *along]))


@dataclass(frozen=True, eq=False)
class CutStencil:
    """A sampled design, and those around it that its expansion needs."""

    center: int  #: its number
    x: Floats  #: (n_designs, n) scaled dimensions of all
    lines: Mapping[int, SampledLine]  #: through it, by dimension
    corners: Mapping[tuple[int, int], int]  #: a design in which just these two dimensions differ

    def changed(self, x: Floats) -> list[int]:
        """Dimensions that differ from the center at scaled dimensions (n,)."""
        return [int(i) for i in np.flatnonzero(np.abs(x - self.x[self.center]) > SAME)]

    def covers(self, x: Floats) -> bool:
        """Whether nothing is extrapolated there."""
        return all(i in self.lines and self.lines[i].covers(x[i]) for i in self.changed(x))

    def distance(self, x: Floats) -> float:
        """Measure of the joint effects there: the sum of the products of squared distances."""
        square = (x - self.x[self.center]) ** 2
        return float(square.sum() ** 2 - (square**2).sum())

    def at(self, x: Floats) -> SurrogateWeights:
        """Return the weights at scaled dimensions that are covered."""
        center, unit, changed = self.x[self.center], np.eye(len(self.x)), self.changed(x)
        pairs, joint = list(combinations(changed, 2)), list[Floats]()
        for i, j in (pair for pair in pairs if pair in self.corners):
            corner = self.corners[i, j]
            there = self.x[corner]
            effect = unit[corner] - unit[self.center] - self._single(i, there[i]) - self._single(j, there[j])
            joint.append(effect * np.prod((x - center)[[i, j]] / (there - center)[[i, j]]))
        terms = [self._single(i, x[i]) for i in changed], joint
        single, joint_rows = (np.reshape(rows, (-1, len(unit))) for rows in terms)
        lines = [(self.lines[i], self.lines[i].weights(x[i])[1]) for i in changed]
        measured = np.array([pair in self.corners for pair in pairs], bool)
        weights = unit[self.center] + single.sum(axis=0) + joint_rows.sum(axis=0)
        return SurrogateWeights(weights, lines, single, np.abs(x - center)[changed], measured, joint_rows)

    def _single(self, dimension: int, x: float) -> Floats:
        """Weights of the effect of one dimension alone, from the center to a place on its line."""
        line = self.lines[dimension]
        weights: Floats = -np.eye(len(self.x))[self.center]
        weights[line.designs] += line.weights(x)[0]
        return weights


def stencils(x: Floats) -> Iterator[CutStencil]:
    """Yield the stencil about each sampled design, of scaled dimensions (n_designs, n)."""
    for center in range(len(x)):
        other = np.abs(x - x[center]) > SAME
        count, lines = other.sum(axis=1), dict[int, SampledLine]()
        for i in np.flatnonzero(other[count == 1].any(axis=0)).tolist():
            on = np.flatnonzero((count == 0) | ((count == 1) & other[:, i]))
            if len(on) > 2:
                lines[i] = SampledLine(on, x[on, i])
        corners = dict[tuple[int, int], int]()
        for number in np.flatnonzero(count == 2).tolist():
            i, j = np.flatnonzero(other[number]).tolist()
            if all(k in lines and lines[k].covers(x[number, k]) for k in (i, j)):
                corners[i, j] = number
        yield CutStencil(center, x, lines, corners)
