"""Pareto front, times at equal error, and the advice drawn from them."""

import math

import pytest

from fea.verify.computations import Computation, ConvergenceRow
from fea.verify.converge import (
    advice,
    equal_error,
    fastest_within,
    pareto,
    seconds_to,
    settled,
)


def row(seconds, error, tool="fea", element="p2", size=1.0):
    computation = Computation(tool, element, "rod", size)
    return ConvergenceRow(computation, size, 3000, seconds, 100.0, 700.0, error_percent=error)


def test_the_front_has_what_nothing_beats():
    cheap, better, worse, best = row(1, -9.0), row(2, 3.0), row(3, 4.0), row(5, -0.5)
    assert pareto([best, worse, better, cheap]) == [cheap, better, best]
    assert pareto([row(1, 0.02), row(2, 0.01)]) == [row(1, 0.02)]  # both below the floor


def test_a_coarse_mesh_that_happens_to_be_right_does_not_count():
    lucky, bad, good = row(1, 0.1, size=4.0), row(2, 5.0, size=2.0), row(4, 0.5, size=1.0)
    assert fastest_within([lucky, bad, good], 1.0) == {("fea", "p2"): good}


def test_a_tolerance_is_advised_with_its_figure():
    adaptive = [row(1, 4.0, tool="fea --tolerance", size=10.0), row(2, 0.5, tool="fea --tolerance", size=3.0)]
    assert "use `fea --tolerance 3` with P2" in advice(adaptive)[2]


def test_the_advice_is_three_sentences_on_what_was_measured():
    rows = [row(1, 4.0, size=2.0), row(3, 0.5), row(50, 1.5, tool="CalculiX"), row(9, 20.0, element="p1")]
    five, two, one = advice(rows)
    assert "within 5 %, confirmed by all finer meshes, use `fea` with P2 elements: 1.0 s" in five
    assert "within 2 %, the finest mesh of the comparison, use `fea` with P2 elements: 3.0 s" in two
    assert "CalculiX takes" in two
    assert "CalculiX did not reach this" in one
    assert all("No first-order mesh" in line for line in (five, two, one))


def test_what_the_reference_does_not_tell_is_not_advised():
    assert "reference is not accurate enough" in advice([row(1, 0.1)], floor=1.5)[2]


def test_the_error_of_a_mesh_is_the_worst_of_it_and_all_finer_ones():
    rows = [row(1, -9.0, size=8.0), row(2, 0.0, size=4.0), row(4, 3.0, size=2.0), row(8, 1.0)]
    assert settled(rows) == [9.0, 3.0, 3.0, 1.0]
    assert settled(rows[:2]) == [9.0, pytest.approx(9 / 2**4)]  # no better than twice the rate of P2
    assert settled([row(1, 0.01)]) == [0.05]


def test_times_are_interpolated_by_their_logarithms():
    rows = [row(10.0**k, 10.0 ** (1 - k), size=4.0**-k) for k in range(3)]  # error = 10 / seconds
    assert seconds_to(rows, 2.0) == pytest.approx(5.0)
    assert seconds_to(rows, 20.0) == 1.0
    assert seconds_to(rows, 0.05) == math.inf


def test_ours_is_held_against_calculix_at_equal_error():
    ours = [row(10.0**k / 20, 10.0 ** (1 - k), size=4.0**-k) for k in range(4)]
    theirs = [row(10.0**k, 10.0 ** (1 - k), "CalculiX", size=4.0**-k) for k in range(2)]
    five, two, one = equal_error(ours + theirs)
    assert (five.ratio, two.ratio) == (pytest.approx(20), pytest.approx(20))
    assert five.goal_met
    assert five.whole == math.inf
    assert one.theirs == pytest.approx(10)
    (within,) = (found for found in equal_error([*ours, *theirs[:1]]) if found.percent == 1)
    assert within.theirs == math.inf
    assert within.ratio == pytest.approx(2)  # at least: its only mesh took 1 s, ours 0.5 s
    assert not within.goal_met
    assert equal_error(ours) == []
