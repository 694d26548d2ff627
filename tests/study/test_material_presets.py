from dataclasses import replace

import pytest

from fea.study.material_table import LIBRARY, MaterialTable, library_material
from fea.study.study import load_study, parse_study
from fea.study.tables import keys_of
from geometry.errors import InvalidValue


def test_every_figure_has_a_source():
    for name, material in LIBRARY.items():
        assert material.title, name
        assert material.figures.keys() <= keys_of(MaterialTable).keys(), name
        assert material.figures.keys() <= material.sources.keys(), name
        assert all(map(str.strip, material.sources.values())), name


@pytest.mark.parametrize("name", sorted(LIBRARY))
def test_every_preset_is_a_material_with_strengths_in_order(name):
    material = MaterialTable(preset=name).material()
    strengths = (material.endurance_limit, material.yield_strength, material.ultimate_strength)
    known = [strength for strength in strengths if strength is not None]
    assert known == sorted(known)
    if material.torsion_limit is not None:
        # Nishihara & Kawamoto's hard steel: 0.625 (Tveit et al. 2026, Procedia Structural Integrity 82, 112).
        assert material.torsion_limit / material.endurance_limit == pytest.approx(0.625, rel=1e-3)
    if (
        material.basquin is not None
    ):  # at 10⁶ cycles the S–N line meets the limit, to the digits that are given
        assert material.basquin.amplitude(1e6) == pytest.approx(material.endurance_limit, rel=2e-3)


@pytest.mark.parametrize("name", sorted(LIBRARY))
def test_the_written_study_has_every_figure_of_a_preset(name, tmp_path):
    """Without its S–N line, the hours of a run again with --cycle were those of an assumed line."""
    study = replace(load_study("leon-2001"), material=MaterialTable(preset=name))
    again = parse_study(study.text(), "again", tmp_path)
    assert again.material.material() == study.material.material()


@pytest.mark.parametrize(
    ("name", "preset"),
    [
        ("4340", "4340-hrc-36"),
        ("4340 HRC 40", "4340-hrc-40"),
        ("en24", "EN24-T"),
        ("EN24W", "EN24-W"),
        ("817M40", "EN24-T"),
        ("1.6582", "34CrNiMo6-40mm"),
        ("42crmo4", "42CrMo4-40mm"),
        ("C70 S6", "c70-2005"),
        ("300m", "300M"),
        ("Ti-6Al-4V", "ti-6al-4v"),
        ("7075-T6", "al-7075-t6"),
        ("bolt-arp2000", "bolt-ARP 2000"),
    ],
)
def test_common_names_are_understood(name, preset):
    assert library_material("material.preset", name).name == preset
    assert MaterialTable(preset=name).resolved() == MaterialTable(**LIBRARY[preset].figures)


def test_no_two_materials_share_a_name():
    names = [name.casefold() for material in LIBRARY.values() for name in (material.name, *material.also)]
    assert {name for name in names if names.count(name) > 1} <= {m.name.casefold() for m in LIBRARY.values()}


def test_4340_is_interpolated_between_published_hardnesses():
    at = {hardness: LIBRARY[f"4340-hrc-{hardness}"].figures["ultimate_MPa"] for hardness in range(30, 45)}
    # 142, 174 and 208 ksi at 30, 38 and 44 HRC; a quarter of the way from 38 to 44 lies at 39.5.
    for hardness, ksi in ((30, 142), (38, 174), (44, 208)):
        assert at[hardness] == pytest.approx(6.894757 * ksi, abs=0.5)
    assert at[41] == pytest.approx((at[38] + at[44]) / 2, abs=0.5)
    assert list(at.values()) == sorted(at.values())


def test_a_wrong_name_suggests_the_nearest_and_a_missing_strength_is_asked_for():
    with pytest.raises(InvalidValue, match=r"'433O'.*not in the library.*4340.*`fea materials` lists"):
        MaterialTable(preset="433O").resolved()
    with pytest.raises(InvalidValue, match=r"material\.yield_MPa is missing"):
        MaterialTable(E_GPa=205.0, nu=0.29, density_kg_m3=7850.0).material()


def test_a_limit_of_ones_own_takes_the_cycles_of_the_preset_with_it():
    assert MaterialTable(preset="7075-T6").material().endurance_cycles == 5e8
    assert MaterialTable(preset="7075-T6", endurance_MPa=150.0).material().endurance_cycles is None
