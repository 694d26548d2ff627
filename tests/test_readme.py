"""What the README shows is what happens; `make docs` runs what the manual shows."""

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from program import fea

from fea.__main__ import commands, program
from fea.study.study import load_study, parse_study

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str, text: str = README) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def manual(page: str) -> str:
    return (ROOT / "docs" / page).read_text(encoding="utf-8")


def shown(command: str) -> list[str]:
    """The lines the README shows below a command."""
    text = re.search(rf"^\$ {re.escape(command)}\n(.*?)^(?:\$|```)", README, re.MULTILINE | re.DOTALL)
    assert text, f"the README does not show `{command}`"
    return text[1].splitlines()


def made_by(target: str) -> list[str]:
    """The last command of a target of the Makefile, without what stands before the program's name."""
    recipe = re.search(rf"^{target}:.*\n((?:\t.*\n)+)", (ROOT / "Makefile").read_text(), re.MULTILINE)
    return shlex.split(recipe[1].splitlines()[-1].partition("$(BIN)/")[2])


def run(arguments: list[str], folder: Path) -> list[str]:
    done = fea(*arguments, cwd=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def numbers(line: str) -> list[float]:
    """The numbers of a line without their signs: of two places that mirror each other either may be named."""
    return [float(number) for number in re.findall(r"\d+(?:\.\d+)?", line)]


def words(line: str) -> list[str]:
    """What remains of a line without its numbers; a rule is as wide as its table."""
    return re.sub(r"[-+]?\d+(?:\.\d+)?", "#", line).replace("─", "").split()


@pytest.fixture(scope="module")
def printed(tmp_path_factory) -> list[str]:
    program, *arguments = made_by("run")
    assert program == "fea"
    return run(arguments, tmp_path_factory.mktemp("readme"))


def test_make_run_prints_what_the_readme_shows(printed):
    expected = shown("make run")
    assert [words(line) for line in printed] == [words(line) for line in expected]
    for line, promised in zip(printed, expected, strict=True):
        if "checks passed" not in line:  # nodes and seconds depend on gmsh and the machine
            # Rows of the table hold coordinates and forces that may be near 0.
            absolute = 0.1 if len(numbers(line)) > 8 else 0.02
            assert numbers(line) == pytest.approx(numbers(promised), rel=0.05, abs=absolute)


def test_make_test_runs_pytest():
    assert made_by("test")[:3] == ["python", "-m", "pytest"]


def test_the_study_of_the_readme_runs(tmp_path, monkeypatch):
    monkeypatch.setattr("fea.rod.discretise.PER_TOUCHED_BORE", 24)  # sooner
    (study,) = blocks("toml")
    (tmp_path / "my-study.toml").write_text(study)
    run(["run", "my-study.toml", "--size", "12", "--out", "run"], tmp_path)
    assert (tmp_path / "run" / "summary.json").exists()


def test_the_study_in_us_units_of_the_manual(tmp_path):
    (us,) = blocks(r"{file} us\.toml", manual("do/units.md"))
    (tmp_path / "us.toml").write_text(us, encoding="utf-8")
    printed = "\n".join(run(["loads", "us.toml"], tmp_path))
    assert " lbf " in printed
    assert " N " not in printed
    assert load_study(str(tmp_path / "us.toml")).engine.stroke_mm == pytest.approx(3.48 * 25.4)


def test_the_keys_of_a_rod_from_cad_are_what_the_manual_says(tmp_path):
    (table,) = blocks("toml", manual("do/mesh-from-elsewhere.md"))
    (tmp_path / "crank-drive.step").touch()
    study = parse_study(table.replace("\n# ", "\n"), "manual", tmp_path)
    assert study.rod.as_dict().keys() == {"step", "solids", "unit", "cap", "big_end_bore_mm", "swap_ends"}


def test_the_assembly_of_the_manual_is_the_shipped_one(tmp_path):
    (table,) = blocks("toml", manual("do/bolted.md"))
    told, shipped = parse_study(table, "manual", tmp_path), load_study("leon-2001-bolted")
    assert told.rod == shipped.rod
    own, other = vars(told.assembly), vars(shipped.assembly)
    assert {key for key in own if own[key] != other[key]} == {"joint_friction", "temperature_C"}
    assert told.assembly.friction == shipped.assembly.friction


@pytest.mark.parametrize("code", blocks("python"))
def test_the_python_of_the_readme_runs(code, tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert all(float(line) > 0 for line in done.stdout.splitlines())


def test_the_notebook_of_the_manual_has_cells_and_no_outputs():
    notebook = json.loads(manual("do/rods.ipynb"))
    code = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert len(code) > 5
    for cell in code:
        compile("".join(cell["source"]), "cell", "exec")
        assert (cell["outputs"], cell["execution_count"]) == ([], None)  # the build runs it


def test_the_files_the_readme_names_exist():
    for name in re.findall(r"\]\(([^)#:]+)\)|`((?:geometry|mesh|loads|fea|tests)/[\w./]*)`", README):
        assert (ROOT / "".join(name)).exists(), name


def test_the_files_the_manual_names_exist():
    pages = (ROOT / "docs").glob("[!_]*/*.md")
    text = "".join(page.read_text(encoding="utf-8") for page in pages)
    names = set(re.findall(r"`((?:geometry|mesh|loads|fea|tests)/[\w./]+)`", text))
    assert len(names) > 30
    assert not {name for name in names if not (ROOT / name).exists()}


@pytest.mark.parametrize("name", ["leon-2001-6000rpm.png", "report.png"])
def test_what_the_first_screen_shows_is_small(name):
    assert f"results/{name}" in README.partition("## Installation")[0]
    assert (ROOT / "results" / name).stat().st_size < 300_000


def test_the_picture_of_the_joint_is_small():
    assert (ROOT / "results" / "leon-2001-bolted-joint.png").stat().st_size < 300_000


def test_every_system_installs_and_runs_in_two_commands():
    table = README.partition("## Installation")[2].partition("## ")[0]
    rows = [row.split("|") for row in re.findall(r"(?m)^\| (?:Linux|Windows).*$", table)]
    assert "macOS" in rows[0][1]
    for _, _, install, first, _ in rows:
        assert "pip install ." in install
        assert "fea run --rpm 6000" in first


@pytest.mark.parametrize("command", commands())
def test_the_help_of_a_command_names_its_page_of_the_manual(command):
    page = re.search(r"Manual: docs/(\S+)$", program()[command].help)[1]
    assert re.search(rf"fea {command}\b", manual(page))
