"""Weights of sampled designs between which a known function is interpolated."""

from itertools import combinations

import numpy as np
import pytest

from fea.apps.studio.surrogate import stencils

LINE = (-1.0, -0.7, 0.0, 0.7, 1.0)
CENTER = (0.2, -0.1, 0.3)


def stencil_of(corners=()):
    """The stencil at a place with a line along each of three dimensions, and some corners at ends."""
    places = [np.array(CENTER)]
    for i in range(3):
        places += [places[0] + step * np.eye(3)[i] for step in LINE if step]
    places += [places[0] + np.eye(3)[i] - np.eye(3)[j] for i, j in corners]
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


def test_a_sum_of_powers_is_exact_on_lines_and_products_with_corners():
    stencil, x = stencil_of(combinations(range(3), 2))
    assert sorted(stencil.lines) == [0, 1, 2]
    random = np.random.default_rng(1)
    for at in stencil.x[0] + random.uniform(-0.9, 0.9, (20, 3)):
        weights = stencil.at(at).weights
        assert weights.sum() == pytest.approx(1)
        linear_and_products = x @ [2.0, -1.0, 3.0] + 4 * x[:, 0] * x[:, 1] - x[:, 1] * x[:, 2]
        exact = at @ [2.0, -1.0, 3.0] + 4 * at[0] * at[1] - at[1] * at[2]
        assert weights @ linear_and_products == pytest.approx(exact, abs=1e-6)
        assert weights @ x[:, 0] ** 2 == pytest.approx(at[0] ** 2, abs=2e-3)


def test_the_estimate_bounds_the_error_and_shrinks_where_two_dimensions_are_measured():
    bare, x = stencil_of()
    stencil, more = stencil_of(combinations(range(3), 2))
    random = np.random.default_rng(2)
    errors, fewer = [], []
    for at in stencil.x[0] + random.uniform(-0.67, 0.67, (60, 3)):
        (rough, wide), (fine, narrow) = found(bare, x, at), found(stencil, more, at)
        assert rough <= wide
        assert fine <= narrow < wide
        errors.append(rough)
        fewer.append(fine)
    assert np.median(fewer) < 0.3 * np.median(errors)


def test_nothing_is_extrapolated():
    stencil, _ = stencil_of()
    center = stencil.x[0]
    assert stencil.covers(center + np.array([1.0, -1.0, 0.5]))
    assert not stencil.covers(center + np.array([1.01, 0.0, 0.0]))
    other = next(each for each in stencils(stencil.x) if each.center == 1)
    assert sorted(other.lines) == [0]  # an end of the first line: no line along the others goes through it
    assert not other.covers(center + np.array([0.0, 0.5, 0.0]))
    assert stencil.at(center).lines == []
