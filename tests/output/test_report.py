"""The report without a browser: its numbers, its words, and what it may do."""

import base64
import json
import re
import zlib
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reports import HOSTILE, SIZE, reported_rod

from fea.analysis.motion import SolvedInstant, agreeing
from fea.analysis.result import WhatIf
from fea.analysis.summary_figures import (
    AssemblyFigures,
    BoltCaseFigures,
    BoltsFigures,
    FaceCaseFigures,
    FitFigures,
    JointCaseFigures,
    JointFigures,
)
from fea.apps.export_run import report_run
from fea.base.units import DEG
from fea.output.folder import SUMMARY, PictureError, is_earlier_run
from fea.output.plots.chart import chart, log_chart
from fea.output.report.assumptions import limits
from fea.output.report.page import open_report, page, still
from fea.output.report.scene import scene
from fea.output.report.surface import HOLE, NumberedSurface, Packer, corner_steps
from fea.output.stored_run import read_run
from fea.output.units import figure, named
from fea.solid.stress import von_mises
from fea.study.study import load_study
from geometry.errors import InvalidValue
from mesh.tetmesh import boundary_facets


def packed_scene(text):
    """The header of the rod in three dimensions, from the page."""
    packed = re.search(r'id="scene">(.*?)</script>', text, re.DOTALL)[1]
    return json.loads(zlib.decompress(base64.b64decode(packed)))


@pytest.fixture(scope="module", autouse=True)
def undrawn():
    """A machine that cannot draw: a picture takes seconds, and others look at it."""

    def refuse(_pictures):
        raise PictureError("no picture")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fea.output.report.page.draw_pictures", refuse)
        patch.setattr("fea.apps.export_run.ready_to_draw", nullcontext)
        patch.setattr("fea.apps.export_run.what_if", lambda _run, _clock: WhatIf())
        patch.setattr("fea.apps.what_if.solve.what_if", lambda _run, _clock: WhatIf())
        yield


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    _, result, _, _ = reported_rod()
    return result.write(tmp_path_factory.mktemp("report") / "run", report=True)


@pytest.fixture(scope="module")
def text(written):
    return (written / "report.html").read_text(encoding="utf-8")


def test_the_modes_give_the_directly_solved_cycle():
    _, result, degrees, (stress, moved) = reported_rod()
    found = result.motion
    peak = max(np.nanmax(von_mises(stress[..., k])) for k in range(len(degrees)))
    for k, angle in enumerate(degrees):
        apart = von_mises(found.stress(angle * DEG)) - von_mises(stress[found.nodes][..., k])
        assert np.abs(apart).max() < 1.5e-3 * peak  # the rest of 2e-3 is for the 16 bits of the page
        away = found.displacement(angle * DEG) - moved[found.nodes][..., k]
        assert np.abs(away).max() < 2e-3 * np.abs(moved).max()
    assert found.error < 1e-3
    assert found.even.stress.shape[2] + found.odd.stress.shape[2] < 40


def test_a_motion_is_compared_with_what_is_solved():
    _, result, degrees, (stress, moved) = reported_rod()
    right = result.motion
    known = [
        SolvedInstant(angle * DEG, von_mises(stress[..., k]), moved[..., k])
        for k, angle in enumerate(degrees[:3])
    ]
    assert agreeing(right, known) == (right, "")
    slid = replace(right, even=replace(right.even, displacement=1.1 * right.even.displacement))
    without, why = agreeing(slid, known)
    assert not why
    assert not without.moves
    assert not without.displacement(0.0).any()
    header = scene(replace(result, motion=without)).header
    assert "displacement" not in {field["name"] for field in header["results"][-1]["fields"]}
    wrong = replace(right, even=replace(right.even, stress=1.1 * right.even.stress))
    assert agreeing(wrong, known)[0] is None


def unpacked(packer, parents):
    """Decode what a packer holds, as the page does."""
    data, found, offset = zlib.decompress(base64.b64decode(packer.text())), {}, 0
    for entry in packer.entries:
        count, columns = entry["count"], []
        for _ in range(entry["columns"]):
            low, high = (np.frombuffer(data, np.uint8, count, offset + k * count).astype(int) for k in (0, 1))
            zigzag, q = low | high << 8, np.zeros(count, int)
            for i, (first, second) in enumerate(parents):
                predicted = 0 if first < 0 else (q[first] + q[second]) >> 1
                q[i] = (predicted + ((zigzag[i] >> 1) ^ -(zigzag[i] & 1))) & 0xFFFF
            columns.append(q)
            offset += 2 * count
        q = np.stack(columns, axis=1)
        if entry["kind"] == "values":
            found[entry["name"]] = np.where(q == HOLE, np.nan, entry["low"] + entry["step"] * q)
        else:
            found[entry["name"]] = (q - 2**15) * entry["step"]
    return found


@given(
    st.lists(st.one_of(st.floats(-1e9, 1e9), st.just(float("nan"))), min_size=1, max_size=30),
    st.integers(1, 2**16 - 2),
    st.randoms(),
)
def test_packed_numbers_come_back_within_half_a_step(values, levels, random):
    parents = np.array(
        [[random.randint(-1, i - 1), random.randint(0, max(i - 1, 0))] for i in range(len(values))]
    )
    packer, given_ = Packer(), np.array(values)
    packer.values("a", given_, parents, levels=levels)
    found = unpacked(packer, parents)["a"][:, 0]
    known = given_[np.isfinite(given_)]
    assert np.array_equal(np.isnan(found), np.isnan(given_))
    if known.size:
        half = np.ptp(known) / levels / 2
        assert (
            np.abs(found - given_)[np.isfinite(given_)].max()
            <= half * (1 + 1e-6) + 1e-9 * np.abs(known).max()
        )


@given(st.lists(st.integers(-30_000, 30_000), min_size=1, max_size=30), st.floats(1e-6, 1e6))
def test_multiples_of_a_step_come_back(steps, step):
    parents = np.array([[i - 1, max(i - 2, 0)] for i in range(len(steps))])
    packer = Packer()
    packer.steps("a", step * np.array(steps, float), parents, step)
    assert unpacked(packer, parents)["a"][:, 0] == pytest.approx(step * np.array(steps))


def test_the_surface_is_rebuilt_from_its_corners():
    _, result, _, _ = reported_rod()
    surface = NumberedSurface.of(result.mesh)
    facets = boundary_facets(result.mesh.tets)
    assert set(surface.nodes) == set(np.unique(facets))
    assert {tuple(sorted(row)) for row in surface.nodes[surface.facets]} == {
        tuple(sorted(r)) for r in facets[:, :3]
    }
    own = np.arange(len(surface.nodes))
    assert (surface.parents < own[:, None]).all()
    assert (surface.parents[1:] >= 0).all()
    steps, found, following = corner_steps(surface.facets), [], 0
    for step in steps:
        found.append(following - step)
        following += step == 0
    assert np.array_equal(np.reshape(found, (-1, 3)), surface.facets)
    middle = result.mesh.points[surface.nodes[surface.parents]].mean(axis=1)  # of the ends of its edge
    between = np.arange(len(own)) > surface.facets.max()
    apart = np.linalg.norm(middle - result.mesh.points[surface.nodes], axis=1)[between]
    assert apart.max() < 0.2 * SIZE


def test_a_surface_that_is_too_large_keeps_its_vertices():
    _, result, _, _ = reported_rod()
    whole, corners = NumberedSurface.of(result.mesh), NumberedSurface.of(result.mesh, most=100)
    assert (whole.order, corners.order) == (2, 1)
    assert np.array_equal(whole.facets, corners.facets)
    assert len(corners.nodes) == whole.facets.max() + 1


def test_a_page_that_would_be_too_large_keeps_the_corners(monkeypatch):
    _, result, _, _ = reported_rod()
    run = result
    whole = scene(run)
    monkeypatch.setattr("fea.output.report.scene._LARGEST", len(whole.numbers) - 1)
    small = scene(run)
    assert whole.complete
    assert not small.complete
    assert len(small.numbers) < 0.5 * len(whole.numbers)


def test_the_page_asks_for_nothing_and_may_not(text):
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text)[1]
    assert "default-src &#39;none&#39;" in policy
    assert "connect-src &#39;none&#39;" in policy
    assert "unsafe" not in policy
    assert not re.findall(r'(?:src|href)="(?!#|data:)', text.replace(HOSTILE, ""))
    assert not re.search(
        r"\bstyle=|\bon\w+=\"(?!window)", re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    )
    assert "http:" not in text.replace("http://www.w3.org", "")
    assert "https:" not in text


def test_a_hostile_name_is_text(text):
    assert HOSTILE not in text
    assert "&lt;/script&gt;&lt;img" in text
    scene = packed_scene(text)
    assert {result["id"] for result in scene["results"]} >= {"tension", "envelope", "cycle"}


def test_the_report_is_small_and_says_what_the_run_found(written, text):
    summary = json.loads((written / SUMMARY).read_text())
    assert "report.html" in summary["files"]
    assert len(text) < 2e6
    for said in (
        "By assumed proportions: the rod does not survive",
        "inertia relief",
        "León 2001",
        "half a cosine of pressure over 180°",
    ):
        assert said in text, said
    assert f"{summary['results']['tension']['max_von_mises_MPa']:.1f}" in text
    for check in summary["checks"]:
        assert text.count("passed") >= len(summary["checks"]), check
    assert "fea run study.toml --report" in text


def test_a_report_of_a_run_on_disk_says_the_same(written, tmp_path, text):
    again = read_run(written)
    _, result, _, _ = reported_rod()
    assert again.files
    assert again.summary.survival.text == result.summary.survival.text
    assert again.bores == tuple(pytest.approx(bore, abs=0.02) for bore in result.bores)
    assert list(again.forces["pin_axial_N"]) == pytest.approx(
        list(result.forces["pin_axial_N"]), rel=1e-5, abs=1
    )
    plain = re.sub(r"<script.*", "", text, flags=re.DOTALL)
    run = replace(again, motion=result.motion)
    without = page(run, scene(run), None, written)  # whose study the commands name
    shown = [re.findall(r">([^<>]+)<", part.partition('id="limits"')[0]) for part in (plain, without)]
    assert shown[0] == shown[1]


def test_fea_report_solves_the_cycle_again(written):
    (written / "report.html").unlink()
    assert report_run(written) == [written / "report.html"]
    text = (written / "report.html").read_text(encoding="utf-8")
    scene = packed_scene(text)
    assert scene["results"][-1]["kind"] == "cycle"
    assert scene["results"][-1]["error"] < 1e-3
    assert is_earlier_run(written)
    with pytest.raises(InvalidValue, match="not a directory"):
        report_run(written / "nowhere")


def test_a_run_that_cannot_be_solved_again_has_no_slider(written, monkeypatch):
    def refuse(_run):
        raise InvalidValue("RUN", "run", "was loaded with other forces")

    monkeypatch.setattr("fea.apps.export_run.prepared_again", refuse)
    report_run(written)
    text = (written / "report.html").read_text(encoding="utf-8")
    assert "There is no crank-angle slider: the cycle could not be solved again" in text
    assert "was loaded with other forces" in text
    assert 'data-part="play"' not in text


def test_a_cycle_that_comes_out_otherwise_is_not_shown(written, monkeypatch):
    rod, result, _, _ = reported_rod()
    other = replace(result.motion, even=replace(result.motion.even, stress=1.1 * result.motion.even.stress))
    monkeypatch.setattr("fea.apps.export_run.prepared_again", lambda _run: rod)
    monkeypatch.setattr("fea.apps.export_run.motion", lambda *_: other)
    report_run(written)
    text = (written / "report.html").read_text(encoding="utf-8")
    assert "solved again, its stress differs from the load cases by " in text


def test_a_run_without_fields_has_a_report_without_the_rod():
    _, result, _, _ = reported_rod()
    text = page(replace(result, speed=None, motion=None), None, None)
    assert scene(replace(result, speed=None, motion=None)) is None
    assert "This run has no fields to draw" in text
    assert "<canvas" not in text
    assert "script-src &#39;none&#39;" in text


def test_the_still_picture_is_that_of_the_worst_case(written, monkeypatch):
    _, result, _, _ = reported_rod()
    drawn = []

    def draw(pictures):
        drawn.extend(pictures)
        pictures[0].png.write_bytes(b"PNG")

    monkeypatch.setattr("fea.output.report.page.draw_pictures", draw)
    run = result
    assert still(written, run.summary) == b"PNG"
    assert drawn[0].vtu == written / f"{result.summary.worst_case}.vtu"
    (written / f"{result.summary.worst_case}.png").write_bytes(b"there already")
    assert still(written, run.summary) == b"there already"


def test_only_reports_are_opened(written, tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", lambda url: opened.append(url) or True)
    open_report(written / "report.html")
    assert opened == [(written / "report.html").as_uri()]
    (tmp_path / "other.html").write_text("<html></html>")
    with pytest.raises(InvalidValue, match="not a report of fea"):
        open_report(tmp_path / "other.html")


def test_a_failed_check_stands_first():
    _, result, _, _ = reported_rod()
    checks = dict(result.checks)
    checks["mesh_mass"] = replace(checks["mesh_mass"], value=1.0)
    doubtful = replace(result, summary=replace(result.summary, trusted=False, checks=checks))
    text = page(doubtful, None, None)
    assert text.index("Not to be trusted: the check “mesh mass” failed") < text.index("<table")
    assert "FAILED" in text


def test_the_limits_are_those_of_the_run():
    _, result, _, _ = reported_rod()
    run = result
    assert not any("finite life" in limit for limit in limits(run))  # hours stand in the report
    endless = replace(run.summary.envelope, life=None)
    unknown = replace(run, summary=replace(run.summary, envelope=endless))
    assert any("finite life" in limit for limit in limits(unknown))
    without = replace(run, summary=replace(run.summary, envelope=None))
    assert any("nothing is said about the life" in limit for limit in limits(without))
    model = replace(run.summary.model, pressure="contact")
    contact = replace(run, summary=replace(run.summary, model=model))
    assert any("oil film between pins" in limit for limit in limits(contact))


def test_an_assembled_rod_shows_its_bolts_and_its_joint():
    _, result, _, _ = reported_rod()
    bolt = BoltCaseFigures(
        at_mm=(0.0, 36.0, 0.0),
        force_N=31_200.0,
        change_N=1200.0,
        load_factor=0.2,
        bending_MPa=40.0,
        shear_N=600.0,
    )
    face = {
        "mean_pressure_MPa": 40.0, "min_pressure_MPa": 0.0, "max_pressure_MPa": 90.0, "open_percent": 3.0,
        "opening_um": 4.2, "opening_at_mm": (0.0, 25.0, 0.0), "slipping_percent": 1.0, "slip_um": 0.5,
    }  # fmt: skip
    joint = JointCaseFigures(
        **face,
        clamp_force_N=45_000.0,
        separating_N=9e3,
        edge_pressure_MPa=0.0,
        shear_N=0.0,
        slip_reserve=None,
    )
    bolts = BoltsFigures(
        thread="M8 10.9", preload_N=30_000.0, proof_load_N=33_700.0, vdi_load_factor=0.18,

        max_force_N=31_200.0,
        max_case="tension", max_crank_deg=None, min_force_N=30_000.0, amplitude_N=600.0, tightening_use=0.9,
        proof_use=0.93, yield_safety_factor=1.17, alternating_stress_MPa=16.4, endurance_MPa=53.0,
        fatigue_safety_factor=3.23, seat_pressure_MPa=310.0, max_bending_MPa=40.0,
        bending_yield_safety_factor=1.1, bending_alternating_stress_MPa=30.0,
        bending_fatigue_safety_factor=2.1, seat_lift_ratio=0.2, hole_play_mm=0.1, shear_N=600.0,
        shear_MPa=12.0, by_case={"tension": (bolt, bolt)},
    )  # fmt: skip
    found = AssemblyFigures(
        parts=("rod", "cap", "bushing"),
        temperature_C=20.0,
        bolts=bolts,
        joint=JointFigures(friction=0.15, by_case={"tension": joint}),
        fits={"bushing": FitFigures(interference_mm=0.04, by_case={"tension": FaceCaseFigures(**face)})},
        ovality={},
    )
    run = replace(result, summary=replace(result.summary, assembly=found))
    text = page(run, None, None)
    said_of = ("Bolts, joint and fits", "Bolts, M8 10.9, by VDI 2230", "Fit of the bushing")
    for said in (*said_of, "40 µm of interference", "a preload of 30 kN", "Settling and creep of the bolted"):
        assert said in text, said
    assert "cap and rod are one piece" not in text


@given(st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=50))
def test_charts_stay_within_their_frame(values):
    degrees = np.linspace(0, 720, len(values))
    drawn = chart(("a", "b", "kN"), degrees, {"": np.array(values)}, {"tension": 3.0, "side": 5.0})
    heights = [float(point.split(",")[1]) for point in drawn.lines[0].split()]
    assert min(heights) >= 25.9
    assert max(heights) <= 198.1
    assert {row for _, row, _, _ in drawn.marks} == {0, 1}  # names of neighbours do not touch


@pytest.mark.parametrize(("last", "fires"), [(720, ["firing TDC"]), (360, ["firing TDC"] * 2)])
def test_a_chart_spans_the_cycle_of_its_engine(last, fires):
    degrees = np.arange(last + 1.0)
    drawn = chart(("a", "b", "kN"), degrees, {"": degrees}, {"end": float(last)})
    assert drawn.last == last
    assert drawn.moving()["last"] == last
    assert drawn.grid[0] == (58.0, "0°")
    assert drawn.grid[-1] == (590.0, f"{last}°")
    assert drawn.marks[0][0] == drawn.curves[0][-1][0] == 590.0
    assert [name for _, name in drawn.centres if name.startswith("firing")] == fires
    assert [place for place, _ in drawn.centres] == pytest.approx(np.linspace(58, 590, last // 180 + 1))


def test_a_chart_of_a_log_runs_over_its_time_and_keeps_every_peak():
    times, values = np.arange(40.0, 160.0, 0.5), np.ones(240)
    values[101] = 7.0
    drawn = log_chart(("a", "b", "%"), times, values)
    assert [label for _, label in drawn.grid] == ["50 s", "75 s", "100 s", "125 s", "150 s"]
    assert drawn.centres == []
    assert drawn.series == ()  # the slider of the crank does not move in it
    assert min(y for _, y in drawn.curves[0]) < min(y for _, y in drawn.curves[0][:100])
    assert drawn.description == "most at 90.5 s"


def test_what_rounding_leaves_of_a_force_is_drawn_as_zero():
    drawn = chart(("a", "b", "kN"), np.linspace(0, 720, 3), {"": np.array([0, 2.39e-16, -1e-17])}, {})
    assert set(drawn.series[0]) == {0.0}
    assert drawn.description == "from 0 kN at 0° to 0 kN at 0°"


def test_words_of_keys_and_figures():
    assert named("piston_mass_kg") == ("piston mass", "kg")
    assert named("density_kg_m3") == ("density", "kg/m³")
    assert figure(-4.129e-16, 3) == "−4.13·10⁻¹⁶"
    assert figure(None) == "–"


def test_the_engine_of_the_library_names_its_sources():
    from fea.output.report.sections import input_tables

    tables = input_tables(load_study("leon-2001").with_engine("toyota-2jz"))
    (engine,) = (table for table in tables if table.caption.startswith("Engine"))
    origins = {row[0]: row[3] for row in engine.rows}
    assert origins["bore"].startswith("Toyota Supra repair manual")
    assert origins["piston mass"].startswith("assumed: ")
