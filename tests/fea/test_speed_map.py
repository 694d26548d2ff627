import numpy as np
import pytest

from fea.cycle.speed_map import critical_speed, speed_map

RPM = np.array([1000.0, 2000.0, 3000.0])


@pytest.mark.parametrize(
    ("factor", "critical"),
    [
        ([3.0, 1.5, 0.5], 2500.0),
        ([3.0, 2.0, 1.1], None),
        ([0.9, 0.8, 0.7], 1000.0),
        ([2.0, 0.5, 1.5], 1000 + 1000 * 2 / 3),  # the first crossing counts, whatever follows
        ([np.nan, np.nan, np.nan], None),
    ],
)
def test_critical_speed_is_where_the_factor_first_falls_below_one(factor, critical):
    assert critical_speed(RPM, np.array(factor)) == (None if critical is None else pytest.approx(critical))


def _summary(rpm, factor, fatigue, crossland=None):
    place = None
    if fatigue is not None:
        place = {"at_mm": [1, 2, 3], "mean_MPa": 5, "amplitude_MPa": 6, "stress_ratio": -1.0}
        place["fatigue_safety_factor"] = fatigue
    envelope = {"min_safety_factor": factor, "crank_deg": 10, "at_mm": [1, 2, 3], "fatigue": place}
    envelope["min_crossland_safety_factor"] = crossland
    return {"rpm": rpm, "envelope": envelope}


def test_map_is_sorted_by_speed_and_knows_every_failure_mode():
    found = speed_map([_summary(3000.0, 0.5, 0.4, 0.6), _summary(1000.0, 2.5, 1.6, 1.6)])
    assert list(found.columns["rpm"]) == [1000, 3000]
    assert list(found.columns["fatigue_z_mm"]) == [3, 3]
    assert list(found.columns["stress_ratio"]) == [-1, -1]
    critical = {"yield": 2500, "fatigue": 2000, "crossland": 2200}
    assert found.critical == {mode: pytest.approx(rpm) for mode, rpm in critical.items()}


def test_without_fatigue_data_only_yielding_is_mapped():
    found = speed_map([_summary(1000.0, 2.5, None)])
    assert np.isnan(found.columns["fatigue_safety_factor"]).all()
    assert found.critical == {"yield": None, "fatigue": None, "crossland": None}
    assert speed_map([{"rpm": 1000.0}]) is None
