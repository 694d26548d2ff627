"""Values in a wrong unit are refused or noted; those of engines that exist are not refused."""

from dataclasses import replace
from pathlib import Path

import pytest
from wrong_units import drawn, said_of

from fea.base.note import UNITS, NoteKind
from fea.study.documents import template
from fea.study.flags import Flags
from fea.study.material_table import LIBRARY, MaterialTable
from fea.study.plausibility import RANGES
from fea.study.study import TABLES, Study, load_study, parse_study, shipped_studies
from fea.study.tables import keys_of
from geometry.errors import InvalidValue
from geometry.imports import RodFile

LEON = """[rod]
preset = "leon-2001"
{rod}
[material]
{material}
[engine]
stroke_mm = {stroke}
bore_mm = 76.0
piston_mass_kg = {piston}
gas = "leon-2001"
[speed]
rpm = {rpm}
"""
USUAL = {"rod": "", "material": 'preset = "leon-2001"', "stroke": 94.0, "piston": 0.55, "rpm": 6000}
GIVEN = "E_GPa = {}\nnu = 0.3\ndensity_kg_m3 = {}\nyield_MPa = {}"


def study(**changes) -> Study:
    return parse_study(LEON.format(**(USUAL | changes)), "study", Path.cwd())


def test_1_in_20_of_wrong_units_passes_at_most_and_no_right_study_is_refused():
    pairs = [(said_of(right), wrong, said_of(wrong.tables)) for right, wrong in drawn(80, seed=7)]
    for right, _, _ in pairs:
        assert not isinstance(right, InvalidValue)
        assert not any(finding.refused for finding in right)
    passed = [(wrong.key, wrong.unit) for right, wrong, said in pairs if said == right]
    assert len(passed) <= 0.05 * len(pairs), passed


def test_nothing_is_said_of_what_comes_with_the_program():
    ours = [load_study(name) for name in shipped_studies()]
    whole = (name for name, known in LIBRARY.items() if "yield_MPa" in known.figures)
    ours += [replace(ours[0], material=MaterialTable(preset=name)) for name in whole]
    ours.append(parse_study(template(), "template", Path.cwd()))
    assert [(each.name, found.text) for each in ours for found in each.unusual()] == []


@pytest.mark.parametrize(
    ("changes", "key", "unit"),
    [
        ({"stroke": 3.7}, "engine.stroke_mm", "inches (3.7 inches = 93.98 mm)"),
        ({"stroke": 9.4}, "engine.stroke_mm", "cm (9.4 cm = 94 mm)"),
        ({"piston": 550}, "engine.piston_mass_kg", "g (550 g = 0.55 kg)"),
        ({"rod": "length_mm = 0.141"}, "rod.length_mm", "m (0.141 m = 141 mm)"),
        ({"material": GIVEN.format(207000, 7.85, 600)}, "material.E_GPa", "MPa (207000 MPa = 207 GPa)"),
        (
            {"material": GIVEN.format(207, 7.85, 600)},
            "material.density_kg_m3",
            "g/cm³ (7.85 g/cm³ = 7850 kg/m³)",
        ),
        ({"material": GIVEN.format(207, 7850, 90000)}, "material.yield_MPa", "psi (90000 psi = 620.5 MPa)"),
    ],
)
def test_a_value_far_outside_is_refused_and_its_unit_named(changes, key, unit):
    with pytest.raises(InvalidValue) as refused:
        Flags().applied(study(**changes))
    assert str(refused.value).startswith(f"{key} = ") or "length" in key
    assert f"seems to be in {unit}" in str(refused.value)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"rpm": 628}, "speed.rpm = 628: seems to be in rad/s (628 rad/s = 5997 rpm)"),
        ({"rpm": [6000, 5]}, "speed.rpm = 5: "),
        ({"rod": "web_thickness_mm = 0.5"}, "rod.web_thickness_mm = 0.5: seems to be in cm (0.5 cm = 5 mm)"),
        ({"material": GIVEN.format(207, 7850, 90)}, "material.yield_MPa = 90: seems to be in ksi"),
        ({"piston": 2}, "engine.piston_mass_kg = 2: seems to be in lb"),
    ],
)
def test_a_value_near_the_edge_is_noted(changes, said):
    (note,) = Flags().applied(study(**changes)).unusual_notes()
    assert note.text.startswith(said)
    assert (note.kind, note.topic) == (NoteKind.DOUBT, UNITS)


def test_the_key_or_the_flag_insists():
    odd = study(stroke=3.7)
    assert Flags(unusual=True).applied(odd).unusual()[0].refused
    insisted = parse_study(odd.text().replace("unusual = false", "unusual = true"), "study", Path.cwd())
    assert Flags().applied(insisted).unusual_notes()


def test_the_unit_of_a_file_scales_all_of_its_lengths():
    of_file = replace(study(), rod=replace(study().rod, file=RodFile(Path("rod.step")), dimensions=None))
    inches = {
        "rod.length_mm": 141 * 25.4,
        "rod.big_end_bore_mm": 50 * 25.4,
        "rod.small_end_bore_mm": 24 * 25.4,
    }
    found = of_file.unusual(inches)
    assert (found[0].key, found[0].refused) == ("rod.length_mm", True)
    assert "--unit): 0.03937 times as long, 141 mm, it would fit" in found[0].text


def test_every_range_is_that_of_a_key_and_a_multiple_of_keys():
    keys = {table: set(keys_of(cls)) for table, cls in TABLES.items()}
    for table, rows in RANGES.items():
        for key, ranges in rows.items():
            assert key in keys[table]
            for given in ranges:
                assert 0 < given.least < given.most
                assert given.far > 1
                for other in (*given.of, *given.below):
                    of_table, _, name = other.rpartition(".")
                    assert name in keys[of_table or table]
