"""Crank forces against an independent linear system, conservation laws and published figures."""

import numpy as np
import pytest
from engines import DEG, LEON, LEON_ROD, RPM, engines, rod_of, rods
from hypothesis import given, settings
from hypothesis import strategies as st

from fea.study.traces import shipped_trace
from fea.verify.reproduce.columba import solve
from loads.dynamics import center_acceleration, cycle, to_rod_axes
from loads.engine import Engine
from loads.gas import NoGas

ANGLES = np.arange(0, 720, 3.0) * DEG
TRACE = shipped_trace("leon-2001")


@settings(max_examples=40, deadline=None)
@given(engines(friction=True), rods, st.floats(10, 900))
def test_closed_form_against_the_8x8_newton_euler_system(engine, rod, speed):
    """Norton, Design of Machinery, §11.4, solved by LAPACK: both are exact, so 1e-9 of the peak is rounding.

    Its friction is a signed ratio F14x/F14y; here it is chosen by trial so that friction opposes motion.
    """
    c = cycle(engine, rod, TRACE, speed, ANGLES)
    sign = np.sign(c.motion.piston_velocity)
    plus, minus = (solve(engine, rod, -c.gas, s * engine.friction * sign, (ANGLES, speed)) for s in (-1, 1))
    opposing = plus.F14y >= 0  # F14x = −μ sgn(ẋ) F14y opposes ẋ where F14y > 0
    pin, crank = c.in_engine_axes(c.pin), c.in_engine_axes(c.crank)
    choose = {
        "F43x": pin.x,
        "F43y": pin.y,
        "F32x": -crank.x,
        "F32y": -crank.y,
        "F14y": c.wall,
        "T12": -c.torque,
    }
    for theirs, ours in choose.items():
        expected = np.where(opposing, getattr(plus, theirs), getattr(minus, theirs))
        assert np.abs(ours - expected).max() < 1e-9 * np.abs(expected).max(), theirs


@settings(max_examples=40, deadline=None)
@given(engines(friction=True), rods, st.floats(10, 900))
def test_power_in_is_power_out_plus_kinetic_energy(engine, rod, speed):
    """Gas power less friction = torque·ω + d(KE)/dt at every angle, KE differentiated analytically."""
    c = cycle(engine, rod, TRACE, speed, ANGLES)
    k = c.motion
    x, y, _ = rod.center
    turn = -k.rod_rate
    # Velocity of the centre of gravity in rod axes: crank pin's r ω (sideways) plus ω_rod × r.
    along = -engine.crank_radius * speed * np.sin(k.crank_angle + k.rod_angle)
    across = engine.crank_radius * speed * np.cos(k.crank_angle + k.rod_angle)
    v_x, v_y = along - turn * y, across + turn * x
    a_x, a_y = center_acceleration(engine, rod, k)
    kinetic = (
        engine.piston_mass * k.piston_velocity * k.piston_acceleration
        + rod.mass * (v_x * a_x + v_y * a_y)
        + rod.inertia_z * k.rod_rate * k.rod_acceleration
    )
    power_in = (c.friction - c.gas) * k.piston_velocity
    power_out = c.torque * speed
    scale = max(np.abs(power_in).max(), np.abs(power_out).max(), np.abs(kinetic).max())
    assert np.abs(power_in - power_out - kinetic).max() < 1e-9 * scale
    assert (c.friction * k.piston_velocity <= 0).all()


@settings(max_examples=40, deadline=None)
@given(engines(friction=True), rods, st.floats(10, 900))
def test_moments_of_the_rod_about_its_centre_of_gravity(engine, rod, speed):
    c = cycle(engine, rod, TRACE, speed, ANGLES)
    x, y, _ = rod.center
    moment = (engine.rod_length - x) * c.pin_transverse + y * c.pin_axial  # about G: pin at (l − x, −y)
    moment += -x * c.crank_transverse - y * c.crank_axial  # crank at (−x, −y), its axial force along −x
    expected = -rod.inertia_z * c.motion.rod_acceleration
    scale = engine.rod_length * np.abs(c.crank_axial).max()
    assert np.abs(moment - expected).max() < 1e-9 * scale


@settings(max_examples=20, deadline=None)
@given(engines(friction=True), rods, st.floats(10, 900))
def test_shaking_force_is_what_bearing_wall_and_head_feel(engine, rod, speed):
    c = cycle(engine, rod, TRACE, speed, ANGLES)
    crank = c.in_engine_axes(c.crank)
    scale = np.abs(crank.x).max() + np.abs(c.gas).max()
    np.testing.assert_allclose(c.shaking_x, -crank.x - c.friction + c.gas, rtol=0, atol=1e-12 * scale)
    np.testing.assert_allclose(c.shaking_y, -crank.y - c.wall, rtol=0, atol=1e-12 * scale)


def test_engine_and_rod_axes_hold_the_same_force():
    c = cycle(LEON, LEON_ROD, TRACE, 6000 * RPM, ANGLES)
    for force in (c.pin, c.crank):
        again = to_rod_axes(c.in_engine_axes(force), c.motion.rod_angle)
        np.testing.assert_allclose(again, force, rtol=1e-12, atol=1e-7)
    np.testing.assert_allclose(c.in_engine_axes(c.pin).y, c.wall, rtol=1e-12, atol=1e-7)


# rpm, pin and crank-end tension at TDC, least crank axial (≈159°), largest crank normal: kN to 0.01.
INDEPENDENT = [
    (2000, 1.24, 2.26, -1.46, 0.67),
    (4000, 4.96, 9.03, -5.84, 2.67),
    (5700, 10.08, 18.34, -11.85, 5.43),
    (6000, 11.17, 20.32, -13.13, 6.01),
]


@pytest.mark.parametrize(("rpm", "pin", "crank", "least", "normal"), INDEPENDENT)
def test_inertia_forces_of_an_independent_calculation(rpm, pin, crank, least, normal):
    """r 48.5 mm, l 141.014 mm, no gas, no friction: to half a unit of the last printed digit."""
    engine = Engine(48.5, 141.014, 86.0, 0.434e-3)
    rod = rod_of(0.439, (36.44, 0.0), 0.00144)
    c = cycle(engine, rod, NoGas(), rpm * RPM, np.arange(0, 360, 0.1) * DEG)
    kilonewtons = [c.pin_axial[0], c.crank_axial[0], c.crank_axial.min(), np.abs(c.crank_transverse).max()]
    assert np.array(kilonewtons) / 1e3 == pytest.approx([pin, crank, least, normal], abs=0.00501)
    assert np.degrees(c.motion.crank_angle[c.crank_axial.argmin()]) == pytest.approx(159, abs=0.5)


def test_leon_at_6000_rpm_against_an_independent_calculation():
    """León 2001, published masses, bore 76 mm, no friction: kN to 0.1 at whole degrees."""
    c = cycle(LEON, LEON_ROD, TRACE, 6000 * RPM, np.arange(720) * DEG)
    extremes = [
        (c.pin_axial.max(), 31.5, c.pin_axial.argmax(), 6),
        (c.crank_axial.max(), 48.1, c.crank_axial.argmax(), 4),
        (c.pin_axial.min(), -30.2, c.pin_axial.argmin(), 474),
        (c.crank_axial.min(), -40.0, c.crank_axial.argmin(), 483),
        (c.wall.max(), 10.7, c.wall.argmax(), 466),
        (c.gas.max(), 31.8, c.gas.argmax(), 380),
        (abs(c.crank_transverse[432]), 8.0, 432, 432),
    ]
    for value, kilonewtons, angle, degrees in extremes:
        assert value / 1e3 == pytest.approx(kilonewtons, abs=0.0501)
        assert angle == degrees


def test_many_speeds_at_once_equal_one_by_one():
    speeds = np.array([800, 4000, 9000.0]) * RPM
    together = cycle(LEON, LEON_ROD, TRACE, speeds[:, None], ANGLES)
    for i, speed in enumerate(speeds):
        alone = cycle(LEON, LEON_ROD, TRACE, speed, ANGLES)
        np.testing.assert_allclose(together.torque[i], alone.torque, rtol=1e-12, atol=1e-6)
        np.testing.assert_allclose(together.crank_axial[i], alone.crank_axial, rtol=1e-12, atol=1e-9)
