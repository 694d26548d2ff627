"""What is free, between which bounds, and what is refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fea.analysis.collapse import weaker_in_turns
from fea.analysis.defects import with_defects
from fea.analysis.overload import with_overload
from fea.analysis.pipeline import prepare, solve_speed, with_cycle
from fea.apps.optimise.problem import DesignConstraint, constraints, required, variables
from fea.apps.optimise.run_optimise import search_study
from fea.study.material_table import MaterialTable
from fea.study.option_tables import MeshTable, OptimiseTable, parse_free
from fea.study.overload_table import OverloadTable
from fea.study.study import load_study, parse_study
from geometry.errors import InvalidValue
from geometry.section import walls

LEON = load_study("leon-2001")


def free(**bounds):
    return replace(LEON, optimise=OptimiseTable(free=bounds))


def refused(text):
    with pytest.raises(InvalidValue) as caught:
        variables(parse_study(f'[rod]\npreset = "leon-2001"\n[optimise]\n{text}', "own", Path.cwd()))
    return str(caught.value)


def test_without_a_table_the_sizes_of_shank_and_rings_are_free():
    found = variables(LEON)
    assert "web_thickness_mm" in found.keys
    assert "big_end_ring_mm" in found.keys
    rod = LEON.rod.dimensions
    assert found.dimensions(found.start) == pytest.approx(
        {key: getattr(rod, key.removesuffix("_mm")) for key in found.keys}, rel=1e-12
    )
    assert found.least_wall == min(3.0, *walls(rod).values())
    assert (found.low >= found.least_wall).all()


def test_a_rectangular_shank_has_no_web():
    found = variables(LEON.with_rod(shank_section="rectangular"))
    assert not {"web_thickness_mm", "flange_thickness_mm"} & set(found.keys)
    with pytest.raises(InvalidValue, match="no effect"):
        variables(free(web_thickness_mm=(3.0, 7.0)).with_rod(shank_section="rectangular"))
    assert "web_thickness_mm" in variables(LEON.with_rod(shank_section="H")).keys
    bounds = {"shank_bore_mm": (4.0, 6.0), "pocket_setback_mm": (3.0, 5.0)}
    bored = free(**bounds).with_rod(shank_section="tubular", shank_bore_mm=5.0)
    assert variables(bored).keys == tuple(bounds)


@settings(max_examples=25)
@given(st.lists(st.floats(-0.5, 1.5), min_size=7, max_size=7))
def test_the_nearest_rod_that_can_be_drawn_is_sound(x):
    found = variables(LEON)
    near = found.nearest_feasible(np.array(x), found.start)
    assert not found.fault(near)
    if not found.fault(np.array(x)):
        assert np.array_equal(near, x)


def test_what_cannot_be_free_is_refused():
    assert "Did you mean web_thickness_mm" in refused("free = { web_thicknes_mm = [3.0, 7.0] }")
    assert "piston pin" in refused("free = { length_mm = [130.0, 150.0] }")
    assert "must rise" in refused("free = { web_thickness_mm = [7.0, 3.0] }")
    assert "two lengths" in refused("free = { web_thickness_mm = [7.0] }")
    assert "must be a table" in refused("free = 3")
    assert "Widen the bounds" in refused("free = { web_thickness_mm = [6.0, 7.0] }")
    assert "feature is left out" in refused("free = { oil_hole_mm = [2.0, 4.0] }")
    assert "its flange is" in refused("least_wall_mm = 4.0")
    assert "must lie between 20" in refused("evaluations = 3")
    assert "must be positive" in refused("min_fatigue_safety = 0.0")


def test_free_dimensions_of_the_command_line():
    assert parse_free(["web_thickness_mm=3:7", "big_end_ring_mm = 6.5:1e1"]) == {
        "web_thickness_mm": (3.0, 7.0),
        "big_end_ring_mm": (6.5, 10.0),
    }
    for text in (
        "web_thickness_mm",
        "web_thickness_mm=3",
        "=3:4:5",
    ):
        with pytest.raises(InvalidValue, match="as web_thickness_mm=3:7"):
            parse_free([text])
    for bound in ("x", "3-4"):
        with pytest.raises(InvalidValue, match=r"a number and its unit|cannot be read"):
            parse_free([f"web_thickness_mm=3:{bound}"])
    with pytest.raises(InvalidValue, match="twice"):
        parse_free(["a=1:2", "a=1:3"])


def test_required_factors_are_those_of_the_study_unless_given():
    asked = replace(LEON, analysis=replace(LEON.analysis, min_safety=1.4))
    assert required(LEON)["fatigue"] == 1.0
    assert required(asked)["buckling"] == 1.4
    table = OptimiseTable(min_fatigue_safety=1.7)
    assert required(replace(asked, optimise=table))["fatigue"] == 1.7
    assert required(replace(asked, optimise=table))["yielding"] == 1.4


def test_a_limit_counts_less_its_bar():
    limit = DesignConstraint("yielding, shank", 1.2, 4.0, 1.1)
    assert limit.low == pytest.approx(1.2 / 1.04)
    assert limit.margin == pytest.approx(1 - 1.1 * 1.04 / 1.2)
    assert DesignConstraint("yielding, shank", 1.2, 10.0, 1.1).margin < 0


def test_what_a_search_cannot_do_is_refused():
    with pytest.raises(InvalidValue, match="every design would take minutes"):
        search_study(load_study("leon-2001-bolted"))
    with pytest.raises(InvalidValue, match="has neither"):
        search_study(parse_study('[rod]\npreset = "leon-2001"\n', "bare", Path.cwd()))
    assert search_study(LEON).analysis.cycle
    assert search_study(load_study("columba-2022")).rod.mass is None
    faster = replace(LEON, optimise=OptimiseTable(min_rpm=7500.0))
    assert search_study(faster).speeds() == (*LEON.speeds(), 7500.0)
    assert search_study(LEON).analysis.tolerance_percent == 2.0
    with pytest.raises(InvalidValue, match=r"has a place, which cannot stay where it is.*Leave out @x,y,z"):
        search_study(LEON.with_(defect={"size": "0.2x3@70,6,0"}))


def test_the_bowed_shank_and_what_an_overload_leaves_are_constraints():
    """Collapse by the buckling factor, without a bar; set and overload once they have been followed."""
    study = replace(
        LEON,
        mesh=MeshTable(size_mm=14.0),
        analysis=replace(LEON.analysis, pressure="cosine-180"),
        overload=OverloadTable(force_N=60e3),  # more than yield strength times least area
    )
    rod = prepare(study)
    solved = solve_speed(rod, 6000.0)
    asked = {"yielding": 1.0, "buckling": 1.3}
    found = {one.name: one for one in constraints(rod, [solved], asked)}
    pushed = -min(solved.loads.cases.pin_axial.min(), solved.loads.cases.crank_axial.min())
    assert found["collapse"].factor * pushed == pytest.approx(weaker_in_turns(rod).limit)
    assert (found["collapse"].required, found["collapse"].error_percent) == (1.3, 0.0)
    assert "overload" not in found
    overloaded = with_overload(rod, solved)
    after = {one.name: one for one in constraints(rod, [overloaded], asked)}
    assert after["overload"].margin < 0
    assert after["overload"].factor == pytest.approx(float(overloaded.overload.safety_factor))


def test_hours_stand_in_place_of_the_factor_against_fatigue():
    table = OptimiseTable(min_hours=200.0)
    assert required(replace(LEON, optimise=table)) == {"yielding": 1.0, "buckling": 1.0, "hours": 200.0}
    both = replace(table, min_fatigue_safety=1.1)
    assert required(replace(LEON, optimise=both))["fatigue"] == 1.1
    unknown = replace(LEON, optimise=table, material=replace(LEON.material.resolved(), ultimate_MPa=None))
    with pytest.raises(InvalidValue, match=r"optimise.min_hours = 200: needs an \[engine\], and a material"):
        search_study(unknown)


def test_stress_may_grow_until_the_rod_lasts_the_hours():
    """More of it for few hours than by the endurance limit, and as much for very many."""
    study = replace(
        LEON,
        material=MaterialTable(preset="forged-steel-2005"),
        mesh=MeshTable(size_mm=14.0),
        analysis=replace(LEON.analysis, cycle=True, pressure="cosine-180"),
    )
    rod = prepare(study)
    results = [with_cycle(rod, solve_speed(rod, 6000.0))]
    # A flaw that grows is a constraint as well.
    flawed = replace(rod, study=study.with_(defect={"size": "0.1x3"}))
    (flaw,) = (
        one
        for one in constraints(rod, [with_defects(flawed, results[0])], {"yielding": 1.0, "buckling": 1.0})
        if one.name == "crack growth"
    )
    assert flaw.margin < 0
    assert flaw.required == 1.0

    def least(**modes):
        found = constraints(rod, results, {"yielding": 1.0, "buckling": 1.0, **modes})
        name = "fatigue" if "fatigue" in modes else f"life of {modes['hours']:g} h"
        return {one.name.partition(", ")[2]: one for one in found if one.name.startswith(name)}

    fatigue, hour, forever = least(fatigue=1.2), least(hours=1.0), least(hours=1e9)
    assert fatigue.keys() == hour.keys() == {"big end", "shank", "small end"}
    for place, one in fatigue.items():
        assert forever[place].factor == pytest.approx(one.factor, rel=1e-9)
        assert hour[place].factor > 1.01 * one.factor
        assert (one.required, hour[place].required) == (1.2, 1.0)
