"""What is said of factors from stress with errors holds for every stress within these."""

import numpy as np
import pytest

from fea.analysis.cycle.criteria import WITHIN, crossland_bounds, fatigue_bounds, yield_bounds
from fea.analysis.cycle.rows import PartRows
from fea.base.choices import Fatigue
from fea.judge.history import deviator_norm
from fea.study.study import load_study

PLACES, INSTANTS = 400, 50


@pytest.fixture
def drawn():
    """Rows of the default material, their true histories, estimates of these, and their errors."""
    rng, part = np.random.default_rng(7), object.__new__(PartRows)
    part.material, part._criterion = load_study("leon-2001").materials(["rod"])[0], Fatigue.GOODMAN
    part._surface = rng.uniform(0.2, 1.0, PLACES)
    turn = np.linspace(0, 2 * np.pi, INSTANTS)
    shape = rng.normal(size=(PLACES, 6, 2)) * [1, 0.8]  # far from proportional
    truth = 50 * (shape @ np.stack([np.cos(turn) + 0.4, np.sin(2 * turn)]))
    truth[:, 5] *= 0.1
    errors = rng.uniform(0, 8, (2, PLACES, INSTANTS)) * (rng.random(INSTANTS) < 0.7)
    errors[1] *= 0.1
    away = rng.normal(size=truth.shape)
    away[:, :5] *= (errors[0] / deviator_norm(away))[:, None]
    away[:, 5] = errors[1] * rng.uniform(-1, 1, errors[1].shape)
    return part, truth, truth + away, errors


@pytest.mark.parametrize("judge", [yield_bounds, fatigue_bounds, crossland_bounds])
def test_no_stress_within_its_error_has_a_smaller_factor(drawn, judge):
    part, truth, estimate, errors = drawn
    rows = np.arange(PLACES)
    exact, known = judge(part, rows, truth, 0 * errors), judge(part, rows, estimate, errors)
    assert not exact.needed.any()
    # A ball is found to a thousandth.
    assert (known.least <= exact.least * (1 + (1e-3 if judge is crossland_bounds else WITHIN))).all()
    assert np.median(known.least / exact.least) > 0.6  # and yet of use


@pytest.mark.parametrize("judge", [yield_bounds, fatigue_bounds, crossland_bounds])
def test_the_factor_is_known_once_no_instant_is_needed(drawn, judge):
    part, truth, estimate, errors = drawn
    rows, solved = np.arange(PLACES), 0
    exact = judge(part, rows, truth, 0 * errors).least
    while (needed := (known := judge(part, rows, estimate, errors)).needed).any():
        estimate = np.where(needed[:, None], truth, estimate)
        errors = np.where(needed, 0.0, errors)
        solved += needed.sum()
    assert known.least == pytest.approx(exact, rel=1.1e-3 if judge is crossland_bounds else WITHIN)
    assert solved < 0.7 * truth[:, 0].size
