"""The verdict of a run: the error bar is taken off the safety factor before it is compared."""

from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st
from written_figures import buckling, cycle, result

from fea.analysis.survival import Answer, Factor, factors, survival


def tension(value, error_percent=2.0):
    return Factor("yielding", "tension", value, error_percent)


def test_a_factor_less_its_bar_is_that_of_a_stress_higher_by_its_bar():
    factor = tension(1.1, 10.0)
    assert factor.low == pytest.approx(1.0)
    assert factor.high == pytest.approx(1.1 / 0.9)
    assert tension(0.5, 120.0).high == inf
    assert (Factor("fatigue", "", 2.0).low, Factor("fatigue", "", 2.0).high) == (2.0, 2.0)


@pytest.mark.parametrize(
    ("found", "required", "answer", "text"),
    [
        ([tension(0.86)], None, "fails", "yields, safety factor 0.86 ± 0.02 (tension)"),
        (
            [tension(1.99), Factor("buckling", "", 3.0)],
            None,
            "survives",
            "survives, safety factor 1.99 ± 0.04 (tension)",
        ),
        (
            [tension(3.3, 1.0), Factor("yielding", "gas", 4.11, 26.3, "edge B")],
            None,
            "survives",
            (
                "survives, safety factor 3.30 ± 0.03 (tension); "
                "4.11 ± 1.16 (gas, edge B) could be as low as 3.25"
            ),
        ),
        (
            [tension(1.04, 8.0)],
            None,
            "undecided",
            "undecided, safety factor 1.04 ± 0.08 (tension) includes 1; --tolerance 3.6 would decide",
        ),
        (
            [tension(1.002)],
            None,
            "undecided",
            (
                "undecided, safety factor 1.00 ± 0.02 (tension) includes 1; "
                "the factor is within 0.5 % of it, within the mesh's accuracy"
            ),
        ),
        (
            [tension(0.86), tension(0.7), Factor("fatigue", "", 0.54), Factor("buckling", "", 0.9)],
            None,
            "fails",
            (
                "yields, safety factor 0.70 ± 0.01 (tension); fails by fatigue, safety factor 0.54; "
                "buckles, safety factor 0.90"
            ),
        ),
        (
            [tension(1.99)],
            2.5,
            "fails",
            "below the required safety factor of 2.5: 1.99 ± 0.04 (tension) against yielding",
        ),
        (
            [tension(1.99)],
            1.5,
            "survives",
            "meets the required safety factor of 1.5: 1.99 ± 0.04 (tension)",
        ),
        ([tension(1.0, 0.0)], None, "survives", "survives, safety factor 1.00 ± 0.01 (tension)"),
        ([tension(0.00331, 3.0)], None, "fails", "yields, safety factor 0.0033 ± 0.0001 (tension)"),
        (
            [Factor("buckling", "", 1.5)],
            None,
            "survives",
            "survives, safety factor 1.50 against buckling",
        ),
        ([tension(inf)], None, "survives", "survives, safety factor inf (tension)"),
    ],
)
def test_verdict_in_a_line(found, required, answer, text):
    verdict = survival(found, required)
    assert verdict.answer == answer
    assert verdict.text == text


def test_a_rod_that_the_cycle_fails_does_not_just_survive():
    found, over_the_cycle = [tension(1.99)], Factor("fatigue", "", 0.87, 5.0, "shank")
    verdict = survival(found, unjudged=over_the_cycle)
    assert verdict.text.endswith("but not the cycle: at most 0.87 against fatigue (--cycle)")
    assert (verdict.fatigue_at_most, verdict.fatigue_where) == (0.87, "shank")
    undecided = Factor("fatigue", "", 0.97, 5.0, "shank")
    assert survival(found, unjudged=undecided).text == survival(found).text


@given(st.floats(0.05, 20), st.floats(0, 40), st.floats(0.5, 3))
def test_the_tolerance_it_names_decides(value, bar, required):
    verdict = survival([tension(value, bar)], required)
    if verdict.answer != Answer.UNDECIDED or "--tolerance" not in verdict.text:
        return
    named = float(verdict.text.split("--tolerance ")[1].split()[0])
    assert named < bar
    assert survival([tension(value, named)], required).answer != Answer.UNDECIDED


def test_every_factor_of_a_run_is_judged():
    cases = {"tension": result(min_safety_factor=2.0, error_percent=3.0)}
    assert survival(factors(cases, buckling(), None)).mode == "yielding"
    assert survival(factors(cases, buckling(1.5, 3.0), None)).mode == "buckling"
    assert [
        (item.mode, item.error_percent)
        for item in factors(
            cases, buckling(), cycle(min_fatigue_safety_factor=0.9, fatigue_error_percent=4.0)
        )
    ] == [
        ("yielding", 3.0),
        ("yielding", 3.0),
        ("fatigue", 4.0),
    ]
