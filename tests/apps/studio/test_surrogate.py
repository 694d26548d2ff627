"""Weights of sampled designs between which a known function is interpolated."""

import numpy as np
import pytest

from fea.apps.studio.sampled_designs import LARGEST_ERROR
from fea.apps.studio.surrogate import stencils

LINE = (-1.0, -0.7, 0.0, 0.7, 1.0)
CENTER = (0.2, -0.1, 0.3)


def stencil_of():
    """The stencil at a place with a line along each of three dimensions."""
    places = [np.array(CENTER)]
    for i in range(3):
        places += [places[0] + step * np.eye(3)[i] for step in LINE if step]
    x = np.array(places)
    return next(stencil for stencil in stencils(x) if stencil.center == 0), x


def stress(x):
    """Components (n, 5) of a tensor whose first is a product of powers of the dimensions."""
    a, b, c = np.moveaxis(1 + 0.15 * x, -1, 0)
    return np.stack([a**-2 / b * c, a / c, 0.5 * b, 0.1 * a * b, 0.2 * c**2], axis=-1)


def found(stencil, x, at):
    """Error of the interpolated length, and what it is estimated at."""
    surrogate, values = stencil.at(at), stress(x)
    mixed = surrogate.weights @ values
    length = np.linalg.norm(mixed)
    direction = mixed / length
    return abs(length / np.linalg.norm(stress(at)) - 1), surrogate.error(values / length, direction)


def test_a_sum_of_effects_of_one_dimension_each_is_exact():
    stencil, x = stencil_of()
    assert sorted(stencil.lines) == [0, 1, 2]
    random = np.random.default_rng(1)
    for at in stencil.x[0] + random.uniform(-0.9, 0.9, (20, 3)):
        weights = stencil.at(at).weights
        assert weights.sum() == pytest.approx(1)
        assert weights @ (x @ [2.0, -1.0, 3.0]) == pytest.approx(at @ [2.0, -1.0, 3.0], abs=1e-6)
        assert weights @ (x**2).sum(axis=1) == pytest.approx((at**2).sum(), abs=6e-3)


def test_the_estimate_bounds_the_error():
    stencil, x = stencil_of()
    places = stencil.x[0] + np.random.default_rng(2).uniform(-0.67, 0.67, (60, 3))
    error, estimate = np.array([found(stencil, x, at) for at in places]).T
    assert (error <= estimate).all()
    assert np.median(estimate) < LARGEST_ERROR  # so that it is shown


def test_nothing_is_extrapolated():
    stencil, _ = stencil_of()
    center = stencil.x[0]
    assert stencil.covers(center + np.array([1.0, -1.0, 0.5]))
    assert not stencil.covers(center + np.array([1.01, 0.0, 0.0]))
    other = next(each for each in stencils(stencil.x) if each.center == 1)
    assert sorted(other.lines) == [0]  # an end of the first line: no line along the others goes through it
    assert not other.covers(center + np.array([0.0, 0.5, 0.0]))
    assert stencil.at(center).lines == []
