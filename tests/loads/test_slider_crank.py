import math

import numpy as np
import pytest
from engines import LEON, engines
from hypothesis import given
from hypothesis import strategies as st

from geometry.errors import InvalidValue
from loads.engine import Engine, kinematics

ANGLES = np.linspace(0, 4 * np.pi, 721)


@given(engines(), st.floats(1, 1000))
def test_the_rod_keeps_its_length(engine, speed):
    k = kinematics(engine, ANGLES, speed)
    across = engine.crank_radius * np.sin(ANGLES) - engine.pin_offset
    along = k.piston_position - engine.crank_radius * np.cos(ANGLES)
    np.testing.assert_allclose(np.hypot(along, across), engine.rod_length, rtol=1e-13)
    np.testing.assert_allclose(np.sin(k.rod_angle), across / engine.rod_length, rtol=1e-12, atol=1e-14)


@given(engines(), st.floats(1, 1000))
def test_rates_are_the_derivatives(engine, speed):
    # A complex step differentiates to rounding where central differences lose half the digits.
    step = 1e-30j
    theta = ANGLES + step
    sin_b = (engine.crank_radius * np.sin(theta) - engine.pin_offset) / engine.rod_length
    position = engine.crank_radius * np.cos(theta) + engine.rod_length * np.sqrt(1 - sin_b**2)
    k = kinematics(engine, ANGLES, speed)
    scale = engine.crank_radius * speed
    np.testing.assert_allclose(
        k.piston_velocity, speed * position.imag / step.imag, rtol=1e-11, atol=1e-12 * scale
    )
    rate = speed * (np.arcsin(sin_b)).imag / step.imag
    np.testing.assert_allclose(k.rod_rate, rate, rtol=1e-11, atol=1e-12 * speed)


@given(engines(), st.floats(1, 1000))
def test_accelerations_close_over_a_turn(engine, speed):
    # Spectral derivative of a periodic function: exact while its harmonics are resolved (λ ≤ 0.8 here).
    if engine.crank_radius + abs(engine.pin_offset) > 0.8 * engine.rod_length:
        return
    n = 512
    k = kinematics(engine, 2 * np.pi * np.arange(n) / n, speed)
    waves = 1j * np.fft.fftfreq(n, 1 / n) * speed

    def derivative(values):
        return np.fft.ifft(waves * np.fft.fft(values)).real

    for value, rate in ((k.piston_velocity, k.piston_acceleration), (k.rod_rate, k.rod_acceleration)):
        np.testing.assert_allclose(derivative(value), rate, atol=1e-9 * np.abs(rate).max(), rtol=0)


def test_a_long_rod_gives_a_pure_cosine():
    # The second harmonic is λ of the first: with λ = 1e-6 the sine is left to 1e-6.
    engine = Engine(47.0, 47e6, 76.0, 1e-3)
    k = kinematics(engine, ANGLES, 100.0)
    np.testing.assert_allclose(
        k.piston_acceleration, -47 * 100.0**2 * np.cos(ANGLES), atol=47e4 * 1.1e-6, rtol=0
    )


def test_a_short_rod_snaps_through():
    # β̇ = λω cos θ/cos β and at λ = 0.95 the rod lies nearly across at 90°: β̈ = −λω²/√(1−λ²).
    k = kinematics(Engine(95.0, 100.0, 76.0, 1e-3), np.pi / 2, 10.0)
    assert k.rod_acceleration == pytest.approx(-0.95 * 100 / math.sqrt(1 - 0.95**2), rel=1e-12)


def test_dead_centres():
    k = kinematics(LEON, np.array([0, np.pi]), 1.0)
    np.testing.assert_allclose(k.piston_position, [188, 94], rtol=1e-14)
    # a = −rω²(1 + λ) and rω²(1 − λ) in engine axes, exact at dead centre.
    np.testing.assert_allclose(k.piston_acceleration, [-47 * 4 / 3, 47 * 2 / 3], rtol=1e-13)


def test_speeds_broadcast_against_angles():
    k = kinematics(LEON, ANGLES, np.array([[100.0], [200.0]]))
    assert k.piston_acceleration.shape == (2, 721)
    np.testing.assert_allclose(k.piston_acceleration[1], 4 * k.piston_acceleration[0], rtol=1e-14)


@pytest.mark.parametrize("speed", [-1.0, math.nan, math.inf])
def test_bad_speed_is_refused(speed):
    with pytest.raises(InvalidValue, match="crank speed"):
        kinematics(LEON, ANGLES, speed)


def test_bad_angle_is_refused():
    with pytest.raises(InvalidValue, match="crank angle"):
        kinematics(LEON, [0.0, math.nan], 1.0)
