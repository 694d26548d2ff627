"""A safety factor with its interval: what is printed of it never contradicts what it decides."""

import pickle
import re
from copy import copy
from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fea.judge.safety_factor import SafetyFactor, SurvivalAnswer, interval, printed

FACTORS = st.floats(0.005, 50)
BARS = st.floats(0.01, 90)


def ends(factor):
    """The ends of a printed interval, as a reader takes them."""
    number, text = float(printed(factor)), interval(factor)
    if text.startswith("±"):
        return number - float(text[2:]), number + float(text[2:])
    low, high = text.strip("()").split(" … ")
    return float(low), float(high)


def test_a_factor_less_its_bar_is_that_of_a_stress_higher_by_its_bar():
    factor = SafetyFactor.of_stress(1.1, 10.0)
    assert factor.low == pytest.approx(1.0)
    assert factor.high == pytest.approx(1.1 / 0.9)
    assert factor.percent == pytest.approx(10.0)
    assert SafetyFactor.of_stress(0.5, 120.0).high == inf
    assert SafetyFactor.of_stress(0.5, None).percent is None


@pytest.mark.parametrize(
    ("factor", "text"),
    [
        (SafetyFactor.of_stress(1.239, 23.7), "1.24 (1.00 … 1.62)"),
        (SafetyFactor.of_stress(0.8532, 1.9, instant="tension"), "0.85 ± 0.02 (tension)"),
        (SafetyFactor(1.24, 1.002, 1.614, instant="gas", place="edge B"), "1.24 (1.00 … 1.61; gas, edge B)"),
        (SafetyFactor(1.0, 0.9, inf), "1.00 (0.90 … ∞)"),
        (SafetyFactor(0.00331, 0.00321, 0.00341), "0.0033 ± 0.0001"),
        (SafetyFactor(2.0), "2.00"),
        (SafetyFactor(inf), "∞"),
    ],
)
def test_how_it_is_printed(factor, text):
    assert factor.text == text


def unit(factor):
    """The last digit that is printed."""
    return 10.0 ** -len(re.fullmatch(r"\d+\.(\d+)", printed(factor))[1])


@given(FACTORS, BARS)
def test_the_printed_interval_is_the_exact_one_to_its_last_digit(value, percent):
    factor = SafetyFactor.of_stress(value, percent)
    within = 1.51 if interval(factor).startswith("±") else 0.51  # the number beside a ± is rounded, too
    assert ends(factor) == pytest.approx((factor.low, factor.high), rel=0, abs=within * unit(factor))


@given(st.floats(0.5, 2), BARS)
def test_what_is_printed_does_not_promise_more_than_the_answer(value, percent):
    factor = SafetyFactor.of_stress(value, percent)
    low, high = ends(factor)
    answer, rounding = factor.answer(1.0), 1.51 * unit(factor)
    if answer is SurvivalAnswer.UNDECIDED:
        assert low - rounding <= 1 <= high + rounding
    elif answer is SurvivalAnswer.SURVIVES:
        assert low >= 1 - rounding
    else:
        assert high <= 1 + rounding


@given(FACTORS, BARS)
def test_plus_minus_stands_for_symmetric_intervals_alone(value, percent):
    factor = SafetyFactor.of_stress(value, percent)
    if interval(factor).startswith("±"):
        assert abs((factor.high - factor) - (factor - factor.low)) < 2 * unit(factor)


def test_copies_keep_what_is_known():
    factor = SafetyFactor(1.5, 1.2, 1.7, mode="fatigue", instant="tension", place="web")
    for other in (copy(factor), pickle.loads(pickle.dumps(factor))):  # noqa: S301 - its own
        assert (other, other.text, other.mode) == (1.5, factor.text, "fatigue")
