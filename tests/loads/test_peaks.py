import math

import numpy as np
import pytest
from engines import DEG, LEON, LEON_ROD, RPM, rod_of

from fea.study.traces import shipped_trace
from geometry.errors import InvalidValue
from loads.crank_cycle import CrankCycle
from loads.dynamics import cycle
from loads.gas import NoGas
from loads.instants import given
from loads.trace import Trace

FINE = np.arange(0, 720, 0.02) * DEG


@pytest.mark.parametrize("rpm", [800, 3000, 6000])
def test_no_crank_angle_is_worse_than_its_peak_case(rpm):
    gas = shipped_trace("leon-2001")
    c = cycle(LEON, LEON_ROD, gas, rpm * RPM, FINE)
    cases = {case.name: case for case in CrankCycle(LEON, LEON_ROD, gas, rpm * RPM).peaks.cases}
    found = {
        "tension": max(cases["tension"].pin_axial, cases["tension"].crank_axial),
        "compression": -min(cases["compression"].pin_axial, cases["compression"].crank_axial),
        "side": abs(cases["side"].wall),
        "bending": abs(cases["bending"].crank_transverse),
        "gas": cases["gas"].gas,
    }
    largest = {
        "tension": np.maximum(c.pin_axial, c.crank_axial).max(),
        "compression": -np.minimum(c.pin_axial, c.crank_axial).min(),
        "side": np.abs(c.wall).max(),
        "bending": np.abs(c.crank_transverse).max(),
        "gas": c.gas.max(),
    }
    for name, value in found.items():
        assert value == pytest.approx(largest[name], rel=1e-5), name


def test_each_case_balances_with_the_rods_own_inertia():
    for case in CrankCycle(LEON, LEON_ROD, shipped_trace("leon-2001"), 6000 * RPM).peaks.cases:
        if not case.in_cycle:
            assert case.crank_axial == case.pin_axial
            continue
        m, (x, y, _) = LEON_ROD.mass, LEON_ROD.center
        (a_x, a_y), w, alpha = case.acceleration, case.angular_velocity, case.angular_acceleration
        force_x = m * (a_x - alpha * y - w**2 * x)
        force_y = m * (a_y + alpha * x - w**2 * y)
        moment = LEON_ROD.inertia_z * alpha + x * force_y - y * force_x
        scale = abs(case.crank_axial)
        assert case.pin_axial - case.crank_axial == pytest.approx(force_x, abs=1e-12 * scale)
        assert case.pin_transverse + case.crank_transverse == pytest.approx(force_y, abs=1e-12 * scale)
        assert case.pin_transverse * 141 == pytest.approx(moment, abs=1e-12 * scale * 141)


def test_cases_that_do_not_occur_are_left_out_with_a_reason():
    at_rest = CrankCycle(LEON, LEON_ROD, NoGas(), 0.0).peaks
    assert len(at_rest.cases) == 0
    assert [name for name, _ in at_rest.left_out] == ["tension", "compression", "side", "bending", "gas"]
    inertia_alone = CrankCycle(LEON, LEON_ROD, NoGas(), 300.0).peaks
    assert [name for name, _ in inertia_alone.left_out] == ["gas"]


def test_gas_alone_at_standstill_never_pulls():
    class Hydraulic(NoGas):
        def pressure(self, crank_angle, speed):
            return np.ones(np.broadcast_shapes(crank_angle.shape, speed.shape))

    peaks = CrankCycle(LEON, LEON_ROD, Hydraulic(), 0.0).peaks
    assert ("tension", "the rod is in compression throughout the cycle") in peaks.left_out


def test_of_equal_peaks_of_bending_the_one_with_most_thrust_is_taken():
    # The transverse force does not feel the gas, so ±72° of either TDC tie; combustion breaks the tie.
    bending = next(
        c
        for c in CrankCycle(LEON, LEON_ROD, shipped_trace("leon-2001"), 6000 * RPM).peaks.cases
        if c.name == "bending"
    )
    assert bending.crank_angle == pytest.approx(math.radians(431.57), abs=1e-3)


def test_a_given_force_is_held_by_the_crank_end():
    case = given(-1000.0, 50.0)
    assert (case.pin_axial, case.crank_axial) == (-1000.0, -1000.0)
    assert case.pin_transverse + case.crank_transverse == 0
    assert np.isnan(case.crank_angle)
    assert not case.in_cycle
    assert not case.motions.any()


@pytest.mark.parametrize("forces", [(math.nan, 0.0), (0.0, 0.0), ("1", 0.0), (0.0, math.inf)])
def test_a_bad_given_force_is_refused(forces):
    with pytest.raises(InvalidValue, match=r"forces\.pin_N"):
        given(*forces)


def test_a_weightless_rod_carries_axial_force_only():
    rod = rod_of(1e-12, (64.0, 0.0), 1e-15)
    c = cycle(LEON, rod, NoGas(), 600.0, FINE)
    np.testing.assert_allclose(c.pin_axial, c.crank_axial, rtol=0, atol=1e-6)
    np.testing.assert_allclose(c.pin_transverse, 0, atol=1e-6)


def test_a_rod_at_rest_is_not_bent():
    # Pin and crank force of a rod without inertia are equal and opposite, but for rounding.
    peaks = CrankCycle(LEON, LEON_ROD, shipped_trace("leon-2001"), 0.0).peaks
    assert {case.name for case in peaks.cases} == {"compression", "side", "gas"}
    assert dict(peaks.left_out)["bending"] == "there is no transverse force on the crank end"


def test_a_spike_of_the_pressure_narrower_than_the_search_is_found():
    # Knocking combustion, sampled at 0.1°: the highest pressure lies between half degrees.
    degrees = np.arange(0, 720, 0.1)
    bar = 60 * np.exp(-(((degrees - 370) / 40) ** 2))
    bar[3723] += 60
    gas = Trace(degrees * DEG, 0.1 * bar, np.array([]))
    cases = {case.name: case for case in CrankCycle(LEON, LEON_ROD, gas, 2000 * RPM).peaks.cases}
    highest = 0.1 * bar.max() * LEON.piston_area
    assert cases["gas"].gas == pytest.approx(highest, rel=1e-9)
    for name in ("gas", "compression", "side"):
        assert cases[name].crank_angle / DEG == pytest.approx(372.3, abs=0.006), name
