"""Known indices and probabilities of a bar in tension: factor = yield · width · thickness / force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from fea.apps.sweep.journal import failures
from fea.apps.sweep.sampling import Distribution, Sampling, Span, designs
from fea.apps.sweep.statistics import Samples, below_one, pareto_front, sensitivities
from fea.apps.sweep.sweep_file import RowState, SweepRow

KEYS = {
    "material.yield_MPa": Span(300, 500),
    "rod.width_mm": Span(9, 11, Distribution.NORMAL, mean=10, deviation=0.25),
    "rod.thickness_mm": Span(4, 6, Distribution.TRIANGULAR, mode=5),
}


def bar(design):
    strength, width, thickness = design.values()
    return strength * width * thickness / 20_000.0


def swept(varied, sampling, count, factor, *, seed=1):
    entries = [
        SweepRow(
            n, n, one, 6000.0, RowState.DONE, "", {"factor": factor(one), "mass_kg": 1.0, "trusted": True}
        )
        for n, one in enumerate(designs(varied, sampling, count, seed))
    ]
    return Samples.of(entries)


def exact_indices():
    """Of a product of independent factors, with c = deviation / mean of each."""
    c2 = []
    for span in KEYS.values():
        values = np.array(span.at((np.arange(2000) + 0.5) / 2000))
        c2.append(values.var() / values.mean() ** 2)
    c2 = np.array(c2)
    variance = np.prod(1 + c2) - 1
    return c2 / variance, c2 * np.prod(1 + c2) / (1 + c2) / variance


def test_the_indices_of_a_bar_are_the_known_ones():
    found = sensitivities(swept(KEYS, Sampling.SALTELLI, 1024, bar), Sampling.SALTELLI)[0]
    first, total = exact_indices()
    by_key = {one.key: one for one in found.influences}
    for k, key in enumerate(KEYS):
        assert by_key[key].first == pytest.approx(first[k], abs=0.02)
        assert by_key[key].total == pytest.approx(total[k], abs=0.02)
        assert abs(by_key[key].total - total[k]) < 2 * by_key[key].total_bar
    assert [one.key for one in found.influences] == [
        "material.yield_MPa", "rod.thickness_mm", "rod.width_mm",
    ]  # fmt: skip


def test_first_indices_of_a_plain_sample():
    found = sensitivities(swept(KEYS, Sampling.SOBOL, 512, bar), Sampling.SOBOL)[0]
    first, _ = exact_indices()
    by_key = {one.key: one for one in found.influences}
    assert [by_key[key].first for key in KEYS] == pytest.approx(list(first), abs=0.04)
    # Of nearly linear problems the squares of the standardised coefficients are the indices as well.
    assert [by_key[key].regression ** 2 for key in KEYS] == pytest.approx(list(first), abs=0.04)
    assert found.linear_share > 0.98
    assert "saltelli" in found.without_total


def test_a_missing_rod_leaves_no_indices_of_saltelli():
    samples = swept(KEYS, Sampling.SALTELLI, 16, bar)
    samples.values["factor"][3] = np.nan
    found = sensitivities(samples, Sampling.SALTELLI)[0]
    assert found.influences[0].total is None
    assert found.without_total == "1 rods of Saltelli's designs have no result"


def linear(seed):
    """Strength less load, both normal: the probability is known."""
    varied = {
        "material.yield_MPa": Span(300, 700, Distribution.NORMAL, mean=500, deviation=30),
        "rod.width_mm": Span(0, 20, Distribution.NORMAL, mean=10, deviation=0.8),
    }
    samples = swept(varied, Sampling.RANDOM, 300, lambda one: 1 + (one["material.yield_MPa"]
                    - 46 * one["rod.width_mm"]) / 500, seed=seed)  # fmt: skip
    return below_one("factor", samples.values["factor"])


def test_the_probability_of_a_linear_problem_lies_in_its_interval():
    exact = stats.norm.cdf(-(500 - 460) / np.hypot(30, 46 * 0.8))
    inside = [one.low <= exact <= one.high for one in map(linear, range(20))]
    assert sum(inside) >= 18  # of 20 at 95 %: 19 are expected; two fail more often than once in ten


def test_rods_without_a_result_widen_the_interval():
    values = np.array([0.9] * 5 + [1.1] * 95)
    known, less = (
        below_one("factor", values),
        below_one("factor", np.where(np.arange(100) > 89, np.nan, values)),
    )
    assert (known.below, known.rods, known.missing) == (5, 100, 0)
    assert less.missing == 10
    assert less.low <= known.low <= known.high < less.high


@pytest.mark.parametrize(
    ("successes", "trials", "low", "high"),
    [(0, 10, 0.0, 0.30850), (10, 10, 0.69150, 1.0), (5, 20, 0.08657, 0.49105)],
)
def test_clopper_and_pearson(successes, trials, low, high):
    found = below_one("factor", np.array([0.5] * successes + [1.5] * (trials - successes)))
    assert (found.low, found.high) == pytest.approx((low, high), abs=2e-5)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.integers(1, 9), st.integers(1, 9)), max_size=30))
def test_no_rod_is_lighter_and_stronger_than_one_on_the_front(points):
    mass, factor = np.array(points, float).reshape(-1, 2).T
    front = pareto_front(mass, factor)
    beaten = [any((mass <= m) & (factor >= f) & ((mass < m) | (factor > f))) for m, f in points]
    assert {(mass[n], factor[n]) for n in front} == {
        point for point, worse in zip(points, beaten, strict=True) if not worse
    }
    assert np.all(np.diff(mass[front]) > 0)


def test_of_several_speeds_the_worst_counts_and_untrusted_rods_do_not():
    rows = [(0, 0, 1.2, True), (1, 0, 0.9, True), (2, 1, 1.5, True), (3, 1, 1.4, False)]
    samples = Samples.of(
        SweepRow(n, sample, {"rod.width_mm": sample}, n, RowState.DONE, "",
              {"factor": factor, "mass_kg": 1.0, "trusted": trusted})
        for n, sample, factor, trusted in rows
    )  # fmt: skip
    assert samples.values["factor"][0] == 0.9
    assert np.isnan(samples.values["factor"][1])
    assert samples.rows[0] == 1


def test_failures_that_differ_in_numbers_are_told_once():
    reasons = ["width = 4.5e-1: too small", "", "no mesh", "width = 0.3: too small"]
    entries = [
        SweepRow(n, n, {}, None, RowState.FAILED if reason else RowState.DONE, reason, {})
        for n, reason in enumerate(reasons)
    ]
    assert failures(entries) == [(0, "width = 4.5e-1: too small", 2), (2, "no mesh", 1)]
