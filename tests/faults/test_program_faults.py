"""What a machine, a file system and an impatient user do to a run: its exit code, one message, no remains."""

import json
import os
import resource
import signal
import subprocess
import sys
import time

import pytest
from program import COARSE, PLAIN, PROGRAM, contained, fea, names

from geometry.cad.formats import step_file
from geometry.presets import PRESETS
from geometry.session import session

pytestmark = pytest.mark.slow


MEBI = 2**20


def one_line(done, code, *words):
    assert done.returncode == code, done.stderr
    assert done.stderr.count("\n") <= 2
    assert "Traceback" not in done.stderr
    for word in words:
        assert word in done.stderr


def limited(arguments, cwd, **limits):
    """The program under limits of the system, by the names of `resource`."""

    def limit():
        for name, value in limits.items():
            resource.setrlimit(getattr(resource, name), (value, value))

    command = [*PROGRAM, *map(str, arguments)]
    return subprocess.run(
        command, cwd=cwd, capture_output=True, text=True, timeout=300, check=False, preexec_fn=limit
    )


def unprivileged(arguments, cwd):
    command = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", *PROGRAM, *map(str, arguments)]
    environment = os.environ | {"HOME": "/nonexistent", "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        command, cwd=cwd, env=environment, capture_output=True, text=True, timeout=300, check=False
    )


@pytest.mark.parametrize("mebibytes", [300, 600])
def test_too_little_memory_is_exit_7(tmp_path, mebibytes):
    done = limited(["run", *PLAIN, "--quiet"], tmp_path, RLIMIT_AS=mebibytes * MEBI)
    if done.returncode:
        one_line(done, 7)
        assert done.stderr.count("\n") == 1
        assert not (tmp_path / "results").exists()
    assert done.stdout == ""


def test_enough_memory_is_noticed_by_nobody(tmp_path):
    done = limited(["run", *PLAIN, "--json"], tmp_path, RLIMIT_AS=4000 * MEBI)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("{")
    one_line(limited(["run", "--rpm", "-1"], tmp_path, RLIMIT_AS=4000 * MEBI), 2, "speed.rpm")


def test_a_full_disk_is_exit_7_and_harms_nothing(tmp_path):
    assert fea("run", *PLAIN, "--quiet", "--out", "r", cwd=tmp_path).returncode == 0
    kept = {path.name: path.read_bytes() for path in (tmp_path / "r").iterdir()}
    done = fea("run", *PLAIN, "--quiet", "--out", "r", cwd=tmp_path, largest_file=100_000)
    one_line(done, 7, "could not be written")
    assert {path.name: path.read_bytes() for path in (tmp_path / "r").iterdir()} == kept
    assert names(tmp_path) == {"r"}


def test_places_that_take_no_run(tmp_path):
    (tmp_path / "file").write_text("keep me")
    for place, code in (("file", 2), ("/etc", 2), ("/proc/x", 7)):
        one_line(fea("run", *PLAIN, "--out", place, cwd=tmp_path), code, place)
    study = '[rod]\npreset = "leon-2001"\n[forces]\npin_N = [1000, 0]\n[output]\ndirectory = "/etc/passwd"\n'
    (tmp_path / "evil.toml").write_text(study)
    one_line(fea("run", "evil.toml", cwd=tmp_path), 2, "/etc/passwd")
    assert (tmp_path / "file").read_text() == "keep me"


@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="needs root to become somebody else")
def test_a_directory_that_may_not_be_written_is_exit_7(tmp_path):
    if unprivileged(["--version"], "/").returncode:
        pytest.skip("the program cannot be read by others here")
    one_line(unprivileged(["run", *PLAIN, "--out", "/usr/r"], "/"), 7, "/usr/r", "Permission denied")
    one_line(unprivileged(["loads", "--csv", "/usr/r.csv"], "/"), 7, "/usr/r.csv")


@pytest.mark.parametrize(
    ("sent", "after"),
    [
        *((sent, after) for sent in (signal.SIGINT, signal.SIGKILL) for after in (0.7, 1.4)),
        (signal.SIGTERM, 1.4),
        (signal.SIGHUP, 1.0),
    ],
)
def test_an_end_at_any_moment_leaves_nothing_half_written(tmp_path, after, sent):
    (tmp_path / "s.toml").write_text('[rod]\npreset = "leon-2001"\n[forces]\npin_N = [1000, 0]\n')
    process = subprocess.Popen(
        [*PROGRAM, "run", "s.toml", "--size", "5", "--quiet", "--out", "r"],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
    )
    time.sleep(after)
    process.send_signal(sent)
    said = process.communicate(timeout=120)[1]
    if sent is not signal.SIGKILL:
        assert process.returncode in (0, 130), said
        assert process.returncode == 0 or said == "fea: interrupted; no incomplete result was left behind\n"
        assert names(tmp_path) <= {"r", "s.toml"}
    assert not (tmp_path / "r").exists() or (tmp_path / "r" / "summary.json").exists()
    if sent is signal.SIGKILL and after == 1.4:
        assert fea("run", *PLAIN, "--quiet", "--out", "r", cwd=tmp_path).returncode == 0
        assert names(tmp_path) == {"r", "s.toml"}


WITHIN = """
import os, signal, sys, threading
from {module} import {name}
owner = {owner}
original = owner.{method}
def interrupted(*arguments, **named):
    threading.Timer(0.05, os.killpg, (0, signal.SIGINT)).start()
    return original(*arguments, **named)
owner.{method} = interrupted
from fea.__main__ import call
sys.exit(call(sys.argv[1:]))
"""


GMSH = {"module": "mesh.generate", "name": "gmsh", "owner": "gmsh.model.mesh", "method": "generate"}
PARDISO = {
    "module": "fea.solvers.direct",
    "name": "Pardiso",
    "owner": "Pardiso",
    "method": "condense",
}


@pytest.mark.parametrize(
    ("library", "rod"),
    [(GMSH, 'preset = "leon-2001"'), (GMSH, 'step = "rod.step"'), (PARDISO, 'preset = "leon-2001"')],
    ids=["gmsh", "gmsh on STEP", "pardiso"],
)
def test_an_interrupt_within_a_library_is_one_line(tmp_path, library, rod):
    with session():
        (tmp_path / "rod.step").write_bytes(step_file(PRESETS["leon-2001"]))
    (tmp_path / "s.toml").write_text(f"[rod]\n{rod}\n[forces]\npin_N = [1000, 0]\n")
    code = WITHIN.format(**library)
    process = subprocess.Popen(
        [sys.executable, "-c", code, "run", "s.toml", "--size", "6", "--solver", "pardiso", "--quiet"],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    said = process.communicate(timeout=120)[1]
    assert (process.returncode, said) == (130, "fea: interrupted; no incomplete result was left behind\n")
    assert names(tmp_path) == {"rod.step", "s.toml"}
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, signal.SIGTERM)


REPLACED = """
import signal, sys
from contextlib import suppress
import fea.__main__ as program
def compared(_arguments):
    with suppress(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
    raise TypeError("Cannot compare structured arrays")
program._dispatch = compared
sys.exit(program.call([]))
"""


def test_an_interrupt_that_a_library_replaces_by_an_error_is_one_all_the_same():
    process = subprocess.run([sys.executable, "-c", REPLACED], capture_output=True, text=True, check=False)
    said = "fea: interrupted; no incomplete result was left behind\n"
    assert (process.returncode, process.stderr) == (130, said)


DRAWN = ("run", "s.toml", "--size", "6", "--screenshot", "--quiet")


def gone(group, seconds):
    """Whether no process of a group is left after some seconds at most."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


@pytest.mark.parametrize("sent", [signal.SIGTERM, signal.SIGKILL])
def test_the_process_that_is_to_draw_ends_with_the_program(tmp_path, sent):
    (tmp_path / "s.toml").write_text('[rod]\npreset = "leon-2001"\n[forces]\npin_N = [1000, 0]\n')
    code = WITHIN.format(**GMSH).replace("os.killpg, (0, signal.SIGINT)", f"os.kill, (os.getpid(), {sent:d})")
    command = [sys.executable, "-c", code, *DRAWN]
    process = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.DEVNULL, start_new_session=True)
    assert process.wait(timeout=120) == (130 if sent == signal.SIGTERM else -sent)
    assert gone(process.pid, 5.0 if sent == signal.SIGTERM else 30.0)  # a busy machine reaps it late
    assert sent == signal.SIGKILL or names(tmp_path) == {"s.toml"}


def test_the_process_that_is_to_draw_ends_with_an_analysis_that_fails():
    study = b'[rod]\nstep = "rod.step"\n[forces]\npin_N = [1000, 0]\n'
    ended = contained(DRAWN, {"s.toml": study, "rod.step": b"no rod"})
    assert (ended.code, ended.fault()) == (3, "")


@pytest.fixture
def small_disk(tmp_path):
    place = tmp_path / "disk"
    place.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(place)]
    if subprocess.run(command, capture_output=True, check=False).returncode:
        pytest.skip("no file system can be mounted here")
    yield place
    subprocess.run(["umount", str(place)], check=True)


@pytest.mark.parametrize(
    ("arguments", "file"),
    [
        (["run", *PLAIN, "--quiet", "--out", "disk/r"], "r"),
        (["loads", "--csv", "disk/l.csv"], "l.csv"),
        (["rod", *COARSE, "--quiet", "--step", "disk/r.step"], "r.step"),
    ],
)
def test_a_disk_that_is_really_full(tmp_path, small_disk, arguments, file):
    (small_disk / "fill").write_bytes(bytes(40_000))
    if file != "r":
        (small_disk / file).write_text("earlier")
    before = names(small_disk)
    one_line(fea(*arguments, cwd=tmp_path), 7, file)
    assert names(small_disk) == before
    assert file == "r" or (small_disk / file).read_text() == "earlier"


def test_two_runs_into_one_place(tmp_path):
    command = [*PROGRAM, "run", *map(str, PLAIN), "--quiet", "--out", "r"]
    both = [subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE) for _ in range(2)]
    assert [process.communicate()[1] for process in both] == [b"", b""]
    assert [process.returncode for process in both] == [0, 0]
    assert names(tmp_path) == {"r"}
    assert (tmp_path / "r" / "summary.json").exists()


def test_without_a_renderer_the_figures_stay(tmp_path):
    environment = {"VTK_DEFAULT_OPENGL_WINDOW": "no-such-window", "DISPLAY": ""}
    done = fea("run", *PLAIN, "--quiet", "--screenshot", "--out", "r", cwd=tmp_path, environment=environment)
    assert done.returncode in (0, 7), done.stderr
    if done.returncode:
        one_line(done, 7, "libegl1")
    assert (tmp_path / "r" / "summary.json").exists()
    assert names(tmp_path) == {"r"}


def test_pictures_that_nobody_asked_for_may_be_missing(tmp_path, monkeypatch):
    """A long run is drawn by default, unless it shall not be; a failure to draw is said and ends nothing."""
    monkeypatch.setattr("fea.output.run_files.pays_to_draw", lambda _run, _clock: True)
    monkeypatch.setattr("fea.output.pictures.picture.run_drawing", lambda *_, **_more: "no OpenGL here")
    for flags, omitted in (([], [True]), (["--no-screenshot"], [])):
        done = fea("run", *PLAIN, "--tolerance", 0, *flags, "--out", "r", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        left_out = json.loads((tmp_path / "r" / "summary.json").read_text())["left_out"]
        assert ["no OpenGL here" in note["why"] for note in left_out if note["what"] == "pictures"] == omitted


@pytest.mark.parametrize(
    ("engine", "code", "says"),
    [
        ('gas = "missing.csv"', 2, "missing.csv"),
        ('gas = "torn.csv"', 2, "line 3"),
        ('gas = "back.csv"', 2, "must increase"),
        ('gas = "fan"', 2, "fan"),
        ("stroke_mm = 300.0", 2, "crank"),
        ("cylinders = 1000000000", 2, "engine.cylinders"),
        ('gas = "none"', 2, "applies no load to the rod"),
    ],
)
def test_engines_that_cannot_be(tmp_path, engine, code, says):
    (tmp_path / "torn.csv").write_text("crank_deg,pressure_bar\n0,1\n360,2,3\n")
    (tmp_path / "back.csv").write_text("crank_deg,pressure_bar\n0,1\n360,20\n350,3\n700,1\n")
    table = {"stroke_mm": "94.0", "bore_mm": "76.0", "piston_mass_kg": "1.0"}
    key, value = engine.split(" = ")
    text = "\n".join(f"{name} = {entry}" for name, entry in (table | {key: value}).items())
    text = f'[rod]\npreset = "leon-2001"\n[speed]\nrpm = 0\n[engine]\n{text}\n'
    (tmp_path / "s.toml").write_text(text)
    one_line(fea("run", "s.toml", *COARSE, cwd=tmp_path), code, says)
    assert not (tmp_path / "results").exists()
