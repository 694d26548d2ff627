"""Roots of costly functions: closed forms, and how often the function is evaluated."""

import math

import pytest

from fea.base.root import leap, root


def test_a_leap_towards_an_edge_is_short_where_the_level_is_flat():
    assert leap(100.0, -0.5, 0.1) == pytest.approx(100 * math.exp(0.05))
    assert leap(100.0, -1e9, 0.1) == pytest.approx(100 * math.exp(0.5))
    assert leap(100.0, 1e9, 0.1) == pytest.approx(100 * math.exp(-0.5))


@pytest.mark.parametrize(
    ("start", "slope", "expected"), [(1.5, -1.0, 10.0), (12.0, -1.0, 10.0), (6.0, 1.0, 1.0), (0.5, 1.0, 1.0)]
)
def test_an_edge_is_found_where_the_factor_first_rises_before_it_falls(start, slope, expected):
    """From a place on the wrong side of the largest factor the slope points away from the edge."""

    def level(x):
        return 0.4 * math.log(x) * (math.log(10) - math.log(x))

    edge = root(level, [start], slope, (0.2, 40.0), 1e-4)
    assert edge.x == pytest.approx(expected, rel=1e-3)
    assert edge.slope == pytest.approx(slope / (0.4 * math.log(10)), rel=0.2)
    assert root(lambda _at: 1.0, [start], slope, (0.2, 40.0)) is None


def test_a_bracket_is_enough_and_no_place_is_evaluated_twice():
    places = []

    def level(x):
        places.append(x)
        return math.log(0.3 + 7000.0**2 / x**2)

    edge = root(level, [5000.0, 9000.0], -0.5, (5000.0, 9000.0), 1e-6)
    assert edge.x == pytest.approx(7000 / math.sqrt(0.7), rel=1e-6)
    assert len(places) == len(set(places)) <= 7


@pytest.mark.parametrize("wide", [1.05, 1.2, 1.5])
def test_a_plateau_beside_the_root_is_crossed(wide):
    """The open share of a joint is counted in facets: one stays open over a range of speeds."""

    def level(x):
        beyond = x / 5000.0
        return 2.0 * -math.log(beyond) if beyond < 1 else min(-2.0 * math.log(beyond / wide), 0.0) - 0.007

    edge = root(level, [4990.0 * wide], -0.5, (1000.0, 20000.0), 3e-3)
    assert edge.x == pytest.approx(5000.0, rel=3e-3)
