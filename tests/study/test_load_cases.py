"""A study reduced to its load cases is a valid study, whatever the whole one asks for."""

import pytest

from fea.study.changes import load_cases_alone
from fea.study.study import load_study


@pytest.mark.parametrize(
    "asked",
    [
        {"defect": {"size": "0.2x6"}},
        {"duty": {"rpm": [5000, 6000], "hours": [1, 2]}},
        {"scatter": {"strength_percent": 5.0}},
        {"overload": {"force_N": 90e3}},
        {"output": {"pvd_step_deg": 10.0}, "analysis": {"cycle": True}},
        {"analysis": {"fretting": True}},
    ],
)
def test_what_needs_the_cycle_is_left_out(asked):
    whole = load_study("leon-2001").with_(material="4340-hrc-40", **asked)
    alone = load_cases_alone(whole, buckling=False)
    assert not alone.analysis.cycle
    assert not alone.analysis.buckling
    assert (alone.duty, alone.scatter, alone.overload, alone.defect.size) == (None,) * 4
    assert alone.rod == whole.rod
    assert alone.engine == whole.engine
