"""The turning, deforming rod as a film."""

import io
import math
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from cycles import analysis
from PIL import Image
from program import fea
from studies import PLAIN, PRESSED

from fea.analysis.pipeline import solve_speed
from fea.base.choices import Symmetry
from fea.base.units import DEG
from fea.machine.remedies import system_remedy
from fea.machine.system import CAN_FORK
from fea.output.folder import PictureError, StorageError
from fea.output.pictures import animation
from fea.output.pictures.animation import COUNT, computed, drawn, require_film, write_film
from fea.output.pictures.surface import CycleAnimation, DrawnSurface
from geometry.errors import InvalidValue

RADIUS, LENGTH = 40.0, 100.0


@pytest.fixture(scope="module")
def bar() -> CycleAnimation:
    """A bar from pin to pin that is pulled and pushed once in a cycle of six frames."""
    corners = [[x, y, z] for x in np.linspace(0, LENGTH, 11) for y in (-15, 15) for z in (-8, 8)]
    points = np.array(corners, float)
    brick = np.array([[0, 4, 6, 7], [0, 6, 2, 7], [0, 2, 3, 7], [0, 3, 1, 7], [0, 1, 5, 7], [0, 5, 4, 7]])
    skin = DrawnSurface.of(points, (brick + 4 * np.arange(10)[:, None, None]).reshape(-1, 4))
    angle = np.arange(6) * 4 * math.pi / 6
    pull = np.cos(angle)[:, None] * points[:, 0]
    displacement = np.stack([1e-3 * pull, 0 * pull, 0 * pull], axis=-1)
    return CycleAnimation(
        skin,
        displacement.astype(np.float32),
        np.abs(pull).astype(np.float32),
        angle,
        RADIUS,
        LENGTH,
        0.0,
        ("a bar", "3000 rpm"),
    )


def test_a_film_shows_every_instant_in_motion_and_colours_of_one_meaning(bar):
    with Image.open(io.BytesIO(drawn(bar, ".gif"))) as gif:
        assert (gif.n_frames, gif.info["loop"], gif.info["duration"]) == (6, 0, 50)
        pages = []
        for k in range(6):
            gif.seek(k)
            pages.append(np.asarray(gif.convert("RGB")).astype(int))
    assert pages[0].shape == (608, 608, 3)
    engine, legend = np.s_[:, :384], np.s_[200:450, 384:]
    for one, other in pairwise(pages):
        assert (np.abs(one[engine] - other[engine]).max(axis=-1) > 40).mean() > 0.03
        assert (np.abs(one[legend] - other[legend]).max(axis=-1) < 16).all()
    # cos θ = 1 there, −½ here: red only where the stress is largest.
    red = [(page[engine][..., 0] - page[engine][..., 2] > 150).sum() for page in pages]
    assert red[0] > 100
    assert red[1] < red[0] / 5


def test_a_film_can_be_an_mp4(bar, tmp_path):
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    (tmp_path / "bar.mp4").write_bytes(drawn(bar, ".MP4"))
    assert imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "bar.mp4")) == (
        6,
        pytest.approx(0.3, abs=0.02),
    )


@pytest.mark.parametrize("offset", [0.0, 5.0])
def test_the_crank_pin_is_on_its_circle_and_the_drawn_small_end_on_the_cylinder_axis(bar, offset):
    motion = replace(bar, pin_offset=offset)
    assert motion.exaggeration > 10
    for k, theta in enumerate(bar.crank_angle):
        placed = motion.placement(k)
        pin = [RADIUS * math.cos(theta), RADIUS * math.sin(theta), 0]
        np.testing.assert_allclose(placed[:3, 3], pin, atol=1e-9)
        end = motion.deformed(k)[bar.skin.points[:, 0] == LENGTH].mean(axis=0)
        x, y, _ = placed[:3, :3] @ end + placed[:3, 3]
        assert y == pytest.approx(offset, abs=1e-4 * LENGTH)
        assert x > 0
        np.testing.assert_allclose(placed[:3, :3] @ placed[:3, :3].T, np.eye(3), atol=1e-12)


def test_frames_are_the_solved_and_superposed_fields_of_their_instants():
    rod = analysis(Symmetry.QUARTER, 14.0)
    tension = solve_speed(rod, 6000.0).cases["tension"]
    angle = np.array([tension.load.crank_angle])
    np.testing.assert_allclose(
        rod.displacement(6000.0, angle)[..., 0],
        tension.displacement,
        atol=1e-9 * np.abs(tension.displacement).max(),
    )
    shown = computed(rod, 6000.0)
    assert shown.crank_angle / DEG == pytest.approx(10.0 * np.arange(COUNT))
    assert shown.displacement.shape == (COUNT, len(shown.skin.points), 3)
    nearest = int(np.abs(shown.crank_angle - angle).argmin())  # 0°, four degrees away
    assert shown.von_mises[nearest].max() == pytest.approx(np.nanmax(tension.von_mises), rel=0.04)


@pytest.mark.parametrize(
    ("name", "rule"), [("cycle.avi", "gif"), ("gone/cycle.gif", "does not exist"), ("here.gif", "directory")]
)
def test_a_file_that_cannot_be_written_is_refused_before_anything_is_solved(tmp_path, name, rule):
    (tmp_path / "here.gif").mkdir()
    with pytest.raises(InvalidValue, match=rule):
        require_film(tmp_path / name)


def test_an_mp4_without_its_encoder_names_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr(animation, "find_spec", lambda _: None)
    require_film(tmp_path / "cycle.gif")
    with pytest.raises(PictureError, match="imageio-ffmpeg"):
        require_film(tmp_path / "cycle.mp4")


def test_a_film_replaces_one_whole_or_not_at_all(tmp_path):
    write_film(tmp_path / "a.gif", b"one")
    write_film(tmp_path / "a.gif", b"two")
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.gif"]
    (tmp_path / "taken.gif").mkdir()
    (tmp_path / "taken.gif" / "file").touch()
    with pytest.raises(StorageError, match=r"taken\.gif"):
        write_film(tmp_path / "taken.gif", b"three")
    assert {entry.name for entry in tmp_path.iterdir()} == {"a.gif", "taken.gif"}


def test_nothing_drawn_is_an_error_with_a_remedy(bar, monkeypatch):
    monkeypatch.setattr(animation, "environments", lambda: [{"PATH": ""}])
    with pytest.raises(PictureError, match=re.escape(system_remedy("pictures"))):
        drawn(replace(bar, rod_length=float("nan")), ".gif")


def test_run_leaves_a_film_where_it_was_asked_for(tmp_path, monkeypatch):
    if CAN_FORK:  # the program runs in a copy of this process
        monkeypatch.setattr(animation, "COUNT", 12)
    (tmp_path / "plain.toml").write_text(PLAIN + PRESSED)
    flags = ("--cycle", "--animate", "cycle.gif", "--size", 14, "--out", "r")
    run = fea("run", "plain.toml", *flags, cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["cycle.gif", "plain.toml", "r"]
    assert "Wrote cycle.gif" in run.stdout
    with Image.open(tmp_path / "cycle.gif") as gif:
        assert gif.n_frames == animation.COUNT
    assert (tmp_path / "cycle.gif").stat().st_size < 3e6


@pytest.mark.slow
def test_without_a_renderer_the_figures_stay(tmp_path, monkeypatch):
    monkeypatch.setattr(animation, "COUNT", 12)
    environment = {"VTK_DEFAULT_OPENGL_WINDOW": "no-such-window", "DISPLAY": ""}
    flags = ("--cycle", "--animate", "cycle.gif", "--size", 14, "--quiet", "--out", "r")
    (tmp_path / "plain.toml").write_text(PLAIN + PRESSED)
    run = fea("run", "plain.toml", *flags, cwd=tmp_path, environment=environment)
    assert run.returncode == 7
    assert system_remedy("pictures") in run.stderr
    assert (tmp_path / "r" / "summary.json").exists()
    assert not (tmp_path / "cycle.gif").exists()


def test_a_film_without_the_cycle_is_refused(tmp_path):
    run = fea("run", "--animate", "cycle.gif", "--size", 14, "--out", "r", cwd=tmp_path)
    assert run.returncode == 2
    assert "Add --cycle" in run.stderr
    assert not list(tmp_path.iterdir())
