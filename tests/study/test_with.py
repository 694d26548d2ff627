"""A study with other tables, in Python: as if its file had been written so."""

from dataclasses import replace

import pytest

from fea.base.choices import Element
from fea.study.option_tables import MeshTable
from fea.study.study import ASSUMED_MATERIAL, load_study, parse_study
from geometry.errors import InvalidValue

LEON = load_study("leon-2001")


def written(text):
    return parse_study(f'rod.preset = "leon-2001"\n{text}', "leon-2001", LEON.folder)


@pytest.mark.parametrize(
    ("changes", "table", "text"),
    [
        ({"rod": {"length": "5.7 in"}}, "rod", 'rod.length = "5.7 in"'),
        ({"rod": {"oil_hole_mm": 3.0}}, "rod", "rod.oil_hole_mm = 3.0"),
        ({"material": "4340"}, "material", 'material.preset = "4340"'),
        ({"material": {"preset": "4340", "yield": "150 ksi"}}, "material",
         'material = { preset = "4340", yield = "150 ksi" }'),
        ({"engine": "toyota-2jz"}, "engine", 'engine.preset = "toyota-2jz"'),
        ({"engine": {"preset": "toyota-2jz", "stroke": "3.5 in"}}, "engine",
         'engine = { preset = "toyota-2jz", stroke = "3.5 in" }'),
        ({"speed": "100 Hz"}, "speed", "speed.rpm = 6000.0"),
        ({"speed": [3000, 6000]}, "speed", "speed.rpm = [3000, 6000]"),
        ({"mesh": {"size": "8 mm", "element": "p1"}}, "mesh", 'mesh = { size_mm = 8.0, element = "p1" }'),
        ({"contact": {"small_end_clearance": "20 um"}}, "contact", 'contact.small_end_clearance = "20 um"'),
        ({"gauge": [{"at_mm": [72, 0, 6], "direction": [1, 0, 0], "length": "3 mm"}]}, "gauge",
         "gauge = [{ at_mm = [72, 0, 6], direction = [1, 0, 0], length_mm = 3 }]"),
    ],
)  # fmt: skip
def test_a_change_is_what_a_file_would_say(changes, table, text):
    changed = LEON.with_(**changes)
    assert getattr(changed, table) == getattr(written(text), table)
    assert replace(changed, **{table: getattr(LEON, table)}) == LEON  # and nothing else has changed


def test_keys_that_are_not_named_stay():
    changed = LEON.with_(engine={"piston_mass": "380 g"}).with_(engine={"stroke_mm": 90.0})
    assert changed.engine == replace(LEON.engine, piston_mass_kg=0.38, stroke_mm=90.0)
    assert changed.with_(material={"yield_MPa": 900}).material == replace(ASSUMED_MATERIAL, yield_MPa=900.0)


def test_tables_are_taken_as_they_are():
    coarse = MeshTable(size_mm=9.0, element=Element.P1)
    assert LEON.with_(mesh=coarse).mesh is coarse
    other = LEON.with_rod(web_thickness_mm=4.0)
    assert LEON.with_(rod=other.rod, engine=other.engine) == other


def test_none_takes_away_a_key_or_a_table():
    changed = LEON.with_(engine={"piston_mass_kg": 0.4}, mesh={"size_mm": 8.0}, speed=4000)
    assert changed.with_(mesh={"size": None}).mesh == LEON.mesh
    assert changed.with_(mesh=None, speed=None).speeds() == (6000.0,)
    assert LEON.with_(engine=None, forces={"pin": ["1 kN", "0 N"]}).forces.pin_N == (1000.0, 0.0)
    with pytest.raises(InvalidValue, match=r"engine\.stroke_mm is missing"):
        LEON.with_(engine={"stroke_mm": None})


def test_materials_of_parts_come_and_go():
    both = LEON.with_(material={"preset": "4340", "bushing": {"preset": "cusn8p"}})
    assert (both.material.preset, both.part_material["bushing"].preset) == ("4340", "cusn8p")
    assert LEON.with_(material="4340") == both.with_(material={"bushing": None})


def test_a_new_table_switches_on_what_it_does_in_a_file():
    assert LEON.with_(duty={"rpm": [3000], "hours": [10]}, material="4340").analysis.cycle
    film = LEON.with_(film={"viscosity_mPas": 8.0})
    assert film.analysis.film
    off = LEON.with_(film={"viscosity_mPas": 8.0}, analysis={"film": False})
    assert not off.with_(film={"viscosity_mPas": 9.0}).analysis.film  # it had the table before


def test_a_length_with_its_unit_is_known_to_be_meant():
    # As in a file: only a bare number may be in another unit than its key says.
    assert LEON.with_rod(length="24 in").text() == LEON.with_(rod={"length": "24 in"}).text()
    assert "in" not in LEON.with_rod(length="24 in").with_rod(length_mm=610).rod.written
    assert LEON.with_rod(length="24 in").rod.written == {"length_mm"}


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"rods": {}}, "Did you mean rod"),
        ({"rod": {"lngth": "141 mm"}}, "Did you mean length_mm"),
        ({"rod": {"lngth": None}}, "unknown key"),
        ({"rod": {"length": 141}}, "has no unit"),
        ({"rod": None}, "must be a table"),
        ({"mesh": 8.0}, "must be a table"),
        ({"material": 8.0}, "must be a table"),
        ({"mesh": {"sise": None}}, "unknown key"),
        ({"speed": True}, "must be a finite number"),
        ({"speed": "fast"}, r"^rpm = 'fast': is not a speed"),
        ({"material": "433"}, "is not in the library"),
        ({"forces": {"pin_N": [1.0, 0.0]}}, r"cannot be combined with \[engine\]"),
        ({"engine": None, "forces": {"pin_N": [1.0, 0.0]}, "speed": 3000}, "have no speed"),
        ({"output": {"pvd_step_deg": 10}}, "Add cycle=True"),
        ({"rod": {"step": "missing.step"}}, "is not a file"),
    ],
)
def test_what_breaks_a_rule_is_refused(changes, says):
    with pytest.raises(InvalidValue, match=says):
        LEON.with_(**changes)
