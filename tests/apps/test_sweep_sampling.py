import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fea.apps.sweep.sampling import Choice, Distribution, Sampling, Span, designs, saltelli, unit_designs

SPANS = st.builds(
    lambda low, width, shape, share, deviation: Span(
        low, low + width, shape, mean=low + share * width, deviation=deviation, mode=low + share * width
    ),
    st.floats(0.1, 100), st.floats(0.01, 100), st.sampled_from(Distribution), st.floats(0, 1),
    st.floats(0.05, 50),
)  # fmt: skip


@settings(max_examples=40, deadline=None)
@given(SPANS, st.floats(0, 1), st.floats(0, 1))
def test_quantiles_rise_within_the_bounds(span, one, other):
    low, high = sorted((one, other))
    slack = 1e-9 * span.high
    first, last = span.at([low, high])
    assert span.low - slack <= first <= last + slack <= span.high + 2 * slack


def test_a_normal_distribution_has_its_moments():
    span = Span(0.0, 10.0, Distribution.NORMAL, mean=5.0, deviation=1.0)  # cut at five deviations
    values = np.array(span.at((np.arange(4000) + 0.5) / 4000))
    assert values.mean() == pytest.approx(5, abs=1e-6)
    assert values.std() == pytest.approx(1, rel=2e-3)  # the outer cells' width


@settings(max_examples=30, deadline=None)
@given(st.sampled_from(Sampling), st.integers(1, 4), st.integers(1, 20), st.integers(0, 99))
def test_the_same_seed_gives_the_same_designs(sampling, dimensions, count, seed):
    varied = {f"key{k}": Choice((1, 2, 3)) if k == 2 else Span(1, 2, steps=3) for k in range(dimensions)}
    first, again = (designs(varied, sampling, count, seed) for _ in range(2))
    assert first == again
    expected = {Sampling.GRID: 3**dimensions, Sampling.SALTELLI: count * (dimensions + 2)}
    assert len(first) == expected.get(sampling, count)


def test_a_longer_sobol_sequence_continues_a_shorter_one():
    short, long = (unit_designs(Sampling.SOBOL, 3, count, 7) for count in (8, 20))
    np.testing.assert_array_equal(long[:8], short)


def test_a_latin_hypercube_has_one_design_in_each_stratum():
    found = unit_designs(Sampling.LATIN, 3, 25, 1)
    assert all(sorted((25 * column).astype(int)) == list(range(25)) for column in found.T)


def test_saltelli_has_the_order_of_salib():
    first, second = np.array([[1, 2, 3], [4, 5, 6]]), np.array([[-1, -2, -3], [-4, -5, -6]])
    expected = [[1, 2, 3], [-1, 2, 3], [1, -2, 3], [1, 2, -3], [-1, -2, -3]]
    np.testing.assert_array_equal(saltelli(first, second)[:5], expected)
    assert len(saltelli(first, second)) == 10
