"""The verdict of a run: the error bar is taken off the safety factor before it is compared."""

from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st
from written_figures import buckling, cycle, result

from fea.analysis.survival import factors, survival
from fea.judge.safety_factor import SafetyFactor, SurvivalAnswer


def tension(value, error_percent=2.0):
    return SafetyFactor.of_stress(value, error_percent, instant="tension")


def fatigue(value, error_percent=None, place=""):
    return SafetyFactor.of_stress(value, error_percent, mode="fatigue", place=place)


def buckles(value):
    return SafetyFactor(value, mode="buckling")


SOUND = fatigue(9.0)


def flows(value, mode):
    return SafetyFactor(value, mode=mode, instant="tension", place="shank")


@pytest.mark.parametrize(
    ("found", "judged", "answer", "text"),
    [
        (
            flows(1.3, "lasting flow"),
            True,
            "survives",
            "survives, safety factor 1.30 (tension, shank) against lasting flow",
        ),
        (
            flows(1.3, "lasting flow"),
            False,
            "shakes down",
            "shakes down, safety factor 1.30 (tension, shank) against lasting flow; fatigue is not judged",
        ),
        (
            flows(0.7, "cyclic plasticity"),
            True,
            "fails",
            "flows to and fro in every turn, safety factor 0.70 (tension, shank)",
        ),
        (
            flows(0.9, "plastic collapse"),
            True,
            "fails",
            "collapses plastically, safety factor 0.90 (tension, shank)",
        ),
    ],
)
def test_what_flow_leads_to_takes_the_place_of_first_yield(found, judged, answer, text):
    verdict = survival([found, *([SOUND] if judged else [])])
    assert verdict.answer == answer
    assert verdict.text == text


@pytest.mark.parametrize(
    ("found", "required", "answer", "text"),
    [
        ([tension(0.86), SOUND], None, "fails", "yields, safety factor 0.86 ± 0.02 (tension)"),
        (
            [tension(1.99), buckles(3.0), SOUND],
            None,
            "survives",
            "survives, safety factor 1.99 ± 0.04 (tension)",
        ),
        (
            [tension(1.99)],
            None,
            "does not yield",
            "does not yield, safety factor 1.99 ± 0.04 (tension); fatigue is not judged",
        ),
        (
            [tension(3.3, 1.0), SafetyFactor.of_stress(4.11, 26.3, instant="gas", place="edge B"), SOUND],
            None,
            "survives",
            (
                "survives, safety factor 3.30 ± 0.03 (tension); "
                "4.11 (3.25 … 5.58; gas, edge B) could be as low as 3.25"
            ),
        ),
        (
            [tension(1.04, 8.0), SOUND],
            None,
            "undecided",
            "undecided, safety factor 1.04 (0.96 … 1.13; tension) includes 1; --tolerance 3.6 would decide",
        ),
        (
            [tension(1.002), SOUND],
            None,
            "undecided",
            (
                "undecided, safety factor 1.00 ± 0.02 (tension) includes 1; "
                "the factor is within 0.5 % of it, within the mesh's accuracy"
            ),
        ),
        (
            [tension(0.86), tension(0.7), fatigue(0.54), buckles(0.9)],
            None,
            "fails",
            (
                "fails by fatigue, safety factor 0.54; yields, safety factor 0.70 ± 0.01 (tension); "
                "buckles, safety factor 0.90"
            ),
        ),
        (
            [tension(1.99), SOUND],
            2.5,
            "fails",
            "below the required safety factor of 2.5: 1.99 ± 0.04 (tension) against yielding",
        ),
        (
            [tension(1.99), SOUND],
            1.5,
            "survives",
            "meets the required safety factor of 1.5: 1.99 ± 0.04 (tension)",
        ),
        (
            [tension(1.0, 0.0), SOUND],
            None,
            "survives",
            "survives, without reserve against 10 % over-rev; safety factor 1.00 (tension)",
        ),
        (
            [SafetyFactor.of_stress(1.16, 2.0, instant="gas"), SOUND],
            None,
            "survives",
            (
                "survives, without reserve against single cycles of 15 % more pressure; "
                "safety factor 1.16 ± 0.02 (gas)"
            ),
        ),
        ([buckles(1.18), SOUND], None, "survives", "survives, safety factor 1.18 against buckling"),
        ([tension(0.00331, 3.0), SOUND], None, "fails", "yields, safety factor 0.0033 ± 0.0001 (tension)"),
        ([buckles(1.5), SOUND], None, "survives", "survives, safety factor 1.50 against buckling"),
        ([tension(inf), SOUND], None, "survives", "survives, safety factor 9.00 against fatigue"),
    ],
)
def test_verdict_in_a_line(found, required, answer, text):
    verdict = survival(found, required)
    assert verdict.answer == answer
    assert verdict.text == text


def test_what_survives_says_what_it_stands_on_and_what_ends_it():
    verdict = survival([tension(1.5), fatigue(1.3)], stands_on="6000 rpm")
    assert (verdict.stands_on, verdict.ends_at_load) == ("6000 rpm", 1.3)
    assert survival([tension(1.5), fatigue(1.3)], 1.25).ends_at_load == pytest.approx(1.04)
    for others in ([tension(1.5)], [tension(0.5), fatigue(1.3)]):
        verdict = survival(others, stands_on="6000 rpm")
        assert (verdict.stands_on, verdict.ends_at_load) == (None, None)


def test_a_bound_that_fails_decides_and_stands_first():
    verdict = survival([tension(1.99)], fatigue_at_most=fatigue(0.87, 5.0, "shank"))
    assert verdict.text == "fails by fatigue, safety factor at most 0.87 (0.83 … 0.92; shank)"
    assert (verdict.answer, verdict.mode, verdict.safety_factor) == ("fails", "fatigue", 0.87)
    assert (verdict.fatigue_at_most, verdict.fatigue_where) == (0.87, "shank")


def test_a_bound_beside_a_smaller_factor_stands_behind_it():
    verdict = survival([tension(0.5)], 1.5, fatigue_at_most=fatigue(0.87, 5.0, "shank"))
    first, second = (
        "0.50 ± 0.01 (tension) against yielding",
        "at most 0.87 (0.83 … 0.92; shank) against fatigue",
    )
    assert verdict.text == f"below the required safety factor of 1.5: {first}, {second}"


@pytest.mark.parametrize("bound", [0.97, 1.4])
def test_a_bound_that_does_not_fail_is_no_judgement(bound):
    verdict = survival([tension(1.99)], fatigue_at_most=fatigue(bound, 5.0, "shank"))
    assert verdict.answer == SurvivalAnswer.NOT_JUDGED
    assert verdict.text.endswith(f"fatigue is not judged, its factor is at most {bound:.2f} (--cycle)")


@given(st.floats(0.05, 20), st.floats(0, 40), st.floats(0.5, 3))
def test_the_tolerance_it_names_decides(value, bar, required):
    verdict = survival([tension(value, bar), fatigue(99.0)], required)
    if verdict.answer != SurvivalAnswer.UNDECIDED or "--tolerance" not in verdict.text:
        return
    named = float(verdict.text.split("--tolerance ")[1].split()[0])
    assert named < bar
    assert survival([tension(value, named), fatigue(99.0)], required).answer != SurvivalAnswer.UNDECIDED


def test_every_factor_of_a_run_is_judged():
    cases = {"tension": result(min_safety_factor=2.0, error_percent=3.0)}
    assert survival(factors(cases, buckling(), None)).mode == "yielding"
    assert survival(factors(cases, buckling(1.5, 3.0), None)).mode == "buckling"
    assert [
        (item.mode, item.instant, round(float(item), 9), item.low)
        for item in factors(cases, buckling(), cycle(min_fatigue_safety_factor=SafetyFactor(0.9, 0.8, 1.1)))
    ] == [("yielding", "tension", 2.0, 2.0), ("yielding", "", 0.89, 0.89), ("fatigue", "", 0.9, 0.8)]
