import numpy as np
import pytest
from written_figures import buckling, summary

from fea.analysis.life_figures import CycleFigures, PlaceFigures
from fea.analysis.many_speeds import case_rows, first_below, rounded, speed_map
from fea.analysis.summary_figures import BucklingModeFigures, GaugeCaseFigures, GaugeFigures

CRITICAL = {"yield": 2500.0, "fatigue": 2000.0, "crossland": None}


@pytest.mark.parametrize(
    ("factor", "first"),
    [
        ([3.0, 1.5, 0.5], 2),
        ([3.0, 2.0, 1.1], None),
        ([0.9, 0.8, 0.7], 0),
        ([2.0, 0.5, 1.5], 1),  # the first crossing counts, whatever follows
        ([np.nan, np.nan, np.nan], None),
    ],
)
def test_the_first_factor_below_one(factor, first):
    assert first_below(np.array(factor)) == first


def _summary(rpm, factor, fatigue, crossland=None, *, modes=None):
    place = None
    if fatigue is not None:
        place = PlaceFigures(
            at_mm=(1, 2, 3),
            mean_MPa=5,
            amplitude_MPa=6,
            stress_ratio=-1.0,
            fatigue_safety_factor=fatigue,
            crossland_safety_factor=crossland,
        )
    envelope = CycleFigures(
        min_safety_factor=factor,
        at_mm=(1, 2, 3),
        crank_deg=10,
        min_fatigue_safety_factor=fatigue,
        fatigue_criterion="goodman",
        fatigue=place,
        min_crossland_safety_factor=crossland,
        unit_solutions=74,
        instants=721,
    )
    found = None
    if modes is not None:
        of_gas = (BucklingModeFigures(factor=9.0, moves="sideways"),)
        found = {"compression": tuple(BucklingModeFigures(factor=f, moves="") for f in modes), "gas": of_gas}
    return summary(
        rpm=rpm, envelope=envelope, buckling=buckling(3.0, 4.0, modes=found), critical_speeds_rpm=CRITICAL
    )


def test_map_is_sorted_by_speed_and_knows_every_failure_mode():
    found = speed_map([_summary(3000.0, 0.5, 0.4, 0.6), _summary(1000.0, 2.5, 1.6, 1.6, modes=[5.0, 7.0])])
    assert list(found.columns["rpm"]) == [1000, 3000]
    assert list(found.columns["fatigue_z_mm"]) == [3, 3]
    assert list(found.columns["stress_ratio"]) == [-1, -1]
    assert list(found.columns["column_safety_factor"]) == [3, 3]
    np.testing.assert_array_equal(found.columns["buckling_factor"], [5, np.nan])
    assert found.critical == CRITICAL


def test_without_fatigue_data_only_yielding_is_mapped():
    found = speed_map([_summary(1000.0, 2.5, None)])
    assert np.isnan(found.columns["fatigue_safety_factor"]).all()
    assert np.isnan(found.columns["crossland_safety_factor"]).all()
    assert speed_map([summary()]) is None


@pytest.mark.parametrize(
    ("rpm", "said"), [(5658.3, "5660"), (13361.2, "13400"), (842.0, "842"), (36.25, "36")]
)
def test_a_critical_speed_is_told_in_three_digits(rpm, said):
    assert rounded(rpm) == said


def test_the_map_has_the_strain_of_gauges():
    strain = GaugeCaseFigures(strain_um_m=412.5, error_um_m=None)
    gauges = (GaugeFigures(name="gauge 1", at_mm=(1, 2, 3), cases={"tension": strain}),)
    titles, row = case_rows([summary(rpm=3000.0, gauges=gauges)])
    assert dict(zip(titles, row, strict=True))["gauge_1_um_m"] == "412.5"
