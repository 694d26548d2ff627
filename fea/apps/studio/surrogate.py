"""Weights of sampled designs at a design between them, by lines of designs through one of them.

A stencil is a sampled design with lines of others through it, each along one dimension. The effect of each
dimension alone is interpolated on its line, and these effects add up: the terms of first order of a cut-HDMR
expansion (Rabitz and Alış 1999). On a line, weights are those of kriging with a Gaussian covariance and a
linear trend (Sacks et al. 1989, eqs. 5-7), close to the polynomial through its designs.

The error of a line is the standard deviation of the kriging, scaled by cross-validation that leaves out one
design at a time (Dubrule 1983). What two dimensions do together beyond that is estimated: by the geometric
mean of the products of their effects, exact for products of powers, and of those of their distances, exact
where they act together only. The constants are fitted on solved rods: tests/benchmarks/studio_gap.py.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Ints

SAME = 1e-9
_RANGE = 2.5  # of the covariance, in units of the scaled dimensions
# Standard deviations on a line that count as its error; and the square of the effect of two dimensions
# together over the products of their effects and of their distances.
_DEVIATIONS, _MIXED = 3.0, 0.36


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
    lines: list[tuple[SampledLine, float]]  #: of each changed dimension, and the standard deviation there
    single: Floats  #: (n_changed, n_designs) effect of each of them alone
    distances: Floats  #: (n_changed,)

    def error(self, values: Floats, direction: Floats) -> float:
        """Estimated error of the length of values (n_designs, 5), whose direction (5,) is given."""
        first, second = np.triu_indices(len(self.distances), 1)
        single = np.linalg.norm(self.single @ values, axis=1)
        effects, distances = single[first] * single[second], self.distances[first] * self.distances[second]
        joint = np.sqrt(_MIXED * np.linalg.norm(effects) * np.linalg.norm(distances))
        along = (
            _DEVIATIONS * deviation * line.scale(values[line.designs] @ direction)
            for line, deviation in self.lines
        )
        return float(np.linalg.norm([joint, *along]))


@dataclass(frozen=True, eq=False)
class CutStencil:
    """A sampled design, and the lines of others through it."""

    center: int  #: its number
    x: Floats  #: (n_designs, n) scaled dimensions of all
    lines: Mapping[int, SampledLine]  #: by dimension

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
        changed, center = self.changed(x), np.eye(len(self.x))[self.center]
        single, lines = np.tile(-center, (len(changed), 1)), []
        for row, i in zip(single, changed, strict=True):  # from the center to a place on its line
            weights, deviation = self.lines[i].weights(x[i])
            row[self.lines[i].designs] += weights
            lines.append((self.lines[i], deviation))
        distances = np.abs(x - self.x[self.center])[changed]
        return SurrogateWeights(center + single.sum(axis=0), lines, single, distances)


def stencils(x: Floats) -> Iterator[CutStencil]:
    """Yield the stencil about each sampled design, of scaled dimensions (n_designs, n)."""
    for center in range(len(x)):
        other = np.abs(x - x[center]) > SAME
        count, lines = other.sum(axis=1), dict[int, SampledLine]()
        for i in np.flatnonzero(other[count == 1].any(axis=0)).tolist():
            on = np.flatnonzero((count == 0) | ((count == 1) & other[:, i]))
            if len(on) > 2:
                lines[i] = SampledLine(on, x[on, i])
        yield CutStencil(center, x, lines)
