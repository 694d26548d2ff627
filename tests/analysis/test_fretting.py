"""Fretting of a bolted rod with shells and bushing over its cycle: places, stress, answer and files."""

from dataclasses import replace
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
from assemblies import EVERY, SIMPLE, study
from tet_blocks import block

from fea.analysis.cycle.surface_stress import _averaging
from fea.analysis.fretting import AS_GIVEN, FEWEST_FACETS, fretting
from fea.analysis.pipeline import RefinedRod, prepare
from fea.analysis.result import run_result
from fea.base.units import DEG
from fea.machine.clock import Clock
from fea.output.fretting import fretting as fretting_lines
from fea.output.fretting import fretting_in_full, fretting_tables
from fea.output.json_file import read_summary
from fea.output.report.page import page
from fea.output.run_files import write_run
from fea.study.option_tables import AnalysisTable, MeshTable
from mesh.tetmesh import TetMesh

pytestmark = pytest.mark.slow


SPEED = 6000.0


@pytest.fixture(scope="module")
def rod():
    """With 16 elements around each bore: the contact of the cycle is most of the time."""
    own = study(EVERY, rod=SIMPLE)
    analysis = replace(own.analysis, fretting=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fea.rod.discretise.PER_TOUCHED_BORE", 16)
        return prepare(replace(own, mesh=MeshTable(size_mm=20.0), analysis=analysis))


@pytest.fixture(scope="module")
def speed(rod):
    return RefinedRod(rod).at(SPEED)


@pytest.fixture(scope="module")
def found(speed):
    return speed.fretting


@pytest.fixture(scope="module")
def run(rod, speed):
    return run_result(rod.study, RefinedRod(rod), speed)


@pytest.fixture(scope="module")
def figures(run):
    return run.summary.fretting


def test_the_flag_includes_the_cycle():
    assert AnalysisTable(fretting=True).cycle
    assert not AnalysisTable().cycle


def test_a_rod_of_one_piece_has_none_and_says_so():
    result, (note,) = fretting(SimpleNamespace(assembly_contact=None), None, None)
    assert result is None
    assert "no parts of the rod touch with friction" in str(note)


def test_energy_over_a_duty_is_that_of_its_cycles(rod, speed, monkeypatch):
    monkeypatch.setattr("fea.analysis.fretting._changes", lambda _pins, _cycle: ({}, []))
    cycle, other = rod.crank_cycle(SPEED), replace(rod)
    vars(other).update(
        {name: vars(rod)[name] for name in ("full_cycle", "certified_cycle") if name in vars(rod)}
    )
    entries = [SimpleNamespace(cycle=cycle, rate=rate) for rate in (3600.0, 7200.0)]
    vars(other)["life"] = SimpleNamespace(operation=SimpleNamespace(entries=entries))
    found, _ = fretting(other, cycle, speed.cycle)
    summary = SimpleNamespace(fretting=found.figures(rod.mesh.bores.rod_length))
    # 3 cycles in a second.
    for pair in summary.fretting.pairs.values():
        assert pair.duty_W == pytest.approx(3e-3 * pair.energy_mJ, rel=1e-9)
    text = "\n".join(fretting_in_full(summary))
    assert text.count("W over the duty)") == len(summary.fretting.pairs)


def test_places_are_ranked_by_the_product_of_their_figures(figures):
    severity = [place.ruiz_2 for place in figures.places]
    assert severity == sorted(severity, reverse=True)
    assert len(severity) > 3
    for place in figures.places:
        product = place.tension_MPa * place.shear_MPa * place.slip_um * 1e-3
        assert place.ruiz_2 == pytest.approx(product, rel=1e-9)
        assert place.shear_MPa <= figures.friction * place.pressure_MPa * (1 + 1e-3)
        assert (place.factor is None) == (place.facets_across < FEWEST_FACETS)
        assert place.part in {"rod", "cap"}
    assert {place.pair for place in figures.places} >= {"seat of the shells", "seat of the bushing"}


@pytest.mark.parametrize("image", [False, True])
def test_tension_along_the_surface_is_that_of_a_direct_solution(rod, found, image):
    """At the worst place on either side of y = 0; the basis errs by at most .5 % of the largest stress."""
    cycle, here = rod.crank_cycle(SPEED), found.counts & (found.vertices.image == image)
    k = int(np.where(here, found.ruiz_2.max(axis=1), 0.0).argmax())
    instant = int(found.ruiz_2[k].argmax())
    degree = round(found.angles[instant] / DEG)
    direct = rod.cycle.direct(cycle.degrees[np.array([degree])], cycle)[found.part[k]][..., 0]
    points = rod.mesh.whole.points
    near = np.linalg.norm(points - found.vertices.place[k], axis=1) < 1e-9
    (node,) = np.flatnonzero(near & ~np.isnan(direct[:, 0]))
    axis = rod.mesh.bores.rod_length if points[node, 0] > rod.mesh.bores.rod_length / 2 else 0.0
    x, y, _ = points[node] - [axis, 0.0, 0.0]
    xx, yy, zz, xy, yz, xz = direct[node]
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    tangents = np.array([[-y / np.hypot(x, y), x / np.hypot(x, y), 0.0], [0.0, 0.0, 1.0]])
    largest = np.linalg.eigvalsh(tangents @ tensor @ tangents.T)[-1]
    assert found.tension[k, instant] == pytest.approx(largest, abs=0.01 * np.nanmax(np.abs(direct)))


def test_largest_parameter_and_largest_tension_are_in_different_places(figures):
    """Merritt & Zhu 2004 (SAE 2004-01-3015): a rod broke at the former, not at the latter."""
    for name in ("seat of the bushing", "seat of the shells"):
        pair, place = figures.pairs[name], next(each for each in figures.places if each.pair == name)
        assert place.tension_MPa < 0.8 * pair.tension_MPa
        away = np.linalg.norm(np.subtract(pair.most_energy_at_mm, pair.tension_at_mm))
        assert away > 5.0


def test_what_a_cycle_leaves_of_slip_is_stated(figures, found):
    """The path ends where it began, but for the creep; it is what makes slip of the last cycle go on."""
    for name, pair in figures.pairs.items():
        assert pair.creep_um <= pair.slip_um
        assert figures.changes[AS_GIVEN][name].energy_mJ == pair.energy_mJ
    steps = np.linalg.norm(np.diff(found.rubbing.slip, axis=2), axis=1)
    assert (found.rubbing.range <= steps.sum(axis=1) * (1 + 1e-9) + 1e-9).all()


def test_more_friction_lets_the_joint_slip_less(figures):
    dry = next(pairs for words, pairs in figures.changes.items() if "dry" in words)
    assert dry["joint"].slip_um < figures.changes[AS_GIVEN]["joint"].slip_um
    crushed = next(pairs for words, pairs in figures.changes.items() if "crush" in words)
    assert crushed["seat of the shells"].energy_mJ > 0


def test_bolt_heads_hold_and_their_seats_stretch_by_micrometres(rod, speed, figures):
    """Without tension the worst instant is that of the largest force; 2 %: the seat's rim is meshed."""
    heads, nuts = figures.bolt_seats["heads"], figures.bolt_seats["nuts"]
    nominal = np.pi * (rod.mesh.bolts[0].head_radius ** 2 - rod.mesh.bolts[0].hole_radius ** 2)
    largest = max(bolt.force for state in speed.cycle.states for bolt in state.bolts)
    assert heads.pressure_MPa * nominal == pytest.approx(largest, rel=0.02)
    for seat in (heads, nuts):
        assert seat.reserve > 1
        assert seat.slides_um == 0
        assert 0.1 < seat.slip_um < 20
        assert seat.ruiz_1 == pytest.approx(seat.friction * seat.pressure_MPa * seat.slip_um * 1e-3, rel=0.05)
        assert seat.ruiz_2 is None or seat.ruiz_2 < figures.places[0].ruiz_2
    assert heads.at_mm[0] < 0 < nuts.at_mm[0]  # cap and rod


def test_the_shear_of_a_head_balances_the_moments_of_its_bolt(rod):
    """V = (M of head + M of thread)/grip; and undoing the shift undoes the shear."""
    sums, cycle = rod.pins.assembly.sums, rod.crank_cycle(SPEED)
    (state,) = rod.pins.states(cycle.degrees[np.array([370])], cycle)
    shear, shift = sums.held(state)
    grip = rod.mesh.bolts[0].grip
    np.testing.assert_allclose(shear, sums._bending.moments(state).sum(axis=2) / grip, rtol=1e-9)
    assert (shear[:, 0] * shift[:, 0] > 0).all()


def test_what_has_served_takes_the_place_of_a_limit(run):
    proven = replace(run.summary.fretting, proven_ruiz_2=2 * run.summary.fretting.places[0].ruiz_2)
    (line,) = fretting_lines(replace(run.summary, fretting=proven))
    assert line.endswith("(0.50 of what has served).")
    line = next(fretting_in_full(replace(run.summary, fretting=proven)))
    assert "0.50 times the" in line
    assert "MPa²·mm that have served" in line
    assert "no limit is known" not in line


def test_heads_that_slide_are_said_below_the_table(run):
    slide = replace(run.summary.fretting.bolt_seats["heads"], reserve=0.5, slides_um=12.0)
    found = replace(run.summary.fretting, bolt_seats={"heads": slide})
    _, line = fretting_lines(replace(run.summary, fretting=found))
    assert "they slide by up to 12.0 µm, as friction 0.12 bears 0.5 times the shear on them" in line


def test_the_written_surfaces_have_the_energy_of_the_answer(run, figures, tmp_path):
    """Of a linear field over plane triangles; 3 %: the seats are curved."""
    run = replace(run, study=replace(run.study, output=replace(run.study.output, screenshot=False)))
    write_run(tmp_path, run, Clock())
    assert (tmp_path / "fretting.png").stat().st_size > 10_000
    written = meshio.read(tmp_path / "fretting.vtu")
    triangles, points = written.cells_dict["triangle"], written.points
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    energy = written.point_data["energy"][triangles].mean(axis=1) * area
    names = {"joint": "joint", "seat of the bushing": "bushing_seat", "seat of the shells": "shell_seat"}
    for name, pair in figures.pairs.items():
        mine = written.cell_data[names[name]][0] == 1
        assert energy[mine].sum() == pytest.approx(pair.energy_mJ, rel=0.03)
        assert written.point_data["slip_um"][triangles[mine]].max() == pytest.approx(pair.slip_um, rel=1e-6)
        nodes = np.unique(triangles[mine])
        worst = points[nodes[written.point_data["energy"][nodes].argmax()]]
        np.testing.assert_allclose(np.abs(worst), np.abs(pair.most_energy_at_mm), atol=1e-3)
    report = page(run, None, None, tmp_path)
    assert report.count('src="data:image/png;base64,') == 1
    assert "No limit of it is known" in report
    again = read_summary(tmp_path).fretting
    assert again.places[0].at_mm == pytest.approx(figures.places[0].at_mm, abs=1e-3)


def test_the_answer_says_that_it_is_a_ranking(run):
    lines = list(fretting_in_full(run.summary))
    (brief,) = fretting_lines(run.summary)
    assert len(brief) <= 80  # one line, for which there is room below the table
    assert brief.endswith("(a ranking).")
    assert lines[0].startswith("Fretting, most likely: ")
    assert "a ranking: no limit is known" in lines[0]
    seats = run.summary.fretting.bolt_seats
    assert len(lines) == 1 + len(run.summary.fretting.pairs) + len(seats)
    assert "largest τδ +" in lines[0]
    assert "with friction 0.7 of dry steel (assumed)" in lines[0]
    assert lines[-1].startswith("Under bolt nuts, estimated: slip ")
    places, bolts, changes = fretting_tables(run.summary)
    assert len(bolts.rows) == len(seats)
    assert len(places.rows) == len(run.summary.fretting.places)
    assert len(changes.rows) == 3 * len(run.summary.fretting.pairs)
    assert not list(fretting_in_full(replace(run.summary, fretting=None)))


@pytest.mark.parametrize("order", [1, 2])
def test_the_mean_below_a_place_is_that_of_the_volume(order):
    """Of x, and on second-order elements of x², over the cube whose six elements all hold one corner."""
    file = block(1, order)
    mesh = TetMesh(file.points, file.tets)
    mean, radius = _averaging(mesh, file.tets, np.array([0]))
    x = file.points[:, 0]
    assert mean @ x == pytest.approx([1 / 2])
    if order == 2:
        assert mean @ x**2 == pytest.approx([1 / 3])
    assert radius == pytest.approx([np.cbrt(3 / (2 * np.pi))])
