"""Peak pressures of a burning charge: closed forms, Heywood's rules of timing, and peaks that are known."""

from dataclasses import replace

import numpy as np
import pytest

from fea.study.engine_library import engine_preset
from fea.study.engine_table import EngineTable
from fea.study.traces import shipped_trace
from geometry.errors import InvalidValue
from loads.combustion import FUELS, Timing, closed_cycle, cut_off, peak_interval
from loads.compression import ROD_RATIO

ATMOSPHERE = 0.101325


def test_with_half_burned_at_10_degrees_the_pressure_is_largest_at_16():
    """Heywood (1988), section 9.1: rules of thumb for the best timing, so that 2° are enough."""
    for ratio in (8.0, 9.5, 11.0):
        angles, pressures = closed_cycle(ratio, ATMOSPHERE, FUELS["petrol"], Timing(10, 50, 1.0), ROD_RATIO)
        assert angles[pressures.argmax()] == pytest.approx(16, abs=2)


def test_without_heat_compression_follows_the_falling_heat_ratio():
    """dT/T = −(γ₀ − 1 − γ₁ T) dV/V integrates to T/(b − T) V^b' = const, with b = (γ₀ − 1)/γ₁."""
    cold, ratio = replace(FUELS["petrol"], heat=0.0), 10.0
    _, pressures = closed_cycle(ratio, ATMOSPHERE, cold, Timing(10, 50, 1.0), ROD_RATIO)
    limit, begin = 0.40 / 7.5e-5, cold.temperature
    grown = begin / (limit - begin) * ratio**0.40
    end = limit * grown / (1 + grown)
    assert pressures.max() == pytest.approx(ATMOSPHERE * ratio * end / begin, rel=2e-3)


def test_heat_at_dead_centre_raises_the_pressure_as_at_constant_volume():
    """Δp = (γ − 1) Q/V, with γ at the mean temperature; heat within 1° leaves 1 % to the motion."""
    little = replace(FUELS["petrol"], heat=2e5)
    none, at_once = replace(little, heat=0.0), Timing(0.0, 1.0, 1.0)
    both = (closed_cycle(10.0, ATMOSPHERE, fuel, at_once, ROD_RATIO) for fuel in (little, none))
    hot, cold = (pressures.max() for _, pressures in both)
    gamma = 1.40 - 7.5e-5 * 350.0 * (cold + hot) / 2 / ATMOSPHERE / 10.0
    expected = (gamma - 1) * 0.85 * 2e5 / (287.0 * 350.0) * ATMOSPHERE * 10.0
    assert hot - cold == pytest.approx(expected, rel=0.015)


def test_peaks_are_in_proportion_to_the_pressure_in_the_intake():
    low, high = peak_interval("petrol", 9.0, ATMOSPHERE)
    assert peak_interval("petrol", 9.0, 2.5 * ATMOSPHERE) == pytest.approx((2.5 * low, 2.5 * high))


def test_measured_peaks_lie_in_the_interval():
    """León (2001), table 7: 70 bar at 6000 rpm, ratio not published; SD195 diesel: 70.85 bar."""
    trace = shipped_trace("leon-2001")
    measured = float(np.max(trace.pressure(trace.samples, np.asarray(628.3))))
    for ratio in (11.0, 12.0):
        low, high = peak_interval("petrol", ratio, ATMOSPHERE)
        assert low < measured + ATMOSPHERE < high
    diesel = engine_preset("sd195").engine
    low, high = peak_interval("diesel", diesel["compression_ratio"].value, ATMOSPHERE)
    assert low < 0.1 * diesel["peak_pressure_bar"].value < high


def test_the_peak_of_a_study_with_a_fuel_is_computed_unless_it_is_given():
    table = EngineTable(stroke_mm=86.0, bore_mm=86.0, piston_mass_kg=0.4, gas="otto", compression_ratio=9.0)
    with pytest.raises(InvalidValue, match='fuel = "petrol"'):
        table.gas_model(table.engine(140.0))
    boosted = replace(table, fuel="petrol", boost_bar=1.5)
    gas = boosted.gas_model(boosted.engine(140.0))
    high = peak_interval("petrol", 9.0, ATMOSPHERE + 0.15, 43.0 / 140.0)[1]
    assert gas.peak == pytest.approx(high)
    assert f"{10 * high:.3g}" in gas.remarks[0]
    given = replace(boosted, peak_pressure_bar=90.0)
    assert given.gas_model(given.engine(140.0)).peak == pytest.approx(9.0)
    with pytest.raises(InvalidValue, match="must be one of petrol, diesel"):
        replace(table, fuel="steam")


@pytest.mark.parametrize("strokes", [4, 2])
def test_a_diesel_engine_has_the_efficiency_of_the_limited_pressure_cycle(strokes):
    """η = 1 − (α ρ^γ − 1)/(r^(γ−1) (α − 1 + γ α (ρ − 1))), as in textbooks, of the heat of the fuel."""
    table = EngineTable(
        stroke_mm=90.0, bore_mm=80.0, piston_mass_kg=0.6, gas="otto", fuel="diesel", strokes=strokes,
        compression_ratio=17.0, peak_pressure_bar=110.0, exhaust_port_deg=None if strokes == 4 else 110.0,
    )  # fmt: skip
    engine = table.engine(145.0)
    gas = table.gas_model(engine)
    ratio, gamma = (gas.compressed / gas.intake) ** (1 / 1.4), 1.4  # effective, of what is trapped
    rise, until = 11.0 / gas.compressed, gas.cut_off
    assert 1.0 < until < 1.6
    # Closed from BDC (or the port) to BDC: work of expansion less compression, over the clearance volume.
    volume = np.linspace(1.0, ratio, 400_001)
    work = np.trapezoid(gas.expanding(volume**-gamma) - gas.compressed * volume**-gamma, volume)
    heat = gas.compressed / (gamma - 1) * (rise - 1 + gamma * rise * (until - 1))
    known = 1 - (rise * until**gamma - 1) / (ratio ** (gamma - 1) * (rise - 1 + gamma * rise * (until - 1)))
    assert work / heat == pytest.approx(known, rel=1e-6)
    mass = gas.intake * ratio / (287.0 * FUELS["diesel"].temperature)  # t/mm³ × 1e3 of the clearance volume
    assert heat == pytest.approx(mass * 0.85 * FUELS["diesel"].heat, rel=1e-9)
    angles = np.radians(np.linspace(0, 180 * strokes, 7201))
    assert gas.pressure(angles, np.array(0.0)).max() == pytest.approx(11.0 - ATMOSPHERE, rel=1e-9)


def test_where_all_fuel_burns_at_once_nothing_is_left_to_burn_later():
    assert cut_off(replace(FUELS["diesel"], heat=0.0), 50.0, 1.5, 1.4) == 1.0
    assert cut_off(FUELS["diesel"], 50.0, 9.0, 1.4) == 1.0  # the peak takes more heat than there is
