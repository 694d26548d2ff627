"""What is around a study: engines by name, the schema for editors, completion in the shell."""

import json
import re
import subprocess
import tomllib

import pytest
from jsonschema import Draft202012Validator
from program import fea

from fea.study.documents import template
from fea.study.study import parse_study

pytestmark = pytest.mark.slow


SCHEMA = "fea-study.schema.json"


def test_the_study_of_an_engine_runs_as_it_is_and_says_what_is_assumed(tmp_path):
    assert fea("init", "--engine", "subaru-ej25", "ej25", cwd=tmp_path).returncode == 0
    text = (tmp_path / "ej25.toml").read_text()
    for key in ("boost_bar", "full_load"):  # as `fea init` without an engine explains them
        (line,) = re.findall(rf"(?m)^# {key} = .*$", text)
        assert line in template()
    boosted, _ = re.subn(r"(?m)^# (boost_bar = )", r"\1", text)
    assert parse_study(boosted, "boosted", tmp_path).engine.boost_bar == 1.0
    done = fea("run", "ej25.toml", "--size", 14, "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert summary["trusted"] is True
    assert summary["rpm"] == 6500
    assert summary["rod"]["mass_kg"] == pytest.approx(0.535, rel=0.01)
    assert any("assumed peak_pressure_bar = 65" in note for note in summary["notes"])
    left = tomllib.loads((tmp_path / "results" / "ej25-6500rpm" / "study.toml").read_text())
    assert left["engine"]["preset"] == "subaru-ej25"
    assert left["engine"]["piston_mass_kg"] == 0.566


def test_an_engine_replaces_that_of_a_shipped_study_and_of_a_file(tmp_path):
    (tmp_path / "mine.toml").write_text('[rod]\npreset = "leon-2001"\n')
    for study, rpm in (("leon-2001", 6000), ("mine.toml", 5250)):
        done = fea("loads", study, "--engine", "jeep-4.0", "--json", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        figures = json.loads(done.stdout)
        assert figures["rpm"] == rpm
        assert "155.57 mm long, the one of this study 141 mm" in figures["note"]


@pytest.mark.parametrize("command", [("run",), ("loads",), ("init", "mine.toml")])
def test_an_engine_that_is_not_there_lists_those_that_are(command, tmp_path):
    done = fea(*command, "--engine", "3jz", cwd=tmp_path)
    assert done.returncode == 2
    assert "--engine = '3jz': is not an engine of the library" in done.stderr
    assert "toyota-2jz" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_materials_are_listed_by_all_their_names_and_one_with_its_sources(tmp_path):
    listed = fea("materials", cwd=tmp_path).stdout
    for name in ("4340", "EN24", "C70S6", "42CrMo4", "7075-T6", "bolt-ARP 2000"):
        assert name in listed
    (one,) = json.loads(fea("materials", "817m40", "--json", cwd=tmp_path).stdout)
    assert one["name"] == "EN24-T"
    assert one["figures"].keys() <= one["sources"].keys()
    assert "BS 970" in fea("materials", "en24 t", cwd=tmp_path).stdout
    wrong = fea("materials", "4430", cwd=tmp_path)
    assert wrong.returncode == 2
    assert "Did you mean 4340" in wrong.stderr


def test_init_leaves_the_schema_that_its_first_line_names(tmp_path):
    assert fea("init", cwd=tmp_path).returncode == 0
    first, *_ = (tmp_path / "study.toml").read_text().splitlines()
    assert first == f"#:schema ./{SCHEMA}"
    printed = fea("schema", cwd=tmp_path)
    assert printed.returncode == 0
    assert (tmp_path / SCHEMA).read_text() == printed.stdout
    Draft202012Validator(json.loads(printed.stdout)).validate(
        tomllib.loads((tmp_path / "study.toml").read_text())
    )


def test_init_renews_its_own_schema_and_keeps_a_file_of_the_user(tmp_path):
    (tmp_path / SCHEMA).write_text("mine")
    assert SCHEMA not in fea("init", "one.toml", cwd=tmp_path).stdout
    assert (tmp_path / SCHEMA).read_text() == "mine"
    (tmp_path / SCHEMA).write_text('{"title": "Study of a connecting rod for fea"}')
    assert SCHEMA in fea("init", "two.toml", cwd=tmp_path).stdout
    assert "properties" in (tmp_path / SCHEMA).read_text()


def test_completion_is_installed_and_completes(tmp_path):
    done = fea("--install-completion", "--shell", "bash", cwd=tmp_path, environment={"HOME": str(tmp_path)})
    assert done.returncode == 0, done.stderr
    (script,) = (path for path in tmp_path.rglob("fea") if path.is_file())
    assert str(script) in (tmp_path / ".bashrc").read_text()
    asked = "source {}; COMP_WORDS=({}); COMP_CWORD={}; _fea; echo ${{COMPREPLY[@]}}"
    for words, at, expected in (("fea sch", 1, "schema"), ("fea run --engi", 2, "--engine")):
        shell = subprocess.run(
            ["bash", "-c", asked.format(script, words, at)], capture_output=True, text=True, check=True
        )
        assert shell.stdout.split() == [expected]
