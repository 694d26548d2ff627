"""Values with units: every key whose name holds a unit takes them, and nothing else changes."""

import json
import math
import subprocess
import sys
import tomllib
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from fea.apps.sweep.sweep_file import parse_sweep
from fea.base.units import OTHER_UNITS
from fea.output.json_file import json_text
from fea.study.documents import study_schema
from fea.study.flags import Flags
from fea.study.option_tables import parse_free
from fea.study.study import TABLES, load_study, parse_study, shipped_studies, study_of_tables
from fea.study.tables import hints_of, in_own_units, keys_of, own_unit, quantity, stem
from geometry.errors import InvalidValue

ROD = '[rod]\npreset = "leon-2001"\n'
# The units of an American drawing; temperatures have another zero.
US = {
    "mm": "in", "um": "in", "kg": "lb", "kg_m2": "lb in²", "kg_m3": "lb/in³", "GPa": "Mpsi", "MPa": "psi",
    "bar": "psi", "kN": "lbf", "N": "lbf", "Nm": "lbf ft", "1_K": "1/°F", "bar_V": "psi/V",
}  # fmt: skip
NAMED = {"in": "inches", "lb in²": "lb·in²", "lbf ft": "lbf·ft"}


def read(text):
    return parse_study(text, "test", Path.cwd())


def in_units(value, own, unit):
    """A number in the unit of its key as a text in another unit."""
    if isinstance(value, list):
        return [in_units(each, own, unit) for each in value]
    if own == "C":
        return f"{value * 1.8 + 32!r} °F"
    return f"{value / OTHER_UNITS[own][NAMED.get(unit, unit)]!r} {unit}"


def rewritten(table):
    """A table of a study in other units, by the keys without units."""
    found = {}
    for key, value in table.items():
        own = own_unit(key)
        unit = "°F" if own == "C" else US.get(own)
        if isinstance(value, Mapping):
            found[key] = rewritten(value)
        elif own and unit and not isinstance(value, str):
            found[stem(key)] = in_units(value, own, unit)
        else:
            found[key] = value
    return found


def assert_same(one, other):
    assert one.keys() == other.keys()
    for key, value in one.items():
        if isinstance(value, Mapping):
            assert_same(value, other[key])
        elif isinstance(value, float | list) and not isinstance(value, str):
            assert other[key] == pytest.approx(value, rel=1e-12, abs=0), key
        else:
            assert other[key] == value


@pytest.mark.parametrize("name", shipped_studies())
def test_a_shipped_study_in_us_units_is_the_same_study(name):
    raw = tomllib.loads((files("fea") / "studies" / f"{name}.toml").read_text("utf-8"))
    us = rewritten(raw)
    assert us != raw
    assert_same(
        tomllib.loads(load_study(name).text()), tomllib.loads(study_of_tables(us, name, Path.cwd()).text())
    )


KEYS = [
    (table, key)
    for table, cls in TABLES.items()
    for key in keys_of(cls)
    if own_unit(key) and own_unit(key) != key
]


@given(st.sampled_from(KEYS), st.floats(1e-6, 1e6), st.data())
@settings(max_examples=200, deadline=None)
def test_every_key_takes_every_unit_of_its_kind(place, value, data):
    own = own_unit(place[1])
    unit = data.draw(st.sampled_from([*OTHER_UNITS[own]] or [""]))
    assert "float" in str(hints_of(TABLES[place[0]])[place[1]])
    if own == "C":
        expected = (value - 32) / 1.8
        assert quantity("key", f"{value!r} °F", own) == pytest.approx(expected, rel=1e-12, abs=1e-12)
    elif unit and not unit[0].isdigit():
        expected = value * OTHER_UNITS[own][unit]
        assert quantity("key", f"{value!r} {unit}", own) == pytest.approx(expected, rel=1e-12)


def test_keys_that_differ_in_their_unit_only():
    # Pressure and temperature of oil, hours and speed of a search: without a unit, the first key is meant.
    known = {"film": {"inlet"}, "optimise": {"min"}}
    for name, cls in TABLES.items():
        stems = [stem(key) for key in keys_of(cls)]
        assert {each for each in stems if stems.count(each) > 1} == known.get(name, set())
    film = TABLES["film"]
    read = in_own_units(film, "film", {"inlet": "58 psi", "inlet_C": "230 °F"})
    assert read == pytest.approx({"inlet_bar": 3.99896, "inlet_C": 110.0}, rel=1e-5)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("5.7in", "mm", 144.78), ('5.7"', "mm", 144.78), ("5 11/16 in", "mm", 144.4625),
        ("3/8 in", "mm", 9.525), ("-.5 thou", "mm", -0.0127), ("45 ft-lb", "Nm", 61.0118077),
        ("45 lb-ft", "Nm", 61.0118077), ("45 lbf·ft", "Nm", 61.0118077), ("100 in lbs", "Nm", 11.2984829),
        ("212 F", "C", 100.0), ("293.15 K", "C", 20.0), ("6.4e-6/°F", "1_K", 11.52e-6),
        ("628 rad/s", "rpm", 5996.958), ("100 Hz", "rpm", 6000.0), ("0.5 turn", "deg", 180.0),
        ("5 %", "percent", 5.0), ("30 Msi", "GPa", 206.8427), ("14.7 psi", "bar", 1.013529),
        ("2 days", "hours", 48.0),
    ],
)  # fmt: skip
def test_units_are_read_as_they_are_written(text, unit, value):
    assert quantity("key", text, unit) == pytest.approx(value, rel=2e-6)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("length = 5.7", r"rod.length = 5.7: has no unit. Write number and unit"),
        ('length_mm = "5.7"', "a number and its unit"),
        ('length = "5.7 lb"', "not in a unit of the right kind: lb. Give it in inches, cm, m, µm or mm"),
        ('mass = "2 lbf"', "not in a unit of the right kind: lbf. Give it in g, lb, t or kg"),
        ('length = "5.7 inx"', "unknown unit: inx. Did you mean inches"),
        ('length = "5.7 in"\nlength_mm = 144.78', "given twice, with its unit and without"),
        ('length = "5,7 in"', "has a comma in its number. Write a decimal point, not a comma: 5.7"),
        ('length = "long"', "must be a number, or a text of a number and its unit"),
        ('length = "9**9**9 in"', "has a unit that cannot be read"),
        ('length = "1/0 in"', "must be a finite number"),
        ('length = "-5 in"', "must be positive"),
        ("length_in = 5.7", 'Give length_mm, which is 25.4 times .*, or length = "5.7 inches"'),
        ('unit = "5 in"', "unit"),
    ],
)
def test_what_is_no_quantity_of_its_kind_is_refused(line, message):
    with pytest.raises(InvalidValue, match=message):
        read("[rod]\nbig_end_bore_mm = 50\nsmall_end_bore_mm = 22\n" + line)


@pytest.mark.parametrize("text", ["5", "5 %", "5 mm"])
def test_an_angle_is_not_any_plain_number(text):
    with pytest.raises(InvalidValue, match="unit"):
        quantity("key", text, "deg")


def test_lists_parts_and_free_dimensions_have_units_too():
    study = read(
        '[rod]\npreset = "leon-2001"\n[material]\npreset = "leon-2001"\nyield = "90 ksi"\n'
        '[material.piston_pin]\nE = "30 Mpsi"\nnu = 0.3\n'
        '[contact]\nsmall_end_relief = ["0.16 in", "0.8 thou"]\n'
        '[optimise]\nfree = { web_thickness = ["0.1 in", "0.3 in"], big_end_ring_mm = [6, "0.5 in"] }\n'
        '[engine]\npreset = "toyota-2jz"\nstroke = "3.5 in"\n'
    )
    assert study.material.yield_MPa == pytest.approx(620.528, rel=1e-6)
    assert study.part_material["piston_pin"].E_GPa == pytest.approx(206.843, rel=1e-5)
    assert study.contact.small_end_relief_mm == pytest.approx((4.064, 0.02032))
    assert study.optimise.free == {
        "web_thickness_mm": pytest.approx((2.54, 7.62)),
        "big_end_ring_mm": pytest.approx((6, 12.7)),
    }
    assert study.engine.stroke_mm == pytest.approx(88.9)
    assert study.with_rod(web_thickness="0.2 in").rod.dimensions.web_thickness == pytest.approx(5.08)


def test_flags_and_bounds_have_units_too():
    flags = Flags(size="0.2 in", tolerance="2 %")
    asked = flags.applied(load_study())
    assert (asked.mesh.size_mm, asked.analysis.tolerance_percent) == (pytest.approx(5.08), 2.0)
    assert parse_free(["web_thickness=0.1in:0.3in", "big_end_ring_mm=6:12"]) == {
        "web_thickness_mm": pytest.approx((2.54, 7.62)),
        "big_end_ring_mm": (6.0, 12.0),
    }
    with pytest.raises(InvalidValue, match="has no unit"):
        parse_free(["web_thickness=3:7"])


def test_a_sweep_varies_quantities():
    raw = tomllib.loads(
        'study = "leon-2001"\nsampling = "random"\nsamples = 3\nset.material.yield = "90 ksi"\n'
        'vary.rod.web_thickness = { from = "0.16 in", to = "0.24 in" }\n'
        'vary.contact.small_end_clearance_mm = { distribution = "normal", from = 0.01, to = 0.03, '
        'mean = 0.02, deviation = "0.1 thou" }\n'
        'vary.rod.flange_thickness = ["0.12 in", "0.13 in"]\n'
        'vary.material.endurance = { from = "40 ksi", to = "50 ksi" }\n'
    )
    sweep = parse_sweep(raw, "test", Path.cwd())
    assert (sweep.varied["rod.web_thickness_mm"].low, sweep.varied["rod.web_thickness_mm"].high) == (
        pytest.approx(4.064), pytest.approx(6.096))  # fmt: skip
    assert sweep.varied["contact.small_end_clearance_mm"].deviation == pytest.approx(2.54e-3)
    assert sweep.varied["rod.flange_thickness_mm"].options == pytest.approx((3.048, 3.302))
    assert sweep.varied["material.endurance_MPa"].high == pytest.approx(344.7379)
    assert sweep.base.study(sweep.designs()[0]).material.yield_MPa == pytest.approx(620.528, rel=1e-6)
    with pytest.raises(InvalidValue, match=r"vary.rod.web_thickness.from = 4: has no unit"):
        parse_sweep({**raw, "vary": {"rod": {"web_thickness": {"from": 4, "to": 5}}}}, "test", Path.cwd())


def test_a_deviation_of_temperatures_has_no_zero():
    assert quantity("key", "9 °F", "C", change=True) == pytest.approx(5.0)


def test_what_no_engine_has_is_still_seen():
    with pytest.raises(InvalidValue, match=r"engine.stroke_mm"):
        Flags().applied(
            read('[rod]\npreset = "leon-2001"\n[engine]\npreset = "toyota-2jz"\nstroke = "3.5 mm"')
        )


def test_the_schema_tells_both_forms():
    valid = Draft202012Validator(json.loads(json_text(study_schema())))
    forms = ['stroke = "3.5 in"', "stroke_mm = 89", 'stroke_mm = "3.5 in"']
    for form in forms:
        text = f'{ROD}[engine]\n{form}\nbore_mm = 76\npiston_mass = "1 lb"\n[speed]\nrpm = "600 rad/s"'
        assert valid.is_valid(tomllib.loads(text)), form
        read(text)
    for form in ("stroke = 3.5", 'stroke = "3.5"', "bore = 3"):
        assert not valid.is_valid(tomllib.loads(f"{ROD}[engine]\n{form}\nbore_mm = 76\npiston_mass_kg = 1"))


def test_only_a_value_with_a_unit_loads_pint():
    code = (
        "import sys; from fea.study.study import load_study; from fea.study.flags import Flags\n"
        "asked = Flags(size=8.0).applied(load_study()); print('pint' in sys.modules)\n"
        "Flags(size='0.3 in').applied(load_study()); print('pint' in sys.modules)"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.split() == ["False", "True"]
    assert math.isclose(Flags(size="0.3 in").applied(load_study()).mesh.size_mm, 7.62)
