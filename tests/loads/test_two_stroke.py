"""A two-stroke engine: its cycle is one revolution, from firing TDC at 0 to firing TDC at 2π."""

import math
from dataclasses import replace

import numpy as np
import pytest
from engines import DEG, LEON, LEON_ROD, RPM, engines, rods
from hypothesis import given, settings
from hypothesis import strategies as st

from fea.analysis.cycle.candidates import around, sampled_angles
from fea.study.engine_table import EngineTable, engine_notes
from geometry.errors import InvalidValue
from loads.crank_cycle import CrankCycle
from loads.gas import ATMOSPHERE, Boyle, NoGas, TwoStrokeOtto, dead_centres, scaled
from loads.trace import Trace

TWO = replace(LEON, strokes=2)
RATIO, PEAK, PORT, GAMMA = 10.0, 6.0, 95.0, 1.4
STANDING = np.array(0.0)


def otto(engine=TWO, **keys):
    return TwoStrokeOtto(engine, RATIO, **({"peak": PEAK, "port": PORT * DEG} | keys))


def volume(degrees, r=47.0, l=141.0):
    """Over the clearance volume, by the cosine rule: l² = r² + x² − 2 r x cos θ."""
    cos = math.cos(degrees * DEG)
    x = r * cos + math.sqrt(l**2 - r**2 + (r * cos) ** 2)
    return 1 + (RATIO - 1) * (r + l - x) / (2 * r)


def pressure(gas, degrees):
    return float(gas.pressure(np.array(degrees * DEG), STANDING)) + ATMOSPHERE


def test_the_pressure_at_tdc_and_at_the_port_is_that_by_hand():
    gas, v = otto(), volume(PORT)
    assert v == pytest.approx(gas.trapped_ratio, rel=1e-12)
    assert pressure(gas, 0.0) == pytest.approx(PEAK, rel=1e-12)
    assert pressure(gas, 360.0) == pytest.approx(PEAK, rel=1e-12)
    assert pressure(gas, 360 - 1e-6) == pytest.approx(ATMOSPHERE * v**GAMMA, rel=1e-9)
    assert pressure(gas, 90.0) == pytest.approx(PEAK * volume(90.0) ** -GAMMA, rel=1e-12)
    assert pressure(gas, PORT - 1e-6) == pytest.approx(PEAK * v**-GAMMA, rel=1e-6)
    for opened in (PORT + 1e-6, 180.0, 360 - PORT - 1e-6):
        assert pressure(gas, opened) == pytest.approx(ATMOSPHERE, rel=1e-12)
    assert pressure(gas, 300.0) == pytest.approx(ATMOSPHERE * (v / volume(60.0)) ** GAMMA, rel=1e-12)


def test_a_boosted_engine_scavenges_at_its_boost_and_grows_with_it():
    gas = scaled(otto(), 1.5)
    assert pressure(gas, 180.0) == pytest.approx(1.5 * ATMOSPHERE)
    assert pressure(gas, 0.0) == pytest.approx(1.5 * PEAK)
    assert gas.compressed == pytest.approx(1.5 * otto().compressed)


def test_the_mean_torque_is_the_work_of_the_indicator_diagram():
    # W = ∮ p dV: two isentropes between clearance and port, and nothing while the port is open.
    v, clearance = volume(PORT), TWO.piston_area * TWO.stroke / (RATIO - 1)
    expansion = PEAK * (1 - v ** (1 - GAMMA)) / (GAMMA - 1)
    compression = ATMOSPHERE * (v**GAMMA - v) / (GAMMA - 1)
    work = (expansion - compression) * clearance
    middles = (np.arange(36_000) + 0.5) * (2 * np.pi / 36_000)  # midpoint rule: the port opens on a border
    torque = CrankCycle(TWO, LEON_ROD, otto(), 3000 * RPM).at(middles).torque.mean()
    assert 2 * np.pi * torque == pytest.approx(work, rel=1e-6)


@given(engines(), st.floats(0.3, 2.8))
def test_the_port_is_at_one_place_of_the_piston_with_any_offset(engine, port):
    gas = otto(replace(engine, strokes=2), port=port)
    top, _ = dead_centres(engine)
    at = top + np.linspace(0.0, 2 * np.pi, 721)
    gauge = gas.pressure(at, STANDING)
    assert gauge[0] == pytest.approx(PEAK - ATMOSPHERE, rel=1e-9)
    assert (gauge[at < top + port * (1 - 1e-9)] > 0).all()
    shut = gauge[1:-1] != 0
    assert np.count_nonzero(np.diff(shut.astype(int))) == 2  # it opens once and shuts once


@settings(max_examples=30)
@given(engines(), rods, st.floats(100, 9000))  # friction turns at dead centre, by rounding
def test_without_gas_both_revolutions_of_a_four_stroke_engine_are_a_cycle(engine, rod, rpm):
    four = CrankCycle(engine, rod, NoGas(), rpm * RPM)
    two = CrankCycle(replace(engine, strokes=2), rod, NoGas(), rpm * RPM)
    assert len(four.degrees) == 721
    assert len(two.degrees) == 361
    largest = np.abs(four.degrees.crank).max()
    for turn in (slice(361), slice(360, None)):
        for name in ("pin", "crank", "wall"):
            once, twice = getattr(two.degrees, name), getattr(four.degrees, name)[..., turn]
            np.testing.assert_allclose(once, twice, rtol=0, atol=1e-9 * largest)
    for one, other in zip(two.peaks.cases, four.peaks.cases, strict=True):
        assert one.name == other.name
        assert 0 <= one.crank_angle < 2 * np.pi
        assert one.largest_force == pytest.approx(float(other.largest_force), rel=1e-6)


def test_boyle_compresses_in_every_revolution_whatever_the_strokes():
    at = TWO.cycle_angles
    np.testing.assert_array_equal(
        Boyle(TWO, RATIO).pressure(at, STANDING), Boyle(LEON, RATIO).pressure(at, STANDING)
    )


@pytest.mark.parametrize(("strokes", "interval"), [(None, 240.0), (4, 240.0), (2, 120.0)])
def test_cylinders_fire_evenly_over_a_cycle(strokes, interval):
    table = EngineTable(stroke_mm=94.0, bore_mm=76.0, piston_mass_kg=0.5, cylinders=3, strokes=strokes)
    fired = np.array(table.engine(141.0).firing_angles) / DEG
    np.testing.assert_allclose(fired, interval * np.arange(3))


def test_crank_pins_of_a_two_stroke_v_engine_fire_in_one_revolution():
    pins = {
        "cylinders": 4,
        "bank_angle_deg": 90.0,
        "banks": "ABAB",
        "crank_pins_deg": (0.0, 0.0, 180.0, 180.0),
    }
    table = EngineTable(stroke_mm=94.0, bore_mm=76.0, piston_mass_kg=0.5, strokes=2, **pins)
    np.testing.assert_allclose(np.array(table.engine(141.0).firing_angles) / DEG, [0, 90, 180, 270])


def test_hours_hold_twice_as_many_cycles():
    assert (LEON.cycles_per_hour, TWO.cycles_per_hour) == (30.0, 60.0)  # 60 revolutions an hour at 1 rpm


def test_increments_go_round_one_revolution():
    cycle = CrankCycle(TWO, LEON_ROD, otto(), 6000 * RPM)
    steps = cycle.increments.crank_angle
    assert steps[-1] - steps[0] < 2 * np.pi
    assert len(steps) == len(np.unique(np.round(np.mod(steps, 2 * np.pi), 9)))
    np.testing.assert_allclose(cycle.places(steps + 2 * np.pi), np.arange(len(steps)), atol=1e-6)


def test_angles_that_are_looked_at_stay_within_the_revolution():
    cycle = CrankCycle(TWO, LEON_ROD, otto(), 6000 * RPM)
    near = around(cycle, np.array([0.0, 2 * np.pi])) / DEG
    assert near.min() == 0
    assert near.max() < 360
    assert {1.0, 359.0} <= set(np.round(near, 9))
    assert (sampled_angles(cycle, 5) < 2 * np.pi).all()


def test_a_trace_of_one_revolution_repeats_and_may_peak_after_firing_only():
    degrees = np.arange(0.0, 360.0, 5.0)
    hump = 6.0 * np.exp(-(((degrees - 15) / 30) ** 2))
    made = Trace(degrees * DEG, hump, np.zeros(0), cycle=2 * np.pi)
    np.testing.assert_allclose(made.pressure((degrees + 720) * DEG, STANDING), hump, atol=1e-9)
    assert made.note(1.0) == ""
    turned = Trace(degrees * DEG, np.roll(hump, 36), np.zeros(0), cycle=2 * np.pi)
    assert "peaks at 195°, far from firing TDC" in turned.note(1.0)
    with pytest.raises(InvalidValue, match=r"two-stroke cycle of 360°: 185° are missing"):
        Trace(degrees[:36] * DEG, hump[:36], np.zeros(0), cycle=2 * np.pi)


BASE = {"stroke_mm": 94.0, "bore_mm": 76.0, "piston_mass_kg": 0.5}


@pytest.mark.parametrize(
    ("keys", "match"),
    [
        ({"strokes": 3}, "must be 2 or 4"),
        ({"exhaust_port_deg": 95.0}, "is that of a two-stroke engine"),
        ({"strokes": 2, "gas": "leon-2001"}, "the trace of a four-stroke engine"),
        ({"strokes": 2, "roller_bearings": ("middle",)}, "big end, small end"),
    ],
)
def test_keys_that_do_not_fit_are_refused(keys, match):
    with pytest.raises(InvalidValue, match=match):
        EngineTable(**BASE, **keys)


def test_a_table_gives_the_two_stroke_cycle_and_says_what_it_assumed():
    keys = {"gas": "otto", "compression_ratio": RATIO, "peak_pressure_bar": 60.0, "strokes": 2}
    table = EngineTable(**BASE, **keys)
    engine = table.engine(141.0)
    gas = table.gas_model(engine)
    assert gas == otto(engine)
    said = " ".join(map(str, engine_notes(table, 141.0, 3000)))
    assert "assumed exhaust_port_deg = 95" in said
    assert "45.4 N on the piston" in said  # 0.1 bar on a bore of 76 mm: 0.01 MPa · 4536 mm²
    later = EngineTable(**BASE, **keys, exhaust_port_deg=110.0)
    assert later.gas_model(engine).trapped_ratio == pytest.approx(volume(110.0))
    assert "assumed" not in " ".join(map(str, engine_notes(later, 141.0, 3000)))
    assert engine_notes(EngineTable(**BASE), 141.0, 3000) == []


def test_the_peak_by_fuel_is_that_of_the_charge_that_the_port_traps():
    keys = {"gas": "otto", "compression_ratio": RATIO, "fuel": "petrol"}
    four, two = EngineTable(**BASE, **keys), EngineTable(**BASE, **keys, strokes=2)
    gas = two.gas_model(two.engine(141.0))
    # The mass that burns in one clearance volume is in proportion to the trapped volume.
    share = gas.trapped_ratio / RATIO
    whole = four.gas_model(four.engine(141.0)).peak
    assert gas.peak == pytest.approx(share * whole, rel=0.05)
    assert "computed for petrol" in gas.remarks[0]
    closed = replace(two, exhaust_port_deg=179.0)  # as if it had no port
    assert closed.gas_model(closed.engine(141.0)).peak == pytest.approx(whole, rel=1e-3)
