"""Where parts meet the envelope holds for both; its least safety is of the part nearer to yielding."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from fea.analysis.cycle.envelope import _judged, _worse, with_cases
from fea.base.choices import Fatigue
from fea.base.material import Material
from fea.judge.verdict import CAP

STEEL, BRONZE = Material(210e3, 0.3, 7.85e-9, 600.0), Material(100e3, 0.34, 8.8e-9, 40.0)
ANGLES = np.array([0.0, 1.0, 2.0])


def _of(von_mises, instant, material, number):
    stress = np.asarray(von_mises, float)
    reach = SimpleNamespace(
        von_mises=stress,
        instant=np.asarray(instant),
        principal_1=stress,
        principal_3=-stress,
        mean=0 * stress,
        amplitude=stress,
        ratio=-np.ones_like(stress),
        radius=stress,
        tension=stress,
    )
    return _judged(reach, ANGLES, material, Fatigue.GOODMAN, number)


@pytest.fixture
def met():
    # A node of steel alone, a shared one, a node of bronze alone.
    steel = _of([300.0, 200.0, np.nan], [1, 1, 0], STEEL, 0)
    return _worse(steel, _of([np.nan, 30.0, 20.0], [0, 2, 2], BRONZE, 1))


def test_a_shared_node_has_the_larger_stress_and_the_lesser_factor(met):
    np.testing.assert_array_equal(met.von_mises, [300, 200, 20])
    np.testing.assert_array_equal(met.crank_angle, [1, 1, 2])
    np.testing.assert_array_equal(met.principal_3, [-300, -200, -20])
    np.testing.assert_allclose(met.safety_factor, [2, 4 / 3, 2])
    np.testing.assert_array_equal(met.usage_angle, [1, 2, 2])
    np.testing.assert_array_equal(met.part, [0, 1, 1])


def test_a_case_that_is_larger_there_moves_no_angle_of_safety(met):
    case = SimpleNamespace(
        load=SimpleNamespace(crank_angle=7.0),
        von_mises=np.array([1.0, 250.0, 30.0]),
        principal=np.zeros((3, 3)),
        of_rod=np.array([99.0, 600 / 250, 40 / 30]),
    )
    found = with_cases(met, [case])
    np.testing.assert_array_equal(found.von_mises, [300, 250, 30])
    np.testing.assert_array_equal(found.crank_angle, [1, 7, 7])
    np.testing.assert_array_equal(found.usage_angle, [1, 2, 7])
    np.testing.assert_allclose(found.safety_factor, [2, 4 / 3, 4 / 3])
    np.testing.assert_allclose(found.usage, 1 / found.safety_factor)


def test_the_worst_place_is_known_where_every_factor_is_capped():
    idle = _of([1e-3, 3e-3, 2e-3], [0, 1, 2], STEEL, 0)
    assert (idle.safety_factor == CAP).all()
    assert idle.usage.argmax() == 1
    assert idle.usage_angle[1] == 1.0


def test_mean_and_amplitude_of_a_shared_node_are_those_its_fatigue_factor_is_of():
    # Bronze is nearer to yielding at the shared node, but only of the steel are fatigue strengths known.
    steel = dataclasses.replace(STEEL, ultimate_strength=800.0, endurance_limit=250.0)
    met = _worse(
        _of([300.0, 200.0, np.nan], [1, 1, 0], steel, 0), _of([np.nan, 30.0, 20.0], [0, 2, 2], BRONZE, 1)
    )
    np.testing.assert_array_equal(met.part, [0, 1, 1])
    np.testing.assert_array_equal(met.fatigue_part, [0, 0, 1])
    np.testing.assert_array_equal(met.amplitude, [300, 200, 20])
    np.testing.assert_allclose(met.fatigue_factor[:2], 250 / met.amplitude[:2])
    # Where both are known the lesser factor counts.
    bronze = dataclasses.replace(BRONZE, ultimate_strength=90.0, endurance_limit=20.0)
    met = _worse(_of([200.0], [1], steel, 0), _of([30.0], [2], bronze, 1))
    assert (met.fatigue_part[0], met.amplitude[0]) == (1, 30)
    assert met.fatigue_factor[0] == pytest.approx(20 / 30)
