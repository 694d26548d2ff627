"""`fea schema` describes what the reader reads: the same keys, types and choices."""

import json
import re
import tomllib
from importlib.resources import files
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from fea.analysis.engine_study import engine_study
from fea.output.json_file import json_text
from fea.study.documents import SCHEMA_FILE, is_schema, study_schema, template
from fea.study.study import TABLES, load_study, parse_study, shipped_studies
from fea.study.tables import own_unit, stem
from geometry.errors import InvalidValue

SCHEMA = json.loads(json_text(study_schema()))
VALID = Draft202012Validator(SCHEMA)
NAMES = list(TABLES)
ROD = '[rod]\npreset = "leon-2001"\n'
STUDIES = {
    **{name: (files("fea") / "studies" / f"{name}.toml").read_text("utf-8") for name in shipped_studies()},
    "template": template(),
    "template, all": ROD + re.sub(r"(?m)^# (\[|\w+ = )", r"\1", template()[template().index("[mesh]") :]),
    "engine by name": 'engine = "toyota-2jz"\n' + ROD,
    "engine by an alias": 'engine = "K20A"\n' + ROD,
    "engine by an alias in its table": ROD + '[engine]\npreset = "LS 3"',
    "engine with changes": ROD + '[engine]\npreset = "toyota-2jz"\nfriction = 0.1',
    "speeds": ROD + "[speed]\nrpm = [800, 3000.0]",
    "parts": ROD + "[material.bushing]\nE_GPa = 110.0\nnu = 0.34\ndensity_kg_m3 = 8800.0\nyield_MPa = 250.0",
    "masses": "[rod]\nlength_mm = 9.0\nmass_kg = 1\ncenter_of_gravity_mm = 3.0\ninertia_kg_m2 = 1.0",
}


def read(text):
    return parse_study(text, "test", Path.cwd())


def test_it_is_a_schema():
    Draft202012Validator.check_schema(SCHEMA)
    assert is_schema(json_text(study_schema()))
    assert template().startswith(f"#:schema ./{SCHEMA_FILE}\n")


@pytest.mark.parametrize("name", STUDIES)
def test_what_the_reader_accepts_is_valid(name):
    assert list(VALID.iter_errors(tomllib.loads(STUDIES[name]))) == []
    read(STUDIES[name])


def test_the_study_of_an_engine_and_a_resolved_one_are_valid():
    for text in (engine_study("honda-b18c5"), load_study().text()):
        VALID.validate(tomllib.loads(text))


@pytest.mark.parametrize("name", NAMES)
def test_an_unknown_key_is_refused_by_both_and_both_know_the_same_ones(name):
    text = (ROD if name != "rod" else "") + f"[{name}]\nmisspelt = 1.0\n"
    with pytest.raises(InvalidValue, match="unknown key") as refused:
        read(text)
    assert not VALID.is_valid(tomllib.loads(text))
    known = re.search(r"Valid names: (.*)\.", str(refused.value))[1].split(", ")
    keys = SCHEMA["$defs"][name]["properties"]
    without = {stem(key) for key in keys} - {key for key in keys if own_unit(key) or key in known}
    assert sorted(key for key in keys if not keys[key].get("deprecated") and key not in without) == known


def test_an_unknown_table_is_refused_by_both():
    text = ROD + "[misspelt]\n"
    with pytest.raises(InvalidValue, match="unknown key") as refused:
        read(text)
    assert not VALID.is_valid(tomllib.loads(text))
    known = re.search(r"Valid names: (.*)\.", str(refused.value))[1].split(", ")
    assert sorted(SCHEMA["properties"]) == known


@pytest.mark.parametrize(
    "text",
    [
        "[speed]\nrpm = 3",
        "[rod]\nlength_mm = 3.0",
        '[rod]\npreset = "lion-2001"',
        'engine = "steam"\n' + ROD,
        'engine = "honda-k20a-b"\n' + ROD,
        'engine = "toyota-2jz"\n' + ROD + "[forces]\npin_N = [1.0, 0.0]",
        ROD + "[engine]\nbore_mm = 76.0",
        ROD + '[engine]\npreset = "toyota-2jz"\ncylinders = 4.5',
        ROD + '[mesh]\nelement = "p3"',
        ROD + "[mesh]\nsize_mm = true",
        ROD + '[speed]\nrpm = "fast"',
        ROD + "[material.bushing]\nE_Gpa = 110.0",
    ],
)
def test_what_the_schema_refuses_the_reader_refuses(text):
    assert not VALID.is_valid(tomllib.loads(text))
    with pytest.raises(InvalidValue):
        read(text)


@pytest.mark.parametrize("name", NAMES)
def test_every_key_is_described_with_its_unit(name):
    for key, entry in SCHEMA["$defs"][name]["properties"].items():
        said = entry["description"]
        assert said
        assert "# " not in said
        if key.endswith("_mm"):
            assert ", mm" in said
    size = SCHEMA["$defs"]["mesh"]["properties"]["size_mm"]
    assert size["description"].endswith("unless a tolerance is given")
