"""Life over a duty against hand calculations and published points."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fea.base.choices import Fatigue, Finish, Loading
from fea.base.material import Basquin, Material
from fea.judge.fatigue import SHORT, LifeLine, fatigue_factor, reversed_amplitude
from fea.judge.history import rainflow
from fea.study.material_table import MaterialTable, fitted
from geometry.errors import InvalidValue

FORGED = MaterialTable(preset="forged-steel-2005").material()
ALUMINIUM = Material(
    71.7e3, 0.33, 2.81e-9, 503.0, 572.0, endurance_limit=159.0, basquin=Basquin(1466.0, -0.143)
)
STRESS = st.floats(1.0, 1500.0)


def line(material=FORGED, surface=1.0):
    return LifeLine.of(material, np.atleast_1d(surface))


def damage(of, amplitudes, rates):
    return of.damage(np.array(amplitudes, float)[:, None], np.array(rates, float))[:, 0]


@pytest.mark.parametrize(("preset", "limit"), [("forged-steel-2005", 423.0), ("c70-2005", 339.0)])
def test_published_line_meets_the_published_limit_at_a_million_cycles(preset, limit):
    # Shenoy & Fatemi, SAE 2005-01-0987: σ_f′ and b, and the fatigue strength at 10⁶ cycles, printed apart.
    material = MaterialTable(preset=preset).material()
    assert material.basquin.amplitude(1e6) == pytest.approx(limit, rel=2e-3)
    assert line(material).knee == pytest.approx(1e6, rel=0.03)


@pytest.mark.parametrize("cycles", [2e3, 1e4, 1e5, 9e5])
def test_a_polished_part_follows_the_line_of_specimens(cycles):
    amplitude = np.array([FORGED.basquin.amplitude(cycles)])
    assert line().cycles(amplitude) == pytest.approx(cycles, rel=1e-9)


def test_factors_of_the_surface_lower_the_knee_and_not_the_thousand_cycles():
    # By hand: 1188·2000^−0.0711 = 692.1 MPa at 10³; 0.5·423 at 1.0154·10⁶; half-way on log paper at 10^4.503.
    half = line(surface=0.5)
    short = 1188 * 2000**-0.0711
    assert half.cycles(np.array([short])) == pytest.approx(SHORT, rel=1e-6)
    assert half.cycles(np.array([211.5 * (1 + 1e-12)])) == pytest.approx(half.knee, rel=1e-6)
    between = half.cycles(np.array([math.sqrt(short * 211.5)]))
    assert between == pytest.approx(math.sqrt(SHORT * half.knee), rel=1e-9)


def test_reliability_and_loading_lower_the_whole_line():
    table = MaterialTable(preset="forged-steel-2005", reliability_percent=99.0, loading=Loading.AXIAL)
    marin = table.material().marin
    factor = marin.reliability * marin.load
    assert factor == pytest.approx(0.85 * (1 - 0.08 * 2.3263), rel=1e-4)
    amplitude = np.array([300.0, 500.0, 650.0])
    np.testing.assert_allclose(
        line(table.material()).cycles(factor * amplitude), line().cycles(amplitude), rtol=1e-9
    )


def test_miner_by_hand():
    # 10⁴ cycles at the amplitude of 5·10⁴, and 10⁵ at that of 4·10⁵: 0.2 + 0.25.
    amplitudes = [FORGED.basquin.amplitude(5e4), FORGED.basquin.amplitude(4e5)]
    found = damage(line(), amplitudes, [1e4, 1e5])
    np.testing.assert_allclose(found, [0.2, 0.25], rtol=1e-9)


def test_below_the_limit_steel_lasts_and_once_damaged_follows_haibach():
    small = 0.8 * 423.0
    assert damage(line(), [small, 422.0], [1e6, 1e6]).sum() == 0
    # k = −1/b; N = N_e (S_e/σ)^(2k − 1).
    steepness = 2 / 0.0711 - 1
    together = damage(line(), [small, 500.0], [1e6, 1.0])
    assert together[0] == pytest.approx(1e6 / line().knee * 0.8**steepness, rel=1e-6)


def test_other_metals_have_no_endurance_limit():
    alone = damage(line(ALUMINIUM), [0.8 * 159.0], [1e6])
    assert alone[0] == pytest.approx(1e6 / line(ALUMINIUM).knee * 0.8 ** (2 / 0.143 - 1), rel=1e-6)


@given(STRESS, STRESS, STRESS, st.floats(0.3, 1.2), st.sampled_from([FORGED, ALUMINIUM]))
def test_more_stress_never_lengthens_life(one, other, more, surface, material):
    of = line(material, surface)
    before = damage(of, [one, other], [1e3, 1e4]).sum()
    assert damage(of, [one, other + more], [1e3, 1e4]).sum() >= before * (1 - 1e-12)
    assert damage(of, [one, other, more], [1e3, 1e4, 1e2]).sum() >= before * (1 - 1e-12)
    assert damage(of.stronger(0.84), [one, other], [1e3, 1e4]).sum() >= before * (1 - 1e-12)
    assert damage(line(material, 0.9 * surface), [one, other], [1e3, 1e4]).sum() >= before * (1 - 1e-12)


@given(st.floats(-1000, 900), st.floats(0.1, 900), st.floats(0.3, 1.2), st.sampled_from(list(Fatigue)))
def test_life_ends_where_the_safety_factor_is_below_one(mean, amplitude, surface, criterion):
    mean, amplitude = np.array([mean]), np.array([amplitude])
    factor = fatigue_factor(criterion, mean, amplitude, FORGED, np.array([surface]))[0]
    reversed_ = reversed_amplitude(criterion, mean, amplitude, FORGED)
    if abs(factor - 1) > 1e-9:
        assert (damage(line(surface=surface), reversed_, [1.0]).sum() > 0) == (factor < 1)


@pytest.mark.parametrize("surface", [0.3, 1.0, 1.2])
def test_the_line_falls_without_a_step(surface):
    amplitude = np.geomspace(50.0, 1100.0, 5000)
    fall = np.diff(np.log(line(surface=surface).cycles(amplitude))) / np.diff(np.log(amplitude))
    # No flatter than a rough surface makes it, no steeper than 2k − 1 of the steepest.
    assert (fall < -3).all()
    assert (fall > -80).all()


def test_goodmans_reversed_amplitude_by_hand():
    # σ_a = 300, σ_m = 200, S_u = 938, S_y = 700.
    mean, amplitude = np.array([200.0]), np.array([300.0])
    by_hand = {
        Fatigue.GOODMAN: 300 / (1 - 200 / 938),
        Fatigue.GERBER: 300 / (1 - (200 / 938) ** 2),
        Fatigue.SODERBERG: 300 / (1 - 200 / 700),
    }
    for criterion, expected in by_hand.items():
        assert reversed_amplitude(criterion, mean, amplitude, FORGED) == pytest.approx(expected)
    assert reversed_amplitude(Fatigue.GOODMAN, -mean, amplitude, FORGED) == amplitude
    assert np.isinf(reversed_amplitude(Fatigue.GOODMAN, np.array([938.0]), amplitude, FORGED))


def test_rainflow_of_the_example_of_astm_e1049():
    # ASTM E1049-85, figure 7: the repeating history counts ranges of 3, 4, 7 and 9.
    history = np.array([-2.0, 1, -3, 5, -1, 3, -4, 4])
    mean, amplitude = rainflow(history)
    assert sorted(2 * amplitude) == [3, 4, 7, 9]
    assert mean[np.argsort(amplitude)].tolist() == [-0.5, 1.0, 0.5, 0.5]


@given(st.lists(st.integers(-50, 50), min_size=1, max_size=40), st.integers(0, 39))
def test_rainflow_does_not_depend_on_where_a_period_begins(values, start):
    history = np.array(values, float)
    _, amplitude = rainflow(history)
    _, rolled = rainflow(np.roll(history, start))
    assert sorted(amplitude) == sorted(rolled)
    assert amplitude.max(initial=0) == np.ptp(history) / 2
    # Every turn is the end of one range: the ranges add up to the way there and back.
    way = np.abs(np.diff(np.append(history, history[0]))).sum()
    assert 4 * amplitude.sum() == pytest.approx(way)


def test_tests_of_specimens_give_their_line_back():
    true = Basquin(1188.0, -0.0711)
    cycles = (2e4, 1e5, 5e5)
    found = fitted(cycles, tuple(true.amplitude(n) for n in cycles))
    assert (found.coefficient, found.exponent) == pytest.approx((true.coefficient, true.exponent))
    table = MaterialTable(
        preset="forged-steel-2005", sn_cycles=cycles, sn_amplitude_MPa=(600.0, 500.0, 450.0)
    )
    assert table.material().basquin != FORGED.basquin


@pytest.mark.parametrize(
    ("keys", "named"),
    [
        ({"fatigue_strength_coefficient_MPa": 1188.0}, "fatigue_strength_exponent"),
        ({"fatigue_strength_coefficient_MPa": 1188.0, "fatigue_strength_exponent": 0.07}, "exponent"),
        ({"fatigue_strength_coefficient_MPa": -1.0, "fatigue_strength_exponent": -0.07}, "coefficient"),
        ({"sn_cycles": (1e4, 1e5)}, "sn_amplitude_MPa"),
        ({"sn_cycles": (1e4, 1e5), "sn_amplitude_MPa": (500.0,)}, "sn_amplitude_MPa"),
        ({"sn_cycles": (1e4, 1e5), "sn_amplitude_MPa": (500.0, 500.0)}, "sn_amplitude_MPa"),
        ({"sn_cycles": (1e4, 1e5), "sn_amplitude_MPa": (400.0, 500.0)}, "sn_cycles.* must fall"),
        ({"sn_cycles": (1e4, 1e4), "sn_amplitude_MPa": (400.0, 500.0)}, "sn_cycles.* must fall"),
        ({"sn_cycles": (1e4, 1e5), "sn_amplitude_MPa": (500.0, 499.0)}, "sn_cycles"),
        (
            {
                "fatigue_strength_coefficient_MPa": 1188.0,
                "fatigue_strength_exponent": -0.07,
                "sn_cycles": (1e4, 1e5),
                "sn_amplitude_MPa": (500.0, 450.0),
            },
            "sn_cycles",
        ),
    ],
)
def test_lines_that_are_none_are_refused(keys, named):
    with pytest.raises(InvalidValue, match=named):
        MaterialTable(preset="leon-2001", **keys).material()


def test_limits_that_do_not_fit_the_line_are_refused():
    with pytest.raises(InvalidValue, match="endurance_MPa"):
        line(replace(FORGED, endurance_limit=700.0))
    with pytest.raises(InvalidValue, match="surface"):
        line(surface=1.7)
    peened = MaterialTable(preset="forged-steel-2005", surface=Finish.SHOT_PEENED).material()
    assert line(peened, peened.marin.rest.factor) is not None
    assert LifeLine.of(replace(FORGED, basquin=None)) is None
