"""Pressure traces as engineers have them: any convention reads back to the same pressures, or is refused."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from traces import ATMOSPHERE, BAR_IN, RATIO, absolute, drawn, gauge, judged, written

from fea.base.choices import PressureReference, PressureUnit
from fea.study.trace_columns import TraceKeys
from fea.study.trace_table import LARGEST_TRACE
from fea.study.traces import Surroundings, parse_trace, read_trace
from geometry.errors import InvalidValue
from loads.compression import compression, volume

DEGREES = np.arange(0.0, 720.0)
FROM_FIRING = np.arange(-360.0, 360.0)
ABSOLUTE = absolute(FROM_FIRING)


def bar(imported, degrees=DEGREES):
    """Gauge pressures, bar, with firing TDC at 360°."""
    return 10 * imported.trace.pressure(np.radians(degrees), np.array(1.0))


def text(pressures=ABSOLUTE, angles=FROM_FIRING, **form):
    return written(angles, pressures, **form)


FORMS = st.fixed_dictionaries(
    {
        "unit": st.sampled_from(sorted(BAR_IN)),
        "reference": st.sampled_from(["absolute", "gauge"]),
        "separator": st.sampled_from([",", ";", "\t", " ", " ; ", " \t,\t"]),
        "comma": st.booleans(),
        "newline": st.sampled_from(["\n", "\r\n", "\r"]),
        "names": st.sampled_from(
            [(), ("CA [deg]", "Pcyl [{}]"), ("crank_angle", "p_{}"), ("Winkel", "Druck/{}")]
        ),
        "first": st.sampled_from([-540.0, -360.0, -180.0, 0.0, 180.0]),
        "tdc": st.sampled_from([-360.0, -180.0, 0.0, 180.0, 360.0, 540.0]),
        "step": st.sampled_from([0.5, 2.5, 5.0]),
        "intake": st.floats(0.7, 1.1),  # throttled or boosted, 20 to 58 may be kPa or psi
    }
)


@settings(max_examples=60, deadline=None)
@given(FORMS)
def test_any_convention_reads_back(form):
    angles = np.arange(form["first"], form["first"] + 720, form["step"])
    shift = ATMOSPHERE * (form["reference"] == "gauge")
    pressures = (absolute(angles - form["tdc"], intake=form["intake"]) - shift) * BAR_IN[form["unit"]]
    file = written(
        angles,
        pressures,
        separator=form["separator"],
        comma=form["comma"] and "," not in form["separator"],
        header=[form["separator"].join(form["names"]).format(form["unit"])] if form["names"] else (),
        newline=form["newline"],
    )
    at = np.arange(0.0, 720.0, form["step"])
    found = parse_trace(file, "t.csv")
    np.testing.assert_allclose(bar(found, at), gauge(at, intake=form["intake"]), rtol=1e-6, atol=1e-6)
    # Read again by what was found out: the same pressures, and nothing assumed.
    again = parse_trace(file, "t.csv", found.keys)
    np.testing.assert_array_equal(again.trace.pressures, found.trace.pressures)
    assert [remark for remark in again.trace.remarks if "assuming" in remark] == []
    assert again.trace.doubts == found.trace.doubts == ()


def triggered(pulses):
    """A recording in volts over uneven times of an engine that slows down; a trigger rises at BDC + 20°."""
    angles = np.arange(-1000.0, 2500.0, 0.37)
    times = 12.0 + angles / 36000 + (angles / 36000) ** 2 * 0.4
    trigger = 5.0 * (np.mod(angles - 200.0, 360.0 / pulses) < 180.0 / pulses) + 0.01
    volts = absolute(angles) / 20.0 + 0.5
    rows = [f"{t:.9f},{v:.6f},{p:.2f}" for t, v, p in zip(times, volts, trigger, strict=True)]
    return "\n".join(["time [s],cylinder [V],TDC", *rows, ""])


@pytest.mark.parametrize(("pulses", "error"), [(1, 0.02), (60, 0.005)])
def test_volts_over_time_with_a_trigger_read_back(pulses, error):
    """The engine slows down by 0.8 % in a revolution, which one pulse in it cannot tell."""
    keys = TraceKeys(
        time_column=1, trigger_column="TDC", trigger_pulses=pulses, gain_bar_V=20.0, offset_V=0.5,
        pressure_reference=PressureReference.ABSOLUTE, smoothing_deg=0.0,
        angle_offset_deg={1: 200.0, 60: 86.0}[pulses],  # of the first rise, 880 or 994 before firing TDC
    )  # fmt: skip
    file = triggered(pulses)
    found = parse_trace(file, "t.csv", keys)
    peak = gauge(DEGREES).max()
    assert np.abs(bar(found) - gauge(DEGREES)).max() < error * peak


def test_what_a_trigger_cannot_tell_is_refused():
    for keys, why in (
        ({"time_column": 1}, "needs trigger_column"),
        ({"offset_V": 0.5}, "needs gain_bar_V"),
        ({"trigger_column": 3, "angle_column": 1}, "cannot be combined with trigger_column"),
        ({"trigger_column": 3, "pressure_column": 2, "trigger_pulses": 4000}, "a revolution takes 4001"),
        ({"trigger_column": 3, "gain_bar_V": 20.0, "pressure_unit": PressureUnit.PSI}, "gives bar"),
    ):
        with pytest.raises(InvalidValue, match=why):
            parse_trace(triggered(1), "t.csv", TraceKeys(**keys))


def test_what_was_assumed_is_told_in_one_line():
    told, uncertain = parse_trace(text(), "bench.csv").trace.remarks
    assert "each degree by which its TDC is off" in uncertain
    assert "bench.csv: peak" in told
    assert 'pressure_unit = "bar"' in told
    assert 'pressure_reference = "absolute" (as the compression, p·V^1.' in told
    assert "angle_offset_deg = 360 (firing TDC at 0° in the file" in told
    assert "\n" not in told


@pytest.mark.parametrize(
    ("heading", "reference"),
    [
        ("p [bara]", "absolute"),
        ("p (bar abs)", "absolute"),
        ("P_cyl_bar(a)", "absolute"),
        ("Pressure barg", "gauge"),
        ("gauge pressure [bar]", "gauge"),
        ("pcyl_bar_rel", "gauge"),
    ],
)
def test_a_heading_that_names_the_reference_decides(heading, reference):
    shift = ATMOSPHERE * (reference == "gauge")
    found = parse_trace(text(ABSOLUTE - shift, header=[f"CA,{heading}"]), "t.csv")
    np.testing.assert_allclose(bar(found), gauge(DEGREES), rtol=1e-6, atol=1e-6)
    assert found.keys.pressure_reference is None


def test_the_atmosphere_of_the_study_is_subtracted():
    found = parse_trace(text(), "t.csv", around=Surroundings(atmosphere=0.09))
    np.testing.assert_allclose(bar(found), gauge(DEGREES) + ATMOSPHERE - 0.9, rtol=1e-6, atol=1e-6)


def test_names_and_units_in_lines_of_their_own_below_a_preamble():
    header = ["Measured on 12 May", "Crank_Angle;PCYL1;INJ1;Note", "deg;MPa;-;"]
    rows = [f"{a:g};{p:.8g};0;open" for a, p in zip(FROM_FIRING, ABSOLUTE / 10, strict=True)]
    found = parse_trace("\n".join([*header, *rows]).replace(".", ","), "t.csv")
    np.testing.assert_allclose(bar(found), gauge(DEGREES), rtol=1e-6, atol=1e-6)
    assert found.keys.pressure_unit is None
    assert found.keys.pressure_column is None


@pytest.mark.parametrize(
    "heading", ["Crank angle (deg)   Pressure (kPa)", "CA[deg] p[kPa]", "# angle pressure/kPa", "%CA  p_kPa"]
)
def test_headings_above_columns_apart_by_blanks(heading):
    found = parse_trace(text(100 * ABSOLUTE, separator="   ", header=[heading]), "t.dat")
    np.testing.assert_allclose(bar(found), gauge(DEGREES), rtol=1e-6, atol=1e-6)
    assert found.keys.pressure_unit is None


def test_cycles_in_columns_are_averaged_and_the_highest_is_told():
    cycles = np.stack([ABSOLUTE * f for f in (0.9, 1.0, 1.1)], axis=1)
    found = parse_trace(text(cycles, separator="\t"), "t.txt")
    np.testing.assert_allclose(bar(found), gauge(DEGREES), rtol=1e-6, atol=1e-6)
    assert found.keys.pressure_column == "2-4"
    assert (
        f"mean of 3 cycles, the highest of which reaches {1.1 * ABSOLUTE.max() - ATMOSPHERE:.4g} bar"
        in (found.trace.remarks[0])
    )


@pytest.mark.parametrize("restart", [360.0, 720.0, np.inf])
def test_cycles_one_after_the_other_are_averaged(restart):
    angles = np.arange(0.0, 3 * 720.0)
    factor = np.repeat([0.9, 1.0, 1.1], 720)
    shown = angles % restart if np.isfinite(restart) else angles
    found = parse_trace(text(absolute(angles - 360) * factor, shown), "t.csv")
    np.testing.assert_allclose(bar(found), gauge(DEGREES), rtol=1e-6, atol=1e-6)
    assert "mean of 3 cycles" in found.trace.remarks[0]


def test_repeated_angles_are_averaged():
    angles = np.repeat(FROM_FIRING, 2)
    found = parse_trace(text(np.repeat(ABSOLUTE, 2) * np.tile([0.99, 1.01], 720), angles), "t.csv")
    np.testing.assert_allclose(bar(found), gauge(DEGREES), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("first", [-180.0, 0.0])
def test_one_revolution_of_a_four_stroke_engine_is_completed(first):
    angles = np.arange(first, first + 360)
    closed = absolute((angles + 180) % 360 - 180)
    closed[np.abs(angles - 180) < 20] = ABSOLUTE[180]  # no jump where the revolution begins anew
    found = parse_trace(text(closed, angles), "t.csv")
    about_firing = np.arange(200.0, 500.0)
    np.testing.assert_allclose(bar(found, about_firing), gauge(about_firing), rtol=1e-2, atol=0.02)
    np.testing.assert_allclose(bar(found, np.array([0.0, 100, 600, 700])), gauge(np.zeros(4)), atol=0.02)
    assert found.of_four
    assert "gas exchange is held at 0.93" in found.trace.remarks[0]


TWO_STROKE = Surroundings(strokes=2, port=95.0)


def two_stroke(degrees):
    """Absolute pressure, bar, over degrees from firing TDC: polytropic until the port opens at 95°."""
    degrees = (np.asarray(degrees, float) + 180) % 360 - 180
    shut = volume(degrees, 10.0) ** -1.3 / volume(np.array(95.0), 10.0) ** -1.3
    fired = 1 + 2.0 * ((degrees > 0) & (degrees < 95))
    return np.where(np.abs(degrees) < 95, ATMOSPHERE * shut * fired, ATMOSPHERE)


@pytest.mark.parametrize("first", [-180.0, 0.0, -77.0])
@pytest.mark.parametrize("turns", [1, 2])
def test_a_two_stroke_trace_is_one_revolution_and_repeats(first, turns):
    angles = np.arange(first, first + 360 * turns)
    found = parse_trace(text(two_stroke(angles), angles), "t.csv", around=TWO_STROKE)
    trace = found.trace
    assert trace.cycle == pytest.approx(2 * np.pi)
    assert 0 <= trace.crank_angles.min() <= trace.crank_angles.max() < 2 * np.pi
    expected = two_stroke(DEGREES) - ATMOSPHERE
    np.testing.assert_allclose(bar(found, DEGREES), expected, atol=1e-6)  # 720°: two cycles
    assert not found.of_four
    assert "(strokes" not in "".join(trace.remarks)


def test_a_documented_two_stroke_trace_counts_from_firing_and_its_zero_is_found():
    angles = np.arange(0.0, 361.0)
    pressures = two_stroke(angles) - ATMOSPHERE + 0.5  # a zero that is off
    lines = "\n".join(f"{a:g},{p:.6f}" for a, p in zip(angles, pressures, strict=True))
    found = parse_trace(f"crank_deg,pressure_bar\n{lines}\n", "t.csv", around=TWO_STROKE)
    expected = two_stroke(DEGREES) - ATMOSPHERE
    np.testing.assert_allclose(bar(found, DEGREES), expected, atol=0.03)
    assert found.trace.reading.offset_bar == pytest.approx(-0.5, abs=0.03)
    assert found.trace.reading.compression_exponent == pytest.approx(1.3, abs=0.02)


def test_a_revolution_in_the_documented_format_asks_for_the_strokes():
    angles = np.arange(0.0, 360.0)
    lines = "\n".join(f"{a:g},{p:.6f}" for a, p in zip(angles, two_stroke(angles), strict=True))
    with pytest.raises(InvalidValue, match=r"four-stroke cycle of 720°.*set engine\.strokes = 2"):
        parse_trace(f"crank_deg,pressure_bar\n{lines}\n", "t.csv")


@pytest.mark.parametrize("heading", ["crank_deg,pressure_bar", "angle;p"])
def test_a_double_acting_cylinder_is_refused_for_what_it_is(heading):
    angles = np.arange(0.0, 360.0, 2.0)
    steam = 12 * np.sign(np.sin(np.radians(angles))) * np.clip(5 * np.abs(np.sin(np.radians(angles))), 0, 1)
    separator = ";" if ";" in heading else ","
    lines = "\n".join(f"{a:g}{separator}{p:.3f}" for a, p in zip(angles, steam, strict=True))
    with pytest.raises(InvalidValue, match="double-acting cylinder") as refused:
        parse_trace(f"{heading}\n{lines}\n", "t.csv", around=TWO_STROKE)
    assert "compression" not in str(refused.value)


def test_noise_of_fine_sampling_is_smoothed_by_no_more_than_it_says():
    rng = np.random.default_rng(1)
    angles = np.arange(-360.0, 360.0, 0.1)
    clean = absolute(angles)
    noise = rng.normal(0, 0.2, angles.size)
    found = parse_trace(text(clean + noise, angles), "t.csv")
    assert found.keys.smoothing_deg == 1.0
    left = bar(found, angles + 360) - (clean - ATMOSPHERE)
    assert np.std(left) < 0.4 * np.std(noise)
    assert np.abs(left).max() < 0.04 * clean.max()
    raw = parse_trace(text(clean + noise, angles), "t.csv", TraceKeys(smoothing_deg=0.0))
    np.testing.assert_allclose(bar(raw, angles + 360), clean + noise - ATMOSPHERE, atol=1e-6)
    assert parse_trace(text(clean, angles), "t.csv").keys.smoothing_deg is None


def test_smoothing_goes_by_degrees_where_samples_are_finer_about_firing():
    angles = np.r_[np.arange(-360.0, -30, 1), np.arange(-30.0, 90, 0.05), np.arange(90.0, 360)]
    found = parse_trace(text(absolute(angles), angles), "t.csv", TraceKeys(smoothing_deg=1.0))
    np.testing.assert_allclose(bar(found, angles + 360), absolute(angles) - ATMOSPHERE, rtol=2e-3, atol=2e-3)


def test_spikes_of_knock_are_not_smoothed_away():
    angles = np.arange(-360.0, 360.0, 0.1)
    knock = absolute(angles) + 8 * np.sin(angles * 40) * np.exp(-(((angles - 15) / 10) ** 2))
    noise = np.random.default_rng(1).normal(0, 0.2, angles.size)
    found = parse_trace(text(knock + noise, angles), "t.csv")
    assert bar(found, angles + 360).max() == pytest.approx((knock + noise).max() - ATMOSPHERE)


@pytest.mark.parametrize(
    ("file", "match"),
    [
        (
            text(angles=FROM_FIRING + 100),
            r"firing TDC may be at 0°, 11\d° before the peak, or at 180°.*= 360 or 180",
        ),
        (text(np.maximum(ABSOLUTE, 0.9 * np.roll(ABSOLUTE, 360))), "firing TDC may be at 0° or at 360°"),
        (
            text(np.stack([ABSOLUTE, ABSOLUTE[::-1]], axis=1)),
            r"several columns .* 2, 3\. .*pressure_column = 2",
        ),
        (
            text(np.stack([ABSOLUTE, np.gradient(ABSOLUTE), np.roll(ABSOLUTE, 90)], axis=1)),
            r"several columns .* 2, 3, 4\. ",
        ),
        (
            text(np.stack([ABSOLUTE, ABSOLUTE], axis=1), header=["CA,PCYL1,PCYL2"]),
            r"2 \(PCYL1\), 3 \(PCYL2\)",
        ),
        (text(header=["CA [deg],Pcyl [V]"]), "unknown unit, V"),
        (text(ABSOLUTE * 0 + 1.0), "show no compression.* Set pressure_unit.* pressure_offset_bar"),
        (text(2.9e3 * ABSOLUTE), "in none of bar, kPa, MPa, Pa and psi"),
        (text(ABSOLUTE[:500], FROM_FIRING[:500]), "220° are missing"),
        (
            text(ABSOLUTE[340:411], FROM_FIRING[340:411]),
            "'-20…50': must cover a revolution.* 289° are missing",
        ),
        (text(absolute(np.arange(0, 360.0)), np.arange(0, 360.0)), "compression or expansion is missing"),
        (text(angles=np.radians(FROM_FIRING)), "rises like a crank angle in degrees"),
        (text(angles=FROM_FIRING[::-1]), "crank angle"),
        (text(angles=np.random.default_rng(0).permutation(FROM_FIRING)), "crank angle"),
        (text().replace("\n-300,", "\n-310,"), r"near line 61, crank angle = -310: must increase"),
        (text().replace("\n-300,", "\nnan,"), r"line 61, column 1 = 'nan': must be a finite number"),
        (text().replace("\n-300,", "\n-300;"), r"line 61 = '-300;.*must have 2 columns"),
        (
            text(separator=";", comma=True).replace("\n-300;0,", "\n-300;0."),
            r"line 61, column 2 .*decimal comma",
        ),
        ("\n".join(f"{p}" for p in ABSOLUTE), "no table with two columns"),
        (
            text(header=["CA,p"], separator=",").replace(".", ","),
            "names 2 columns, but the lines below it have 3",
        ),
        (text(np.r_[ABSOLUTE[:-1], 9.0]) + "360,5\n", "one cycle apart may differ"),
        ("CA,p\n" + "1," * 5000 + "1\n", "columns"),
    ],
    ids=lambda value: value[:40] if value.isprintable() else "",
)
def test_what_cannot_be_decided_is_refused(file, match):
    with pytest.raises(InvalidValue, match=match):
        parse_trace(file, "t.csv")


def test_readings_that_are_possible_are_named_with_their_keys():
    # Without a compression to judge by, a least pressure of 0.25 bar may be gauge or absolute.
    flat = np.maximum(60.0 - np.abs(FROM_FIRING - 12), 0.25)
    with pytest.raises(InvalidValue, match=r"may be bar absolute .* or bar gauge .*pressure_reference"):
        parse_trace(text(flat, header=["CA,p [bar]"]), "t.csv")


@pytest.mark.parametrize(
    ("ratio", "reference"),
    [(None, "absolute"), (None, "gauge"), (0.95 * RATIO, "absolute"), (1.05 * RATIO, "absolute")],
)
def test_the_compression_of_a_boosted_engine_tells_the_reference(ratio, reference):
    boosted = absolute(FROM_FIRING, intake=3.4) - ATMOSPHERE * (reference == "gauge")
    file = written(FROM_FIRING, boosted, header=["CA,p [bar]"])
    found = parse_trace(file, "t.csv", around=Surroundings(compression_ratio=ratio))
    assert found.keys.pressure_reference == reference


@pytest.mark.parametrize("ratio", [8.5, 10.0, 17.5])
@pytest.mark.parametrize("offset", [-4.0, 3.0])
def test_a_zero_is_found_without_the_compression_ratio(ratio, offset):
    """Within 0.2 bar: ratio and exponent change the shape alike, so that what one has the other need not."""
    degrees = np.arange(-180.0, 180.0, 0.5)
    exponent = 1.36 if ratio > 13.5 else 1.32
    pressures = 1.6 * (volume(degrees, ratio) / volume(np.array(180.0), ratio)) ** -exponent
    fit = compression(degrees, pressures + offset)
    assert fit.zero == pytest.approx(-offset, abs=0.2)
    assert abs(fit.zero + offset) < 2 * fit.zero_error


@pytest.mark.parametrize("ratio", [8.0, 16.0])
@pytest.mark.parametrize("zero", [-6.0, 0.0, 3.2])
def test_exponent_and_zero_of_an_exact_compression(ratio, zero):
    # V/V_c = 1 + (r − 1) s with the travel s of a crank with r/l = 0.29, as in the module. Of exact data the
    # prior of the exponent moves it by little, and the zero by what goes with that.
    degrees = np.arange(-180.0, 180.0, 0.5)
    sin, cos = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    travel = (1 - cos + (1 - np.sqrt(1 - (0.29 * sin) ** 2)) / 0.29) / 2
    pressures = 20.0 * (1 + (ratio - 1) * travel) ** -1.31
    found = compression(degrees, pressures - zero, ratio)
    assert found.exponent == pytest.approx(1.31, abs=0.01)
    assert found.zero == pytest.approx(zero, abs=0.05)
    # The law has no scale: in another unit everything but the exponent is a multiple.
    other = compression(degrees, 14.5 * (pressures - zero), ratio)
    assert other.exponent == pytest.approx(found.exponent, rel=1e-9)
    assert other.zero == pytest.approx(14.5 * found.zero, rel=1e-9, abs=1e-9)
    free = compression(degrees, pressures - zero)
    assert abs(free.zero - zero) < 2 * free.zero_error
    assert compression(degrees, -pressures, ratio) is None
    assert compression(degrees, np.where(degrees < -70, 1.0, 9.0), ratio) is None


def test_keys_decide_what_the_file_does_not():
    turned = text(angles=FROM_FIRING + 100)
    found = parse_trace(turned, "t.csv", TraceKeys(angle_offset_deg=260.0))
    np.testing.assert_allclose(bar(found), gauge(DEGREES), rtol=1e-6, atol=1e-6)
    two = text(np.stack([ABSOLUTE, ABSOLUTE * 2], axis=1), header=["CA,Pcyl 1,Pcyl 2"])
    for column in ("Pcyl 1", 2, "2"):
        found = parse_trace(two, "t.csv", TraceKeys(pressure_column=column))
        np.testing.assert_allclose(bar(found), gauge(DEGREES), rtol=1e-6, atol=1e-6)
    given = TraceKeys(pressure_unit=PressureUnit.KPA, pressure_reference=PressureReference.GAUGE)
    given = replace(given, pressure_offset_bar=0.0)  # whatever the compression shows
    found = parse_trace(text(100 * ABSOLUTE, header=["CA,p [bar]"]), "t.csv", given)
    np.testing.assert_allclose(bar(found), gauge(DEGREES) + ATMOSPHERE, rtol=1e-6, atol=1e-6)
    assert "but the compression" in found.trace.doubts[0]


def test_an_absolute_pressure_in_place_of_a_gauge_pressure_is_found():
    ours = text(absolute(DEGREES - 360), DEGREES, header=["crank_deg,pressure_bar"])
    found = parse_trace(ours, "t.csv")
    np.testing.assert_allclose(bar(found), gauge(DEGREES), rtol=1e-6, atol=1e-6)
    assert "a zero that is off by +1.01 bar" in found.trace.doubts[0]
    right = parse_trace(text(gauge(DEGREES), DEGREES, header=["crank_deg,pressure_bar"]), "t.csv")
    assert right.trace.doubts == ()


def test_one_column_a_speed_from_another_dead_centre_or_absolute():
    speeds = np.stack([ABSOLUTE, absolute(FROM_FIRING, burnt=2.0)], axis=1)
    header = ["crank_deg,pressure_bar_1000rpm,pressure_bar_2000rpm"]
    turned = parse_trace(text(speeds - ATMOSPHERE, header=header), "t.csv")
    absolute_ones = parse_trace(
        text(speeds, DEGREES, header=header),
        "t.csv",
        TraceKeys(pressure_reference=PressureReference.ABSOLUTE),
    )
    for found in (turned, absolute_ones):
        at = 10 * found.trace.pressure(np.radians(DEGREES), np.array([[1500]]) * np.pi / 30)
        np.testing.assert_allclose(at[0], (speeds - ATMOSPHERE).mean(axis=1), rtol=1e-6, atol=1e-6)
        assert found.trace.pressures.shape == (2, 720)
    assert turned.keys.given == {"angle_offset_deg": 360.0}


def test_a_low_peak_is_not_said_to_be_in_another_unit_where_the_unit_is_known():
    throttled = absolute(FROM_FIRING, intake=0.35, burnt=1.0)  # an engine at idle: a peak of 13 bar
    for unit in ("bar", "kPa", "MPa"):
        file = text(throttled * BAR_IN[unit], header=[f"CA,p [{unit} abs]"])
        said = parse_trace(file, "t.csv").trace.note(100.0)
        assert "as in an engine at idle" in said
        assert "pressure_unit" not in said
    flat = 0.1 + 1.5 * np.exp(-(((FROM_FIRING - 8) / 15) ** 2))  # no compression tells the unit
    said = parse_trace(text(flat, header=["CA,p [bar]"]), "t.csv").trace.note(100.0)
    assert 'if the file is in MPa, set pressure_unit = "MPa"' in said


def test_pressures_that_no_compression_gives_are_remarked_on():
    keys, around = TraceKeys(angle_offset_deg=360.0), Surroundings(compression_ratio=RATIO)
    for late, said in ((20, "which is not that of a compression"), (-60, "shows no compression")):
        turned = text(angles=FROM_FIRING + late, header=["CA,p [bara]"])
        found = parse_trace(turned, "t.csv", keys, around).trace
        assert said in found.doubts[0]
        assert found.reading.offset_bar == 0  # nothing is shifted by what is none


@pytest.mark.parametrize("shift", [-6.0, -2.2, -0.4, 0.3, 4.0, 5.0])
@pytest.mark.parametrize("heading", ["", "CA,p [bar]", "CA,p [barg]", "crank_deg,pressure_bar"])
def test_a_zero_that_is_off_is_found_from_the_compression(shift, heading):
    shown = ABSOLUTE - ATMOSPHERE if heading.endswith(("barg]", "pressure_bar")) else ABSOLUTE
    angles = DEGREES if heading == "crank_deg,pressure_bar" else FROM_FIRING
    file = written(angles, shown + shift, header=[heading] if heading else ())
    found = parse_trace(file, "t.csv", around=Surroundings(compression_ratio=RATIO))
    np.testing.assert_allclose(bar(found), gauge(DEGREES), atol=0.1)  # 0.4 % of the peak
    assert found.trace.reading.unit == "bar"
    assert found.trace.reading.compression_exponent == pytest.approx(1.32, abs=0.03)
    (told,) = found.trace.doubts
    assert "shows a zero that is off by" in told
    assert "pressure_offset_bar" in told


def test_a_zero_is_pegged_to_the_intake_where_that_is_given():
    around = Surroundings(compression_ratio=RATIO, intake=0.093)
    found = parse_trace(text(ABSOLUTE - 3.0, header=["CA,p [bar]"]), "t.csv", around=around)
    np.testing.assert_allclose(bar(found), gauge(DEGREES), atol=0.011)
    assert "the pressure in the intake, 0.93 bar, shows" in found.trace.doubts[0]


def test_an_offset_that_is_given_is_taken_and_doubted_where_the_compression_contradicts():
    around, file = Surroundings(compression_ratio=RATIO), text(ABSOLUTE - 3.0, header=["CA,p [bara]"])
    given = parse_trace(file, "t.csv", TraceKeys(pressure_offset_bar=3.0), around)
    np.testing.assert_allclose(bar(given), gauge(DEGREES), rtol=1e-6, atol=1e-6)
    assert given.trace.doubts == ()
    (told,) = parse_trace(file, "t.csv", TraceKeys(pressure_offset_bar=2.4), around).trace.doubts
    assert "pressure_offset_bar = 2.4 is taken, but the compression" in told


def motored(degrees, loss=0.6):
    """Absolute pressure, bar, of an engine without combustion, whose peak lies before TDC."""
    return absolute(np.asarray(degrees) + loss, burnt=0.0)


def test_a_motored_peak_tells_what_the_angles_are_off_by():
    fine = np.arange(-360.0, 360.0, 0.5)
    around = Surroundings(compression_ratio=RATIO)

    def doubts(loss):
        file = written(fine, motored(fine, loss), header=["CA,p [bara]"])
        return parse_trace(file, "t.csv", around=around).trace.doubts

    assert doubts(0.6) == ()
    assert "the motored peak is 3° before TDC" in doubts(3.0)[0]
    assert "the motored peak is 0.078° before TDC" in doubts(0.08)[0]
    with pytest.raises(InvalidValue, match=r"the peak = '\+0.50° from TDC': .* at or after TDC.*Add -1.1°"):
        doubts(-0.5)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "latin-1"])
def test_encodings_of_spreadsheets(encoding, tmp_path):
    file = tmp_path / "t.csv"
    file.write_text(text(header=["Winkel [°KW],Druck [bar]"]), encoding=encoding)
    np.testing.assert_allclose(bar(read_trace(file)), gauge(DEGREES), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    "raw",
    [
        bytes(range(256)) * 50,
        b"\x89PNG\r\n\x1a\n" + bytes(1000),
        b"PK\x03\x04" + b"1,2\n" * 100,
        b"\xff\xfe1",
    ],
    ids=["bytes", "png", "zip", "half a letter"],
)
def test_binary_files_are_refused(raw, tmp_path):
    file = tmp_path / "t.csv"
    file.write_bytes(raw)
    with pytest.raises(InvalidValue, match="not a text file"):
        read_trace(file)


def test_a_file_of_ten_million_lines_is_refused_unread(tmp_path):
    file = tmp_path / "t.csv"
    with file.open("wb") as handle:
        handle.truncate(40 * 2**20)  # what 10⁷ lines of "0,1" take
    with pytest.raises(InvalidValue, match="at most 16 MiB are read"):
        read_trace(file)
    assert LARGEST_TRACE == 16 * 2**20


@pytest.mark.parametrize("seed", range(3000, 3012))
def test_random_traces_are_read_rightly_or_refused_with_the_remedy(seed):
    one = drawn(seed)
    outcome, why = judged(one)
    assert outcome in (("right",) if one.known else ("right", "refused")), f"{one.what}: {why}"


HALF_DEGREES = np.arange(-360.0, 360.0, 0.5)
COUNTED = np.column_stack([np.arange(1440.0), HALF_DEGREES, absolute(HALF_DEGREES)])


@pytest.mark.parametrize(
    ("columns", "proposed"),
    [
        ([0, 1, 2], "angle_column = 2, pressure_column = 3"),  # a counter first
        ([2, 0, 1], "angle_column = 3, pressure_column = 1"),
        ([1, 0, 2], "angle_column = 1, pressure_column = 3"),
    ],
)
def test_the_columns_that_give_a_compression_are_proposed(columns, proposed):
    rows = COUNTED[:, columns]
    file = "\n".join(",".join(f"{value:.6g}" for value in row) for row in rows) + "\n"
    with pytest.raises(InvalidValue, match=f"as compression suggests: {proposed}"):
        parse_trace(file, "t.csv")
    keys = TraceKeys(pressure_column=columns.index(2) + 1)
    np.testing.assert_allclose(bar(parse_trace(file, "t.csv", keys)), gauge(DEGREES), rtol=1e-4, atol=1e-4)
