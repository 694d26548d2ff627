import dataclasses
import re

import numpy as np
import pytest

from fea.analysis import pipeline, prepared_rod, refinement
from fea.analysis.meshing import mesh_study
from fea.analysis.pipeline import refined_rod, solve_speed
from fea.analysis.refinement import amplitude, edge_length, predicted_elements, size_ratio, wanted_sizes
from fea.base.choices import Element
from fea.judge.case_result import FILE_SHARE, LEAST_OF_FILE, REFINED_SHARE, Governing, bore_ends
from fea.machine.clock import Clock
from fea.study.option_tables import AnalysisTable, MeshTable
from fea.study.study import load_study
from geometry.errors import InvalidValue
from geometry.surfaces import Surface
from mesh.tetmesh import MeshError

pytestmark = pytest.mark.slow


def study(tolerance, size=None, **options):
    shipped = load_study()
    return dataclasses.replace(
        shipped,
        analysis=dataclasses.replace(
            shipped.analysis, tolerance_percent=tolerance, pressure="cosine-180", **options
        ),
        mesh=MeshTable(size_mm=size),
    )


@pytest.fixture(scope="module")
def within_six():
    said = []
    return refined_rod(study(6.0, all_cases=True), (6000.0,), Clock(), said.append), said


def test_it_refines_until_every_peak_is_within_the_tolerance(within_six):
    adapted, _ = within_six
    result = adapted.at(6000.0)
    assert not adapted.shortfall
    assert 2 <= len(adapted.passes) <= 3
    assert adapted.passes[0].error_percent > 6 >= adapted.passes[-1].error_percent
    assert max(case.error_percent for case in result.cases.values()) == adapted.passes[-1].error_percent
    assert all(case.verdict(6.0) == "converged" for case in result.cases.values())


def test_the_smallest_factor_decides_and_cases_that_cannot_govern_say_so(two_speeds):
    cases = tuple(two_speeds.at(6000.0).cases.values())
    governing = Governing.of(cases)
    least = min(cases, key=lambda case: case.min_safety_factor)
    spare = max(cases, key=lambda case: case.min_safety_factor)
    assert 1 / governing.utilisation == pytest.approx(least.min_safety_factor)
    assert governing.needed(least, 5.0) == pytest.approx(5.0)
    assert governing.needed(spare, 5.0) == pytest.approx(5.0 * governing.utilisation / spare.worst.value)
    idle = dataclasses.replace(spare, of_rod=10 * spare.of_rod)
    assert governing.needed(idle, 5.0) == pytest.approx(15.0)
    # However wide the bar of the spare case: it counts only from where it could lower the smallest factor.
    for share, verdict in ((1.0, "sufficient"), (1.2, "not converged")):
        error = np.zeros_like(spare.von_mises)
        node = spare.worst.node
        error[node] = spare.von_mises[node] * (share * governing.utilisation / spare.worst.value - 1)
        wide = dataclasses.replace(spare, von_mises_error=error)
        known = [dataclasses.replace(case, von_mises_error=np.zeros_like(error)) for case in cases[:-1]]
        known = [case for case in known if case.load.name != spare.load.name]
        found = Governing.of([*known, wide])
        assert found.percent == pytest.approx(100 * (share - 1), abs=1e-9)
        assert found.verdict(wide, 5.0) == verdict
    assert Governing.of([*known, wide]).case == spare.load.name


def test_a_draft_ends_with_the_first_mesh_and_its_bars():
    said = []
    adapted = refined_rod(study(None, draft=True), (6000.0,), Clock(), said.append)
    assert len(adapted.passes) == 1
    assert "this is a draft" in adapted.shortfall.text
    with pytest.raises(InvalidValue, match="draft"):
        study(None, size=14.0, draft=True)


def test_it_refines_where_the_peaks_are(within_six):
    adapted, _ = within_six
    mesh, result = adapted.rod.mesh, adapted.at(6000.0)
    everywhere = np.max([case.von_mises / case.peak.value for case in result.cases.values()], axis=0)
    heat = np.zeros(len(mesh.drawn.points))
    np.maximum.at(heat, mesh.drawn_node, everywhere)
    length = edge_length(mesh.drawn)
    vertices = np.isfinite(length)
    assert np.median(length[vertices & (heat > 0.9)]) < 0.4 * np.median(length[vertices & (heat < 0.5)])


def test_a_leap_to_many_elements_is_approached_by_a_mesh_between(within_six, monkeypatch):
    monkeypatch.setattr(refinement, "_MANY", 0)
    monkeypatch.setattr(refinement, "_LEAP", 1.0)
    between = refined_rod(study(6.0, all_cases=True), (6000.0,), Clock()).passes
    at_once = within_six[0].passes
    assert at_once[0].elements == between[0].elements < between[1].elements < at_once[1].elements
    assert between[-1].error_percent < 6


def test_each_pass_is_told(within_six):
    adapted, said = within_six
    draft, passes = said.pop(1), said
    assert len(passes) == len(adapted.passes)
    assert passes[0].startswith(f"pass 1: {adapted.passes[0].elements} elements, ±")
    assert re.fullmatch(
        r"draft: safety factor \d\.\d\d \(\d\.\d\d … \d\.\d\d; \w+\); refining, to about \S+ elements", draft
    )


@pytest.fixture(scope="module")
def two_speeds():
    return refined_rod(study(50.0, size=14.0), (3000.0, 6000.0), Clock())


def test_what_the_last_pass_solved_is_not_solved_again(two_speeds, monkeypatch):
    assert all(two_speeds.at(rpm).cases is two_speeds.at(rpm).cases for rpm in (3000.0, 6000.0))
    assert two_speeds.at(3000.0).rpm == 3000.0
    monkeypatch.setattr(pipeline, "MAX_KEPT_NODES", 1)
    few = refined_rod(study(50.0, size=14.0), (3000.0, 6000.0), Clock())
    assert list(few.results) == [3000.0]
    again, kept = (found.at(6000.0).cases["tension"] for found in (few, two_speeds))
    assert again.max_von_mises == pytest.approx(kept.max_von_mises, rel=1e-9)


def test_no_bar_at_the_end_of_a_bore_is_below_what_meshes_scatter_by(two_speeds):
    mesh, case = two_speeds.rod.mesh.whole, two_speeds.at(6000.0).cases["tension"]
    ends = np.intersect1d(mesh.facets[Surface.SMALL_END_BORE], mesh.facets[Surface.FREE])
    assert bore_ends(mesh)[ends].all()
    assert bore_ends(mesh).mean() < 0.3
    assert (case.von_mises_error[ends] >= 0.015 * case.von_mises[ends]).all()


def test_errors_are_smaller_on_a_mesh_that_errors_have_refined(two_speeds, monkeypatch):
    first, plain = two_speeds.rod, two_speeds.at(6000.0).cases["tension"]
    wanted = wanted_sizes(first.mesh, np.full(len(first.mesh.whole.points), 0.9))
    assert mesh_study(study(None, size=14.0), wanted=[wanted]).meshing.refined
    assert not first.mesh.meshing.refined
    meshing = dataclasses.replace(first.mesh.meshing, refined=True)
    rod = dataclasses.replace(first, mesh=dataclasses.replace(first.mesh, meshing=meshing))
    refined = solve_speed(rod, 6000.0).cases["tension"]
    rest = ~bore_ends(rod.mesh.whole) & (plain.von_mises_error > 0)
    share = refined.von_mises_error[rest] / plain.von_mises_error[rest]
    assert share == pytest.approx(REFINED_SHARE, rel=1e-6)
    assert REFINED_SHARE < FILE_SHARE < 1
    monkeypatch.setattr(type(rod.study.rod), "from_file", property(lambda _: True))
    of_file = solve_speed(rod, 6000.0).cases["tension"]
    assert np.min(of_file.von_mises_error[rest] / plain.von_mises_error[rest]) == pytest.approx(FILE_SHARE)
    assert (of_file.von_mises_error >= 0.999 * LEAST_OF_FILE * of_file.von_mises).all()


def test_a_place_whose_stress_may_rise_to_the_peak_is_refined(two_speeds):
    mesh, case = two_speeds.rod.mesh.whole, two_speeds.at(6000.0).cases["tension"]
    second = int(np.abs(case.von_mises - 0.9 * case.peak.value).argmin())
    gap = case.peak.value - case.von_mises[second]
    error = np.zeros_like(case.von_mises)
    error[second] = gap  # its sum of value and error is the peak, which is within the tolerance
    refined = size_ratio(mesh, [dataclasses.replace(case, von_mises_error=error)], 2.0)
    assert refined[second] < 1
    error[second] = gap / 2
    assert size_ratio(mesh, [dataclasses.replace(case, von_mises_error=error)], 2.0)[second] == 1


def test_a_tolerance_out_of_reach_is_said(monkeypatch):
    monkeypatch.setattr(refinement, "MAX_PASSES", 1)
    adapted = refined_rod(study(0.01, size=14.0), (6000.0,), Clock())
    assert len(adapted.passes) == 1
    note = str(adapted.at(6000.0).notes[-1])
    assert re.search(
        r"tolerance of 0\.01 % is not met \(±\S+ % in \w+, because of \(\S+, \S+, \S+\) mm\): 1 mesh", note
    )
    monkeypatch.setattr(refinement, "MAX_PASSES", 3)

    def fails(*_arguments, **_options):
        raise MeshError("overlapping facets")

    first = mesh_study(study(0.01, size=14.0))
    with monkeypatch.context() as patched:
        patched.setattr(pipeline, "adaptive_mesh", fails)
        kept = refined_rod(study(0.01, size=14.0), (6000.0,), Clock(), mesh=first)
    assert len(kept.passes) == len(kept.results) == 1
    assert "no finer mesh could be made. overlapping facets" in kept.shortfall.text
    monkeypatch.setattr(refinement, "MAX_ELEMENTS", 1000)
    assert "the limit is 1000" in refined_rod(study(0.01, size=14.0), (6000.0,), Clock()).shortfall.text


def test_without_a_tolerance_there_is_one_mesh_and_no_passes():
    adapted = refined_rod(study(None, size=14.0), (6000.0,), Clock())
    assert adapted.passes == ()
    assert adapted.at(6000.0).cases


@pytest.mark.parametrize("value", [-2.0, float("nan")])
def test_a_tolerance_is_not_negative(value):
    with pytest.raises(InvalidValue, match="tolerance_percent"):
        AnalysisTable(tolerance_percent=value)


def test_the_mesh_is_refined_to_5_percent_unless_another_is_asked_for():
    assert study(None).tolerance_percent == 5
    assert study(None, size=14.0).tolerance_percent is None
    assert study(0.0).tolerance_percent is None
    assert study(2.0, size=14.0).tolerance_percent == 2
    first_order = dataclasses.replace(study(None), mesh=MeshTable(element=Element.P1))
    assert first_order.tolerance_percent is None


def test_of_many_speeds_a_few_decide_on_the_mesh(monkeypatch):
    solved = []
    monkeypatch.setattr(
        pipeline, "solve_speed", lambda rod, rpm, **_: solved.append(rpm) or solve_speed(rod, rpm)
    )
    refined_rod(study(50.0, size=14.0), [3000.0 + 100 * n for n in range(12)], Clock())
    assert len(solved) == prepared_rod.MOST_SPEEDS
    assert {3000.0, 4100.0} < set(solved)


def test_fatigue_refines_where_the_amplitude_is_largest(two_speeds):
    mesh, cases = two_speeds.rod.mesh.whole, list(two_speeds.at(6000.0).cases.values())
    push = cases[0]
    cold = int(push.von_mises.argmin())
    # As hot as the peak in turn, by opposite stresses: twice the amplitude of what only one case loads.
    stress = push.stress.copy()
    stress[cold] = push.stress[push.peak.node]
    error = push.von_mises_error.copy()
    error[cold] = 0.1 * push.peak.value
    pull = dataclasses.replace(push, stress=-stress, von_mises_error=error)
    push = dataclasses.replace(push, stress=stress, von_mises_error=error)
    cases = [push, pull]
    static, fatigue = (
        size_ratio(mesh, cases, 5.0, fatigue=asked)[cold] for asked in ([], [amplitude(cases)])
    )
    assert fatigue < static


def test_the_prediction_counts_elements():
    mesh = mesh_study(study(None, size=14.0))
    ratio = np.where(mesh.whole.points[:, 0] > 70, 0.5, 1.0)
    wanted = wanted_sizes(mesh, ratio)
    finer = mesh_study(study(None, size=14.0), wanted=[wanted])
    predicted = predicted_elements(mesh, wanted, 0.5)
    assert predicted == pytest.approx(len(finer.whole.tets), rel=0.6)
    assert wanted_sizes(mesh, np.ones(len(mesh.whole.points))) is None
