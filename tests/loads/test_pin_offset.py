"""What the sign of `pin_offset_mm` means: the cylinder axis lies where the crank pin is after TDC."""

import dataclasses
import math

import numpy as np
import pytest

from fea.base.units import RPM
from fea.study.study import load_study
from geometry.mass import MassProperties
from loads.dynamics import cycle
from loads.engine import Engine, kinematics

CENTRED = Engine(crank_radius=47.0, rod_length=141.0, bore=76.0, piston_mass=1e-3)
SHIFTED = dataclasses.replace(CENTRED, pin_offset=10.0)
OPPOSITE = dataclasses.replace(CENTRED, pin_offset=-10.0)
ROD = MassProperties(1e-9, (50.0, 0.0, 0.0), ((0.0,) * 3, (0.0,) * 3, (0.0, 0.0, 1e-9)))
EXPANSION = np.radians(np.arange(361.0, 540.0))


def test_the_piston_is_highest_after_the_crank_pin_passes_the_parallel_to_the_cylinder():
    late = math.asin(10.0 / (47.0 + 141.0))
    for engine, top in ((SHIFTED, late), (CENTRED, 0.0), (OPPOSITE, -late)):
        angles = np.linspace(-0.2, 0.2, 40_001)
        height = kinematics(engine, angles, 0.0).piston_position
        assert angles[height.argmax()] == pytest.approx(top, abs=1e-5)
        assert height.max() == pytest.approx(engine.top_position, rel=1e-9)


def test_a_positive_offset_makes_the_rod_steeper_in_expansion_and_the_wall_force_smaller():
    """Gas alone: the wall carries p A tan β, with sin β = (r sin θ − e)/l."""

    class Gas:
        samples = np.empty(0)

        def pressure(self, crank_angle, _speed):
            return np.ones_like(crank_angle)

    mean = {}
    for engine in (SHIFTED, CENTRED, OPPOSITE):
        found = cycle(engine, ROD, Gas(), 1.0 * RPM, EXPANSION)
        sin = (47.0 * np.sin(EXPANSION) - engine.pin_offset) / 141.0
        expected = engine.piston_area * np.tan(np.arcsin(sin))
        np.testing.assert_allclose(found.wall, expected, rtol=1e-4, atol=1e-2)
        mean[engine.pin_offset] = np.abs(found.wall).mean()
    assert mean[10.0] < mean[0.0] < mean[-10.0]


def test_the_key_of_the_study_has_that_sign():
    table = dataclasses.replace(load_study().engine, pin_offset_mm=10.0)
    engine = table.engine(141.0)
    quarter = kinematics(engine, math.pi / 2, 0.0)
    assert math.sin(quarter.rod_angle) == pytest.approx((47.0 - 10.0) / 141.0)
