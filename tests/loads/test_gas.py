import math

import numpy as np
import pytest
from engines import DEG, LEON, RPM

from geometry.errors import InvalidValue
from loads.engine import Engine
from loads.gas import ATMOSPHERE, Boyle, Compressor, NoGas, Otto, dead_centres, relative_volume
from loads.trace import Trace

DEGREES = np.arange(0, 720, 10.0)
HUMP = 6.0 * np.exp(-(((DEGREES - 370) / 40) ** 2))
ANY_SPEED = np.array([])


def trace(degrees=DEGREES, pressures=HUMP, speeds=ANY_SPEED):
    return Trace(np.asarray(degrees) * DEG, np.asarray(pressures), np.asarray(speeds) * RPM)


def test_a_trace_returns_its_samples_and_repeats_each_cycle():
    np.testing.assert_allclose(trace().pressure(DEGREES * DEG, np.array(1.0)), HUMP, rtol=1e-14)
    np.testing.assert_allclose(
        trace().pressure((DEGREES + 1440) * DEG, np.array(1.0)), HUMP, rtol=1e-9, atol=1e-12
    )


def test_a_trace_is_linear_across_the_end_of_the_cycle():
    t = trace(pressures=HUMP + np.where(DEGREES == 0, 0.4, 0))
    assert t.pressure(np.array(715 * DEG), np.array(1.0)) == pytest.approx(0.2, rel=1e-6)


def test_speed_is_linear_between_and_nearest_outside():
    t = trace(pressures=[HUMP, 2 * HUMP], speeds=[1000, 3000])
    at = np.array(370 * DEG)
    speeds = np.array([500, 1000, 1500, 3000, 9000.0]) * RPM
    np.testing.assert_allclose(t.pressure(at, speeds), 6.0 * np.array([1, 1, 1.25, 2, 2]), rtol=1e-13)
    assert "500 rpm" in t.note(500 * RPM)
    assert "nearest speed, 1000 rpm" in t.note(500 * RPM)
    assert "nearest speed, 3000 rpm" in t.note(9000 * RPM)
    assert t.note(1000 * RPM) == t.note(2000 * RPM) == t.note(3000 * RPM) == ""


def test_one_trace_for_all_speeds_flags_nothing():
    assert trace().note(123.0) == ""
    assert trace().pressure(DEGREES * DEG, np.ones((3, 1))).shape == (3, 72)


@pytest.mark.parametrize(
    ("degrees", "pressures", "match"),
    [
        ([0], [1], "1 sample'"),
        ([0, 10, 20], [1, 2], "2 pressures"),
        (DEGREES[::-1], HUMP, "must increase"),
        (np.where(DEGREES == 20, 10, DEGREES), HUMP, r"must increase .* follows 10"),
        (DEGREES - 360, HUMP, "within one cycle, 0 to 720°"),
        (DEGREES[:36], HUMP[:36] + 1, "370° are missing"),
        (DEGREES[:60], HUMP[:60], "130° are missing"),
        (DEGREES, HUMP * 1e5, "in Pa, convert them: the peak is then 60 bar"),
        (DEGREES, HUMP * 1e2, "in kPa, convert them: the peak is then 60 bar"),
        (DEGREES, HUMP * 14.50377, r"in psi, convert them: the peak is then 60(\.\d+)? bar"),
        (DEGREES, HUMP / 100, "peak must exceed 1 bar"),
        (DEGREES, HUMP - 1, "vacuum"),
        (DEGREES, np.where(DEGREES == 10, np.nan, HUMP), "finite"),
        ([*DEGREES, 720], [*HUMP, 3.0], "may differ by at most 5 % of the peak"),
    ],
)
def test_a_bad_trace_is_refused(degrees, pressures, match):
    with pytest.raises(InvalidValue, match=match):
        trace(degrees, pressures)


@pytest.mark.parametrize("speeds", [[3000, 1000], [0, 1000], [1000]])
def test_bad_speeds_of_a_trace_are_refused(speeds):
    with pytest.raises(InvalidValue):
        trace(pressures=[HUMP, HUMP], speeds=speeds)


def test_a_trace_that_nearly_closes_uses_its_first_value():
    t = trace([*DEGREES, 720], [*HUMP, 0.1])
    assert t.crank_angles.size == 72
    assert t.pressure(np.array(4 * np.pi), np.array(1.0)) == pytest.approx(HUMP[0])


def test_no_gas_is_zero_in_the_right_shape():
    assert NoGas().pressure(np.zeros(5), np.ones((2, 1))).shape == (2, 5)
    assert not NoGas().pressure(np.zeros(5), np.ones((2, 1))).any()


def test_boyle_keeps_pv_and_repeats_each_turn():
    boyle = Boyle(LEON, 9.0)
    p = boyle.pressure(np.array([0, math.pi, 2 * math.pi]), np.array(1.0))
    np.testing.assert_allclose(p, [8 * ATMOSPHERE, 0, 8 * ATMOSPHERE], atol=1e-15)


def test_otto_at_the_corners_of_its_diagram():
    # Heywood 1988, table 5.1: p₂ = p₁ r^γ, p₄ = p₃ r^−γ.
    otto = Otto(LEON, compression_ratio=10.0, peak=7.0, intake=0.09)
    corners = np.array([0.5, 1.0, 2.0 - 1e-12, 2.0, 3.0 - 1e-12, 3.5]) * math.pi
    absolute = otto.pressure(corners, np.array(1.0)) + ATMOSPHERE
    expected = [0.09, 0.09, 0.09 * 10**1.4, 7.0, 7.0 * 10**-1.4, ATMOSPHERE]
    np.testing.assert_allclose(absolute, expected, rtol=1e-9)


def test_otto_work_is_that_of_the_ideal_cycle():
    # W = (p₃ − p₂) V₂ (1 − r^(1−γ))/(γ − 1): heat times efficiency 1 − r^(1−γ), with intake at atmosphere.
    otto = Otto(LEON, compression_ratio=10.0, peak=7.0)
    theta = np.linspace(math.pi, 3 * math.pi, 40_001)
    volume = relative_volume(LEON, 10.0, theta) * LEON.piston_area * LEON.stroke / 9
    before = theta < 2 * math.pi
    p = otto.pressure(theta, np.array(1.0)) + ATMOSPHERE
    # The constant-volume jump does no work: integrate each side up to its own pressure at TDC.
    top = int(before.sum())
    up = np.trapezoid(np.r_[p[:top], otto.compressed], volume[: top + 1])
    work = up + np.trapezoid(p[top:], volume[top:])
    heat = (7.0 - otto.compressed) * volume[top] / 0.4
    assert work == pytest.approx(heat * (1 - 10**-0.4), rel=1e-6)


def test_the_work_of_a_compressor_is_that_of_its_ideal_diagram():
    """γ/(γ − 1) p₁ V₁ [(p₂/p₁)^((γ−1)/γ) − 1] with V₁ = V [1 − c ((p₂/p₁)^(1/γ) − 1)], c = 1/(r − 1)."""
    ratio, delivery, gamma = 21.0, 0.8, 1.3
    compressor = Compressor(LEON, ratio, delivery, heat_ratio=gamma)
    theta = np.linspace(0.0, 2 * math.pi, 100_001)
    swept = LEON.piston_area * LEON.stroke
    volume = relative_volume(LEON, ratio, theta) * swept / (ratio - 1)
    pressure = compressor.pressure(theta, np.array(1.0)) + ATMOSPHERE
    assert (pressure.min(), pressure.max()) == (pytest.approx(ATMOSPHERE), pytest.approx(delivery))
    np.testing.assert_allclose(
        compressor.pressure(theta + 2 * math.pi, np.array(1.0)), pressure - ATMOSPHERE, atol=1e-9
    )
    raised = delivery / ATMOSPHERE
    drawn = swept * (1 - (raised ** (1 / gamma) - 1) / (ratio - 1))
    expected = gamma / (gamma - 1) * ATMOSPHERE * drawn * (raised ** (1 - 1 / gamma) - 1)
    assert -np.trapezoid(pressure, volume) == pytest.approx(expected, rel=1e-5)
    with pytest.raises(InvalidValue, match="delivery_pressure_bar"):
        Compressor(LEON, 4.0, delivery, heat_ratio=gamma)


def test_motored_is_symmetric_about_tdc_and_does_no_work():
    motored = Otto(LEON, compression_ratio=10.0)
    before, after = (
        motored.pressure(2 * math.pi + s * np.linspace(0.01, 3, 50), np.array(1.0)) for s in (-1, 1)
    )
    np.testing.assert_allclose(before, after, rtol=1e-10, atol=1e-14)


def test_an_offset_pin_moves_the_strokes():
    engine = Engine(47.0, 141.0, 76.0, 1e-3, pin_offset=10.0)
    top, bottom = dead_centres(engine)
    motored = Otto(engine, compression_ratio=10.0)
    p = motored.pressure(np.array([2 * math.pi + top, bottom + 1e-9]), np.array(1.0)) + ATMOSPHERE
    np.testing.assert_allclose(p, [ATMOSPHERE * 10**1.4, ATMOSPHERE], rtol=1e-9)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Boyle(LEON, 1.0),
        lambda: Boyle(LEON, 9.0, atmosphere=0.0),
        lambda: Otto(LEON, 0.5, peak=7.0),
        lambda: Otto(LEON, 10.0, peak=1.0),
        lambda: Otto(LEON, 10.0, peak=700.0),
        lambda: Otto(LEON, 10.0, intake=-1.0),
        lambda: Otto(LEON, 10.0, heat_ratio=2.0),
        lambda: Otto(LEON, math.nan),
    ],
)
def test_an_impossible_ideal_cycle_is_refused(make):
    with pytest.raises(InvalidValue):
        make()


@pytest.mark.parametrize(
    "kilopascal", [lambda: Otto(LEON, 12.0, intake=10.0), lambda: Boyle(LEON, 10.0, 10.0)]
)
def test_what_no_engine_compresses_to_is_refused(kilopascal):
    with pytest.raises(InvalidValue, match=r"no engine exceeds 400 bar.*in bar absolute"):
        kilopascal()


def test_a_peak_of_an_idling_engine_is_remarked_on_as_it_may_be_in_megapascal():
    assert "if the file is in MPa" in trace(pressures=HUMP / 10).note(1.0)
    assert trace().note(1.0) == ""


def test_a_trace_that_counts_from_firing_is_remarked_on():
    turned = trace(pressures=np.roll(HUMP, 36))
    assert "peaks at 10°, but firing TDC is at 360°" in turned.note(1.0)
    twice = trace(pressures=np.maximum(HUMP, np.roll(HUMP, 36)))  # of two strokes
    assert twice.note(1.0) == ""
