"""The crank cycles that a loading keeps."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from fea.rod import loading as loads
from fea.rod.loading import EngineLoading
from fea.study.study import load_study
from geometry.mass import MassProperties

LIGHT, HEAVY = (MassProperties(mass, (50.0, 0.0, 0.0), np.eye(3)) for mass in (5e-4, 8e-4))


@pytest.fixture
def loading():
    study = load_study("leon-2001")
    return EngineLoading.of(study.engine, study.rod.length)


def test_a_cycle_is_kept_for_its_rod_and_speed(loading):
    assert loading.crank_cycle(LIGHT, 6000.0) is loading.crank_cycle(LIGHT, 6000.0)
    assert loading.crank_cycle(LIGHT, 6000.0) is not loading.crank_cycle(LIGHT, 5000.0)


def test_the_cycle_of_a_rod_whose_place_in_memory_another_one_takes_is_not_returned(loading, monkeypatch):
    monkeypatch.setattr(loads, "id", lambda _rod: 1, raising=False)
    assert loading.crank_cycle(LIGHT, 6000.0).rod is LIGHT
    assert loading.crank_cycle(HEAVY, 6000.0).rod is HEAVY


def test_threads_get_their_cycles_while_others_are_dropped(loading, monkeypatch):
    monkeypatch.setattr(loads, "_MOST_CYCLES", 1)
    speeds = [100.0 * (number % 7 + 1) for number in range(5000)]
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda rpm: loading.crank_cycle(LIGHT, rpm).speed, speeds))
    assert found == pytest.approx([rpm * np.pi / 30 for rpm in speeds], rel=1e-12)
