import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest
from PIL import Image
from written_figures import buckling, cycle, load, summary
from written_figures import result as case_result

from fea.analysis.summary_figures import BucklingModeFigures
from fea.machine import isolated
from fea.output.folder import PictureError
from fea.output.json_file import json_text
from fea.output.pictures import picture
from fea.output.pictures.drawing import ResultScene
from fea.output.pictures.picture import (
    draw_pictures,
    drawing_process,
    environments,
    explained,
    is_complete_png,
    picture_of,
    picture_of_mesh,
    ready_to_draw,
    take_pictures,
    try_rendering,
)
from fea.output.pictures.shown import Picture, available, described, described_by
from fea.output.pictures.strokes import require_rod
from fea.output.vtu import write_vtu
from geometry.errors import InvalidValue
from mesh.tetmesh import TetMesh

SUMMARY = summary(
    loads={"tension": load(crank_deg=5.0), "given": load(crank_deg=None)},
    results={
        "tension": case_result(
            max_von_mises_MPa=312.0, error_percent=3.14, at_mm=(1.0, 2.0, 3.0), min_safety_factor=1.9884
        ),
        "given": case_result(max_von_mises_MPa=10.0),
    },
)
RESULTS = ["tension.vtu", "given.vtu"]
KILLED = -signal.SIGKILL if hasattr(signal, "SIGKILL") else 1  # an exit code


def shown(vtu, **more):
    return ResultScene.read(Picture(vtu=vtu, png=vtu.with_suffix(".png"), title="", **more))


@pytest.fixture
def result(tmp_path: Path) -> Path:
    """A bar of tetrahedra under a stress that grows along it."""
    corners = np.array([[x, y, z] for x in range(11) for y in (0, 1) for z in (0, 1)], float)
    brick = np.array([[0, 4, 6, 7], [0, 6, 2, 7], [0, 2, 3, 7], [0, 3, 1, 7], [0, 1, 5, 7], [0, 5, 4, 7]])
    tets = (brick + 4 * np.arange(10)[:, None, None]).reshape(-1, 4)
    points = corners * 10
    displacement = np.column_stack([points[:, 0] * 1e-3, np.zeros((len(points), 2))])
    write_vtu(
        tmp_path / "tension.vtu",
        TetMesh(points, tets),
        {"displacement": displacement, "von_mises": points[:, 0]},
    )
    return tmp_path / "tension.vtu"


def red_and_blue(png: Path, least: int = 120) -> tuple[np.ndarray, np.ndarray]:
    """Where the rod's part of a picture is red, and where blue: columns."""
    image = np.asarray(Image.open(png).convert("RGB")).astype(int)[:580]
    warm = image[..., 0] - image[..., 2]
    return np.argwhere(warm > least)[:, 1], np.argwhere(warm < -least)[:, 1]


@pytest.fixture(scope="class")
def one_process():
    with ready_to_draw():
        yield


@pytest.mark.usefixtures("one_process")
class TestWhatPicturesShow:
    def test_a_picture_shows_the_result_in_colour_and_is_small(self, result):
        png = result.with_suffix(".png")
        assert picture_of(result, png) == png
        image = np.asarray(Image.open(png).convert("RGB")).astype(int)
        assert image.shape == (1000, 1600, 3)
        assert png.stat().st_size < 300_000
        assert tuple(image[0, -1]) == (255, 255, 255)
        assert (np.ptp(image[:580], axis=2) > 40).mean() > 0.01  # the bar
        red, blue = image[..., 0] - image[..., 2] > 120, image[..., 2] - image[..., 0] > 120
        assert red[:580].any()
        assert blue[:580].any()
        left, right = (np.argwhere(colour[:580])[:, 1].mean() for colour in (blue, red))
        assert left < right  # as x does

    def test_safety_factors_are_red_where_they_are_least_and_modes_where_they_move(self, result):
        grid = meshio.read(result)
        mesh = TetMesh(grid.points, grid.cells[0].data)
        along = mesh.points[:, 0] / 100
        shape = np.column_stack([np.zeros((len(along), 2)), 1 - along])
        factor = np.where(along < 0.05, -1.0, 1 + 5 * along)  # below zero there is none
        data = {"mode_1": shape / 2, "mode_2": shape, "fatigue_safety_factor": factor}
        write_vtu(result.with_stem("envelope"), mesh, data)
        both = [
            Picture(
                vtu=result.with_stem("envelope"),
                png=result.with_name(f"{field}.png"),
                title=field,
                field=field,
            )
            for field in ("mode_2", "fatigue_safety_factor")
        ]
        draw_pictures(both)
        for picture_ in both:  # both are worst at the left
            red, blue = red_and_blue(picture_.png)
            assert red.mean() < blue.mean(), picture_.field
        assert available(data) == ["fatigue_safety_factor", "mode_1", "mode_2"]

    def test_stresses_of_either_sign_are_red_and_blue_about_pale(self, result):
        grid = meshio.read(result)
        mesh = TetMesh(grid.points, grid.cells[0].data)
        stress = 2 * mesh.points[:, 0] - 100  # from −100 at the left to 100 at the right
        write_vtu(result.with_stem("signed"), mesh, {"mean": stress, "principal_3": stress})
        for field, words in (("mean", "max 100 MPa"), ("principal_3", "min -100 MPa")):
            png = picture_of(result.with_stem("signed"), result.with_name(f"{field}.png"), field)
            red, blue = red_and_blue(png, 90)
            assert blue.mean() < 800 < red.mean()
            assert shown(result.with_stem("signed"), field=field).worst == words

    def test_the_peak_is_told_with_its_error_bar(self, result):
        scene = shown(result, peak=312.04, at=(100.0, 0.0, 0.0), error_percent=9.94)
        assert scene.worst == "max 312 MPa ± 9.9 %"
        assert shown(result, error_percent=13.4).worst == "max 100 MPa ± 13 %"
        assert shown(result).worst == "max 100 MPa"
        assert (
            described_by(SUMMARY, result, "safety_factor").error_percent is None
        )  # it is that of the stress

    def test_a_mesh_is_drawn_without_results(self, tmp_path):
        points = np.vstack([np.zeros(3), np.diag([150.0, 40, 20])])
        png = tmp_path / "results" / "mine.png"
        assert picture_of_mesh(TetMesh(points, np.array([[0, 1, 2, 3]])), "mine", png) == png
        assert is_complete_png(png)


@pytest.fixture
def broken_pipes_kill():
    """What gmsh leaves behind: writing to a process that has died ends this one."""
    before = signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGPIPE, before)


@pytest.mark.skipif(not hasattr(signal, "SIGPIPE"), reason="there are no such signals")
@pytest.mark.usefixtures("broken_pipes_kill")
def test_a_drawing_process_that_dies_is_an_error_with_a_remedy_and_leaves_the_result(result, monkeypatch):
    monkeypatch.setattr(picture, "environments", lambda: [{"PATH": ""}])
    monkeypatch.setattr(sys, "executable", "/bin/false")
    before = result.read_bytes()
    with pytest.raises(PictureError, match=r"tension.png could not be drawn.*libegl1"):
        picture_of(result, result.with_suffix(".png"))
    assert result.read_bytes() == before
    assert not result.with_suffix(".png").exists()


@pytest.mark.skipif(not hasattr(signal, "SIGPIPE"), reason="there are no such signals")
@pytest.mark.usefixtures("broken_pipes_kill")
def test_orders_to_a_process_that_has_died_are_an_error():
    with drawing_process(environments()[0]) as drawer:
        drawer.started.kill()
        drawer.started.wait()
        said = explained(drawer, "fea.output.pictures.drawing:draw_all", [], timeout=1.0)
        assert said == "the drawing process ended (SIGKILL)"


def test_a_process_that_does_not_answer_is_ended(result):
    with drawing_process(environments()[0]) as drawer:
        said = explained(drawer, "time:sleep", 60, timeout=0.01)
        assert said == "it took longer than 0.01 s"
        assert drawer.started.wait() == KILLED


@pytest.fixture
def started(monkeypatch) -> list[subprocess.Popen]:
    """The processes that are started, one after the other; none is copied."""
    monkeypatch.setattr(picture, "fresh", isolated.fresh)
    processes, original = [], subprocess.Popen
    monkeypatch.setattr(
        isolated.subprocess, "Popen", lambda *a, **b: processes.append(original(*a, **b)) or processes[-1]
    )
    return processes


@pytest.mark.slow
def test_pictures_of_a_block_are_drawn_by_one_process_that_ends_with_it(result, started, monkeypatch):
    with ready_to_draw():
        monkeypatch.setenv("SET_BY_A_LIBRARY", "meanwhile")
        one, other = (picture_of(result, result.with_stem(stem).with_suffix(".png")) for stem in "ab")
        assert [process.poll() for process in started] == [None]
        started[0].kill()
        started[0].wait()
        afresh = picture_of(result, result.with_name("c.png"))
    assert len(started) == 2
    assert all(process.returncode is not None for process in started)
    # whatever was drawn before: the last picture comes from a new process
    assert one.read_bytes() == other.read_bytes() == afresh.read_bytes()


def test_a_failure_in_the_block_ends_the_process_at_once(started):
    with pytest.raises(ZeroDivisionError), ready_to_draw():
        assert started[0].poll() is None
        raise ZeroDivisionError
    assert started[0].returncode == KILLED


def test_nothing_is_started_where_no_pictures_are_wanted(started):
    with ready_to_draw(wanted=False):
        pass
    assert started == []


def test_a_process_that_cannot_be_started_is_an_error_only_where_something_is_drawn(result, monkeypatch):
    monkeypatch.setattr(sys, "executable", "/no/such/python")
    with ready_to_draw(), pytest.raises(PictureError, match=r"No such file or directory|File not found"):
        picture_of(result, result.with_suffix(".png"))


def test_what_is_no_result_is_said(result):
    (result.parent / "bad.vtu").write_text("<VTKFile></VTKFile>")
    with pytest.raises(PictureError, match="not a result"):
        draw_pictures([Picture(vtu=result.parent / "bad.vtu", png=result.parent / "bad.png", title="bad")])
    with pytest.raises(InvalidValue, match="has no stress, safety factor or mode shape"):
        picture_of(result.parent / "bad.vtu", result.parent / "bad.png")
    (result.parent / "cut.vtu").write_bytes(result.read_bytes()[: result.stat().st_size // 2])
    with pytest.raises(InvalidValue, match=r"cut\.vtu.*is not a complete \.vtu file"):
        picture_of(result.parent / "cut.vtu", result.parent / "cut.png")
    with pytest.raises(InvalidValue, match="is not a file"):
        picture_of(result.parent / "none.vtu", result.parent / "none.png")
    with pytest.raises(InvalidValue, match="must be one of von_mises, displacement for"):
        picture_of(result, result.with_suffix(".png"), "mode_1")


def test_no_picture_starts_no_process(monkeypatch):
    monkeypatch.setattr(picture, "run_drawing", lambda *_, **__: pytest.fail("nothing to draw"))
    draw_pictures([])


def test_a_machine_that_can_draw_passes_the_trial():
    try_rendering()


def test_every_case_of_a_run_is_drawn_in_the_words_of_its_summary(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(picture, "draw_pictures", drawn.extend)
    assert take_pictures(tmp_path, SUMMARY, RESULTS) == [tmp_path / "tension.png", tmp_path / "given.png"]
    tension, given = drawn
    assert tension == Picture(
        vtu=tmp_path / "tension.vtu",
        png=tmp_path / "tension.png",
        title="leon-2001: tension, 6000 rpm, crank angle 5.0°",
        peak=312.0,
        at=(1.0, 2.0, 3.0),
        notes=("smallest safety factor against yielding 1.99",),
        error_percent=3.14,
    )
    assert given.title == "leon-2001: given, 6000 rpm"
    take_pictures(tmp_path, replace(SUMMARY, trusted=False), RESULTS)
    assert "NOT TO BE TRUSTED" in drawn[-1].notes[-1]


def test_a_file_beside_its_summary_is_titled_by_it(tmp_path):
    (tmp_path / "summary.json").write_text(json_text(SUMMARY), encoding="utf-8")
    png = tmp_path / "elsewhere.png"
    assert described(tmp_path / "tension.vtu", png).title == "leon-2001: tension, 6000 rpm, crank angle 5.0°"
    assert described(tmp_path / "tension.vtu", png).png == png
    assert described(tmp_path / "other.vtu", png) == Picture(
        vtu=tmp_path / "other.vtu", png=png, title="other"
    )


def test_the_envelope_and_modes_of_buckling_are_described_too(tmp_path, monkeypatch):
    modes = (
        BucklingModeFigures(factor=6.0146, moves="sideways"),
        BucklingModeFigures(factor=27.5, moves="twisting"),
    )
    found = replace(buckling(3.0, 4.0, modes={"gas": modes}), shapes_of="gas")
    run = replace(SUMMARY, buckling=found, envelope=cycle())
    (tmp_path / "summary.json").write_text(json_text(run), encoding="utf-8")
    mode = described(tmp_path / "buckling.vtu", tmp_path / "b.png", "mode_2")
    assert mode.title == "leon-2001: buckling under gas, mode 2 at 27.5 times the load, 6000 rpm"
    assert mode.notes == ("moves twisting",)
    drawn = []
    monkeypatch.setattr(picture, "draw_pictures", drawn.extend)
    take_pictures(tmp_path, run, ["envelope.vtu", "buckling.vtu"])
    assert [(item.png.name, item.field) for item in drawn] == [
        ("envelope.png", "von_mises"),
        ("buckling.png", "mode_1"),
    ]
    assert drawn[0].notes == ("smallest safety factors: yielding 0.89, fatigue 0.54",)
    assert described(tmp_path / "modes.vtu", tmp_path / "m.png", "mode_3").title == "modes: mode 3"


def test_a_blank_picture_is_an_error_whatever_the_library_says():
    image = np.full((400, 1600, 3), 255, np.uint8)
    with pytest.raises(RuntimeError, match="blank"):
        require_rod(image)
    image[100:200, 200:1400] = (66, 148, 255)
    require_rod(image)


def test_a_png_that_is_cut_short_damaged_or_blank_is_none(tmp_path):
    png = tmp_path / "a.png"
    assert not is_complete_png(png)
    Image.fromarray(np.full((50, 50, 3), 255, np.uint8)).save(png)
    assert not is_complete_png(png)
    Image.fromarray(np.arange(7500, dtype=np.uint8).reshape(50, 50, 3)).save(png)
    assert is_complete_png(png)
    whole = png.read_bytes()
    for broken in (
        whole[:-12],
        whole[:100],
        b"GIF89a" + whole,
        whole[:60] + b"\0\0" + whole[62:],
        whole[:-14] + b"\0\0" + whole[-12:],
    ):
        png.write_bytes(broken)
        assert not is_complete_png(png)
