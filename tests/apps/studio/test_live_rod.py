"""A rod under one's hands, on coarse meshes: what is solved is what a run finds, the rest is close to it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cad_files import cad_file

from fea.analysis.pipeline import RefinedRod, prepare, refined_rod, solve_speed
from fea.analysis.result import run_result
from fea.apps.studio.figures import Label, figures
from fea.apps.studio.live_rod import LiveRod, fresh, live_study
from fea.apps.studio.operating_point import OperatingPoint, applied
from fea.machine.clock import Clock
from fea.rod.discretise import moved
from fea.study.study import load_study, parse_study
from geometry.errors import InvalidValue

pytestmark = [pytest.mark.usefixtures("coarse_bores"), pytest.mark.slow]

WEB = "web_thickness_mm"


def coarse(name="leon-2001", size=24.0, pressure="cosine-180", **dimensions):
    study = load_study(name).with_rod(**dimensions)
    analysis = replace(study.analysis, pressure=pressure)
    return replace(study, mesh=replace(study.mesh, size_mm=size), analysis=analysis)


def plain():
    """León's rod without pockets in the shank: a third of the nodes."""
    return coarse(size=30.0, shank_section="rectangular")


@pytest.fixture(scope="module")
def touched():
    """León's rod, whose web has been touched."""
    rod = LiveRod(coarse())
    assert rod.frame({}, rod.operation).figures.yielding.interpolation_percent == 0
    assert rod.frame({WEB: 5.1}, rod.operation).figures is None  # nothing is extrapolated
    shares = list(rod.touch(WEB, {}, rod.operation))
    assert shares == sorted(shares)
    assert shares[-1] == 1
    return rod


def figures_of(rod, rpm):
    return figures(rod, solve_speed(rod, rpm))


def last(frames):
    *_, frame = frames
    return frame


def assert_those_of_a_run(frame, summary):
    """To rounding: every factor with its bar and place, mass, and checks."""
    found, near = {case.name: case for case in frame.figures.cases}, {"rel": 1e-9}
    assert found.keys() == summary.results.keys()
    for name, case in summary.results.items():
        assert found[name].peak_MPa == pytest.approx(case.max_von_mises_MPa, **near)
        assert found[name].factor == pytest.approx(case.min_safety_factor, **near)
        assert found[name].bar_percent == pytest.approx(case.error_percent, **near)
        assert found[name].where == case.weakest.where
    figures, cycle = frame.figures, summary.envelope
    assert figures.yielding.factor == pytest.approx(cycle.min_safety_factor, **near)
    assert figures.yielding.at_mm == pytest.approx(cycle.at_mm, abs=1e-9)
    assert figures.fatigue.factor == pytest.approx(cycle.min_fatigue_safety_factor, **near)
    assert figures.buckling.factor == pytest.approx(summary.buckling.min_safety_factor, **near)
    assert figures.mass_kg == pytest.approx(summary.rod.mass_kg, **near)
    assert figures.checks.keys() == summary.checks.keys()
    assert all(check.passed for check in figures.checks.values())


def saved(study, design, operation):
    """The study that is saved, read again, with its whole cycle."""
    text = applied(study, design, operation).text()
    again = parse_study(text, "saved", Path.cwd())
    return replace(again, analysis=replace(again.analysis, cycle=True))


def test_resting_figures_are_those_of_a_run_on_the_same_mesh(touched):
    design, operation = {WEB: 5.2}, touched.operation.changed({"rpm": 5400.0})
    first, frame = touched.exact(design, operation)
    assert first.figures.fatigue is None
    assert first.label is frame.label is Label.EXACT
    study = live_study(saved(touched.study, design, operation))
    study = replace(study, analysis=replace(study.analysis, cycle=True))
    rod = prepare(study, mesh=moved(touched._mesh, study.rod))
    adapted = RefinedRod(rod)
    assert_those_of_a_run(frame, run_result(study, adapted, adapted.at(5400.0)).summary)
    assert frame.values.max() == pytest.approx(
        max(case.von_mises.max() for case in adapted.at(5400.0).cases.values())
    )
    assert frame.points.shape == (len(frame.values), 3)
    assert touched.triangles.max() == len(frame.values) - 1
    # On a mesh of its own, within the bars of both.
    anew = figures_of(prepare(study), 5400.0)
    assert frame.figures.mass_kg == pytest.approx(anew.mass_kg, rel=1e-3)
    for one, other in zip(frame.figures.cases, anew.cases, strict=True):
        assert abs(one.factor / other.factor - 1) <= (one.bar_percent + other.bar_percent) / 100


def test_between_sampled_designs_the_estimate_bounds_the_error(touched):
    for web in (4.4, 4.83, 5.15, 5.6):
        shown = touched.frame({WEB: web}, touched.operation)
        solved = next(touched.exact({WEB: web}, touched.operation)).figures
        for one, other in zip(shown.figures.cases, solved.cases, strict=True):
            assert abs(one.factor / other.factor - 1) <= one.interpolation_percent / 100 + 1e-6, (
                web,
                one,
            )
            assert one.bar_percent - one.interpolation_percent == pytest.approx(other.bar_percent, rel=0.05)
            assert one.at_mm == pytest.approx(other.at_mm, abs=0.1)
        assert 0 < shown.figures.yielding.interpolation_percent < 0.5
        assert shown.label is Label.INTERPOLATED
        assert shown.figures.checks is None
        assert shown.figures.governing == solved.governing
        assert shown.figures.mass_kg == pytest.approx(solved.mass_kg, rel=1e-4)
        assert shown.figures.buckling.factor == pytest.approx(solved.buckling.factor, rel=1e-3)
    assert touched.frame({WEB: 6.3}, touched.operation).figures is None
    ranges = touched.ranges({})
    assert (ranges[WEB].covered_low, ranges[WEB].covered_high) == pytest.approx((4.25, 5.75))
    assert ranges["length_mm"].covered_low is None


def test_what_two_dimensions_do_together_is_within_the_estimate():
    rod, flange = LiveRod(coarse()), "flange_thickness_mm"
    for name in (WEB, flange):
        list(rod.touch(name, {}, rod.operation))
    design = {WEB: 4.4, flange: 2.7}
    shown = rod.frame(design, rod.operation).figures.yielding
    solved = next(rod.exact(design, rod.operation)).figures.yielding
    assert 0 < abs(shown.factor / solved.factor - 1) <= shown.interpolation_percent / 100


def test_speed_charge_masses_and_strengths_follow_at_once(touched):
    before = touched.operation
    operation = before.changed({"rpm": 5000.0, "gas_scale": 1.2, "piston_mass_kg": 1.1, "E_GPa": 190.0})
    shown = touched.frame({}, operation).figures
    solved = last(touched.exact({}, operation)).figures
    for one, other in zip(shown.cases, solved.cases, strict=True):
        assert one.peak_MPa == pytest.approx(other.peak_MPa, rel=1e-3)
        assert abs(one.peak_MPa / other.peak_MPa - 1) <= one.interpolation_percent / 100
    assert shown.fatigue.factor == pytest.approx(solved.fatigue.factor, rel=2e-3)
    assert shown.buckling.factor == pytest.approx(solved.buckling.factor, rel=1e-6)
    stronger = touched.frame({}, before.changed({"yield_MPa": 700.0})).figures
    usual = touched.frame({}, before).figures
    assert stronger.yielding.factor == pytest.approx(usual.yielding.factor * 700 / 620.4, rel=1e-3)
    assert stronger.yielding.where == usual.yielding.where
    assert touched.frame({}, before.changed({"nu": 0.3})).figures is None  # its stresses are others


def test_a_rod_beyond_the_moved_mesh_gets_a_mesh_of_its_own():
    rod = LiveRod(coarse(size=30.0))
    design = {"length_mm": 175.0}
    frame = next(rod.exact(design, rod.operation))
    assert (frame.new_mesh, frame.base, rod.base) == (True, 1, 1)
    assert rod.triangles.max() == len(frame.points) - 1
    assert frame.points[:, 0].max() > 175.0
    assert rod.frame(design, rod.operation).figures.yielding.factor == pytest.approx(
        frame.figures.yielding.factor
    )


def test_ranges_end_where_a_rule_says_and_rods_within_can_be_drawn(touched):
    ranges = touched.ranges({})
    assert set(ranges) == {each.key for each in touched.dimensions}
    floor = ranges["pocket_floor_radius_mm"]
    assert "0.9 of the pocket's corner radius" in floor.high_reason
    assert floor.high == pytest.approx(2.16, abs=0.01)
    assert (floor.low, floor.low_reason) == (1.0, "")
    for name, own in ranges.items():
        for value in (own.low, own.high):
            touched.study.with_rod(**{name: value})


def test_peaks_of_a_case_at_two_crank_angles_are_not_mixed():
    """The largest bending of Molina's rod changes sides with its mass, and its stress by a fifth."""
    rod = LiveRod(coarse("molina-2024"))
    ring = rod.base_design["big_end_ring_mm"]
    list(rod.touch("big_end_ring_mm", {}, rod.operation))
    for share in (0.92, 1.08):
        design = {"big_end_ring_mm": share * ring}
        shown = rod.frame(design, rod.operation).figures
        solved = next(rod.exact(design, rod.operation)).figures
        one, other = (next(case for case in each.cases if case.name == "bending") for each in (shown, solved))
        assert one.peak_MPa == pytest.approx(other.peak_MPa, rel=0.02)


def test_operation_is_told_and_read_as_plain_values():
    operation = OperatingPoint.of(coarse())
    assert OperatingPoint.of(coarse()).changed(operation.values) == operation
    other = operation.changed({"rpm": 7000.0, "surface": "ground", "yield_MPa": 700.0})
    assert operation.changed(other.values) == other
    titanium = operation.changed({**operation.values, "material": "Ti-6Al-4V"})
    assert titanium.values["density_kg_m3"] == 4430.0
    assert applied(coarse(), {WEB: 5.3}, titanium).material.material().density == pytest.approx(4.43e-9)
    for wrong in ({"rpm": -1.0}, {"rpm": "fast"}, {"colour": 1.0}, {"surface": "licked"}, {"nu": 0.7}):
        with pytest.raises(InvalidValue):
            operation.changed(wrong)


def test_a_rod_from_a_file_keeps_its_shape_and_follows_its_operation(tmp_path):
    study = plain()
    path = tmp_path / "rod.step"
    path.write_bytes(cad_file(study.rod.dimensions, "step"))
    study = replace(study, rod=load_study(path).rod)
    rod = LiveRod(study)
    assert rod.dimensions == ()
    assert rod.ranges({}) == {}
    operation = rod.operation.changed({"rpm": 5000.0})
    shown = rod.frame({}, operation).figures
    frame = last(rod.exact({}, operation))
    assert shown.yielding.factor == pytest.approx(frame.figures.yielding.factor, rel=1e-3)
    again = saved(study, {}, operation)
    alone = replace(live_study(again), analysis=replace(live_study(again).analysis, cycle=True))
    adapted = refined_rod(alone, (5000.0,), Clock())
    assert_those_of_a_run(frame, run_result(alone, adapted, adapted.at(5000.0)).summary)


@pytest.mark.parametrize("pressure", ["contact", "cosine-150"])
def test_a_new_mesh_is_that_of_a_run_with_its_pins(pressure):
    study = plain()
    study = replace(study, analysis=replace(study.analysis, pressure=pressure))
    frame = fresh(study)
    assert frame.label is Label.CONVERGED
    assert frame.pins == pressure
    again = saved(study, {}, OperatingPoint.of(study))
    adapted = refined_rod(again, (6000.0,), Clock())
    assert_those_of_a_run(frame, run_result(again, adapted, adapted.at(6000.0)).summary)
    assert frame.triangles.max() == len(frame.values) - 1
    assert np.isfinite(frame.values).all()
    assert live_study(study).analysis.pin_load == pressure


def test_pins_in_contact_are_what_is_answered_first_and_what_is_interpolated_is_corrected():
    rod = LiveRod(coarse(size=30.0, pressure="contact", shank_section="rectangular"))
    operation = rod.operation
    assert rod.frame({}, operation).figures is None  # nothing that contact would change is shown
    first, resting = rod.exact({}, operation)
    run = solve_speed(prepare(live_study(rod.study), mesh=rod._mesh), operation.rpm)
    assert {first.pins, resting.pins} == {"contact"}
    assert [case.factor for case in first.figures.cases] == pytest.approx(
        [case.min_safety_factor for case in run.cases.values()], rel=1e-6
    )
    pressed = LiveRod(coarse(size=30.0, shank_section="rectangular"))
    apart = next(pressed.exact({}, operation)).figures.yielding.factor / first.figures.yielding.factor
    assert abs(apart - 1) > 0.02  # contact matters here
    shown = rod.frame({}, operation)
    assert shown.corrected
    for one, other in zip(shown.figures.cases, resting.figures.cases, strict=True):
        assert one.factor == pytest.approx(other.factor, rel=1e-6)
        assert one.peak_MPa == pytest.approx(other.peak_MPa, rel=1e-6)
        assert one.bar_percent >= other.bar_percent - 1e-6
    assert shown.figures.yielding.factor == pytest.approx(resting.figures.yielding.factor, rel=1e-6)
    assert shown.figures.fatigue.factor == pytest.approx(resting.figures.fatigue.factor, rel=1e-6)
    width = "shank_width_mm"
    list(rod.touch(width, {}, operation))
    design = {width: 1.08 * rod.base_design[width]}
    moved_on = rod.frame(design, operation).figures
    *_, solved = rod.exact(design, operation)
    for mode in ("yielding", "fatigue"):
        one, other = getattr(moved_on, mode), getattr(solved.figures, mode)
        assert one.low <= other.factor <= one.high
        assert one.interpolation_percent > 0


def test_a_rod_of_parts_says_that_it_is_answered_in_one_piece():
    study = load_study("leon-2001-bolted")
    rod = LiveRod(replace(study, mesh=replace(study.mesh, size_mm=30.0)))
    frame = next(rod.exact({}, rod.operation))
    assert (frame.one_piece, frame.pins, frame.figures.bolts) == (True, "contact", None)
