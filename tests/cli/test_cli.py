"""The program as a process: what it prints where, and how it leaves."""

import json
import re
import subprocess
import sys

import pytest
from program import COARSE, PLAIN, fea, figures

from fea.__main__ import call, commands

pytestmark = pytest.mark.usefixtures("coarse_bores")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    return folder, fea("run", *COARSE, "--elastic", "--json", cwd=folder)


def test_help_is_light_and_lists_the_commands(tmp_path):
    code = (
        "import sys; from fea.__main__ import call; call(['--help']); "
        "heavy = {'gmsh', 'skfem', 'scipy', 'pyvista', 'vtk', 'matplotlib', 'numpy', 'meshio', 'PIL'}; "
        "heavy = (heavy | {'tomli_w'}) & set(sys.modules); "
        "sys.exit(f'loaded {heavy}' if heavy else 0)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    for command in ("run", "loads", "rod", "reproduce", "view", "init", "doctor"):
        assert command in done.stdout


@pytest.mark.parametrize("command", commands())
def test_each_command_has_its_help(command, capsys):
    assert call([command, "--help"]) == 0
    text = capsys.readouterr().out
    assert f"Usage: fea {command}" in text
    # The first is not the default of a long run, and the second a flag of its own.
    assert set(re.findall(r"--no-\w+", text)) <= {"--no-screenshot", "--no-browser"}
    assert not re.search(r"\[default:\s*(False|None)?\s*\]", text)  # that a switch is off goes without saying


def test_a_run_prints_json_only_and_leaves_what_is_promised(run):
    folder, done = run
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    summary = json.loads(done.stdout)
    assert summary["schema"] == "fea/summary/1"
    assert summary["trusted"] is True
    place = folder / "results" / "leon-2001-6000rpm"
    assert json.loads((place / "summary.json").read_text()) == summary
    cases = {"tension", "compression", "side", "bending", "gas"}
    assert set(summary["results"]) == set(summary["loads"]) == cases
    assert {path.name for path in place.iterdir()} == {
        "summary.json", "study.toml", "loads.csv", "cases.pvd", "contact.vtu",
        *(f"{case}.vtu" for case in cases),
    }  # fmt: skip
    assert {item["what"] for item in summary["left_out"]} >= {"elements at z < 0"}
    assert all(check["pass"] for check in summary["checks"].values())


def test_the_resolved_study_runs_again_to_the_same_bytes(run):
    folder, _ = run
    place = folder / "results" / "leon-2001-6000rpm"
    done = fea("run", place / "study.toml", "--out", "again", "--quiet", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert done.stdout == ""
    for name in ("tension.vtu", "bending.vtu", "loads.csv"):
        assert (folder / "again" / name).read_bytes() == (place / name).read_bytes()
    first, second = (json.loads((f / "summary.json").read_text()) for f in (place, folder / "again"))
    assert first["results"] == second["results"]


def test_several_speeds_leave_a_run_each_and_a_map(tmp_path):
    done = fea("run", *PLAIN, "--rpm", "0,6000", "--out", "sweep", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    slow, fast = json.loads(done.stdout)
    assert (slow["rpm"], fast["rpm"]) == (0, 6000)
    assert "tension" not in slow["results"]  # nothing pulls at rest
    assert {"case tension"} <= {item["what"] for item in slow["left_out"]}
    assert (tmp_path / "sweep" / "0rpm" / "summary.json").exists()
    assert (tmp_path / "sweep" / "map.csv").read_text().count("\n") == 1 + len(slow["loads"]) + len(
        fast["loads"]
    )
    # Its study runs again, and not in place of the sweep that it is part of.
    again = fea("run", "sweep/6000rpm/study.toml", "--quiet", cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    assert {entry.name for entry in (tmp_path / "sweep").iterdir()} == {"0rpm", "6000rpm", "map.csv"}
    assert (tmp_path / "results" / "study-6000rpm" / "summary.json").exists()


def test_no_symmetry_gives_the_same_figures(tmp_path):
    parts, whole = (figures("run", *PLAIN, "--symmetry", name, cwd=tmp_path) for name in ("quarter", "none"))
    assert whole["model"]["nodes"] == parts["model"]["nodes"]
    for case, result in whole["results"].items():
        for name in ("max_von_mises_MPa", "max_displacement_mm", "min_safety_factor"):
            assert result[name] == pytest.approx(parts["results"][case][name], rel=2e-5), (case, name)


@pytest.mark.slow
def test_the_published_model_runs_clamped(tmp_path):
    done = fea("run", "leon-2001-as-published", *COARSE, "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert summary["rpm"] is None
    assert set(summary["results"]) == {"given"}
    assert summary["loads"]["given"]["pin_axial_N"] == pytest.approx(-45914.9, rel=1e-5)
    assert summary["loads"]["given"]["crank_deg"] is None


def test_a_low_safety_factor_is_exit_6(tmp_path):
    assert fea("run", *PLAIN, "--min-safety", 99, "--quiet", cwd=tmp_path).returncode == 6
    assert (tmp_path / "results" / "plain-6000rpm" / "summary.json").exists()


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (("run", "--rpm", "-5"), 2, "speed.rpm"),
        (("run", "--rpm", "fast"), 2, "--rpm"),
        (("run", "--rpm", "1e6"), 2, "50000"),
        (("run", "--size", "0"), 2, "mesh.size_mm"),
        (("run", "--size", "nan"), 2, "mesh.size_mm"),
        (("run", "--size", "0.01", "--unusual"), 2, "mm or more"),
        (("run", "--nonsense"), 2, "--nonsense"),
        (("run", "--support", "glue"), 2, "glue"),
        (("run", "--fatigue", "gerber"), 2, "--cycle"),
        (("run", "leon-2001-as-published", "--rpm", "3000"), 2, "[forces], which have no speed"),
        (("rod", "--mass-kg", "0.8"), 2, "--fit"),
        (("rod", "--step", "nowhere/rod.step"), 2, "nowhere"),
        (("loads", "--plot", "cycle.docx"), 2, ".svg"),
        (("loads", "--csv", "occupied/mine.txt"), 2, ".csv"),
        (("rod", "--step", "occupied/mine.txt"), 2, ".step"),
        (("rod", "--step", "."), 2, "is a directory"),
        (("verify", "le1", "--report", "occupied/mine.txt"), 2, ".md"),
        (("verify", "le1", "--report", "occupied"), 2, "is a directory"),
        (("init", "."), 2, "is a directory"),
        (("run", "--rpm", "1000.0000001,1000.0000002"), 2, "six digits"),
        (("run", "no-such-study"), 2, "no-such-study"),
        (("run", "--out", "occupied"), 2, "occupied"),
        (("run", "--threads", "0"), 2, "--threads"),
        (("view", "missing.vtu"), 2, "missing.vtu"),
        (("view", "missing.html"), 2, "is not a file"),
        (("view", "missing.html", "--field", "mean"), 2, "which shows every field"),
        (("report", "occupied"), 2, "summary.json"),
        (("run", "--pvd-step", "10"), 2, "Add --cycle"),
        (("view", "missing.vtu", "--out", "study.toml"), 2, "--out = 'study.toml': must end in .png"),
        (("view", "occupied"), 2, "summary.json"),
        (("report", "occupied", "--out", "report.txt"), 2, "must end in .html"),
        (("rod", "--out", "rod.txt"), 2, "must end in .png or .step or .stp"),
        (("rod", "--fit", "big_end_ring_mm", "--out", "rod.png"), 2, "must end in .toml"),
        (("loads", "--out", "cycle.docx"), 2, ".svg"),
        (("loads", "--out", "cycle.csv", "--csv", "other.csv"), 2, "names the same file again"),
        (("modes", "--out", "modes.png"), 2, "must end in .vtu"),
        (("schema", "--out", "schema.txt"), 2, "must end in .json"),
        (("verify", "le1", "--out", "report.txt"), 2, "must end in .md"),
        (("frobnicate",), 2, "frobnicate"),
        (("init", "occupied/mine.txt"), 2, "exists"),
    ],
)
def test_bad_usage_is_one_line_and_its_code(arguments, code, says, tmp_path):
    (tmp_path / "occupied").mkdir()
    (tmp_path / "occupied" / "mine.txt").write_text("keep me")
    done = fea(*arguments, cwd=tmp_path)
    assert done.returncode == code, done.stderr
    assert says in done.stderr
    assert done.stderr.count("\n") <= 2
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
    assert (tmp_path / "occupied" / "mine.txt").read_text() == "keep me"
    assert not (tmp_path / "results").exists()


def test_init_writes_a_study_that_runs(tmp_path):
    assert fea("init", "mine.toml", cwd=tmp_path).returncode == 0
    done = fea("run", "mine.toml", "--size", 12, "--pressure", "cosine-180", "--quiet", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert fea("init", "mine.toml", cwd=tmp_path).returncode == 2


def test_python_does_the_same_job(tmp_path, monkeypatch):
    from fea import run

    monkeypatch.chdir(tmp_path)
    summary = run(rpm=3000, size=12, pressure="cosine-180", out="here")
    assert summary["rpm"] == 3000
    assert (tmp_path / "here" / "summary.json").exists()


@pytest.mark.slow
def test_doctor_examines_the_machine(tmp_path):
    done = fea("doctor", "--json", cwd=tmp_path)
    findings = {finding["what"]: finding for finding in json.loads(done.stdout)}
    assert findings["geometry and meshing"]["good"]
    assert done.returncode == 0


def test_rod_tells_its_figures(tmp_path):
    rod = figures("rod", cwd=tmp_path)
    # León 2001 as printed: 0.785 kg, 64 mm, A = 89 mm², I = 1260 mm⁴; the preset meets them to 0.1 %
    assert rod["mass_kg"] == pytest.approx(0.785, rel=1e-3)
    assert rod["center_of_gravity_mm"][0] == pytest.approx(64, rel=1e-3)
    assert rod["least_section"]["area_mm2"] == pytest.approx(89, rel=1e-3)
    assert rod["least_section"]["inertia_z_mm4"] == pytest.approx(1260, rel=2e-3)
    assert rod["slenderness"]["in_plane"] == pytest.approx(37.44, rel=2e-3)


def test_a_sweep_replaces_an_earlier_one_whole_or_not_at_all(tmp_path):
    assert fea("run", *PLAIN, "--rpm", "3000,6000", "--out", "r", "--quiet", cwd=tmp_path).returncode == 0
    done = fea("run", *PLAIN, "--rpm", "3000,4000", "--out", "r", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert {entry.name for entry in (tmp_path / "r").iterdir()} == {"3000rpm", "4000rpm", "map.csv"}
    (tmp_path / "r" / "mine.txt").write_text("keep me")
    done = fea("run", *PLAIN, "--rpm", "1000,2000", "--out", "r", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("fea: r contains files that are not from an earlier run")
    assert {entry.name for entry in (tmp_path / "r").iterdir()} == {
        "3000rpm",
        "4000rpm",
        "map.csv",
        "mine.txt",
    }
    assert {entry.name for entry in tmp_path.iterdir()} == {"r"}
