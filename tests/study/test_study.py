import math
import os
import tomllib
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from studies import LEON

from fea.analysis.pipeline import prepare
from fea.base.choices import Element, Support
from fea.study.documents import template
from fea.study.flags import Flags, python_flags
from fea.study.speed_tables import parse_speeds
from fea.study.study import load_study, parse_study, shipped_studies
from geometry.errors import InvalidValue


def parsed(text, tmp_path):
    return parse_study(text, "test", tmp_path)


@pytest.mark.parametrize("name", shipped_studies())
def test_shipped_studies_load_and_their_text_gives_the_same_study(name, tmp_path):
    study = load_study(name)
    again = parsed(study.text(), tmp_path)
    assert again.text() == study.text()
    assert again.rod.dimensions == study.rod.dimensions
    assert again.material.material() == study.material.material()
    assert again.engine == study.engine


def test_flags_win_over_the_file(tmp_path):
    flags = Flags(rpm="3000", size=2.5, element=Element.P1, support=Support.CLAMPED, screenshot=True)
    study = flags.applied(parsed(LEON + "[speed]\nrpm = 800\n[mesh]\nsize_mm = 9.0\n", tmp_path))
    assert study.speed.speeds() == (3000,)
    assert study.mesh.size_mm == 2.5
    assert study.mesh.element is Element.P1
    assert study.analysis.support is Support.CLAMPED
    assert study.output.screenshot


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[rod]\npreset = 'leon-2001'\n[enginee]\n", r"enginee.*unknown key.*Did you mean engine\?"),
        (LEON + "bor_mm = 3.0", r"bor_mm.*unknown key.*bore_mm"),
        (LEON.replace("94.0", "'94'"), r"engine\.stroke_mm = '94': must be a number"),
        (LEON.replace("94.0", "true"), r"engine\.stroke_mm.*must be a number"),
        (LEON.replace("94.0", "nan"), r"engine\.stroke_mm = nan"),
        (LEON.replace("94.0", "-94.0"), r"engine\.stroke_mm = -94: must be positive"),
        (LEON.replace("94.0", "300.0"), r"rod\.length_mm = 141: must exceed 150 mm, the crank radius"),
        (
            LEON.replace('"leon-2001"\n[engine]', '"leon2001"\n[engine]'),
            r"rod\.preset.*Did you mean leon-2001",
        ),
        (LEON.replace("gas = ", "gas = 'steam' # "), r"engine\.gas = 'steam': is not a gas model"),
        (LEON + "[analysis]\nsupport = 'glued'", r"analysis\.support.*not a valid choice.*clamped"),
        (LEON + "[analysis]\npressure = 'cosine-400'", r"analysis\.pressure"),
        (LEON + "[mesh]\nsize_mm = 0.0", r"mesh\.size_mm = 0: must be positive"),
        (LEON + "[speed]\nrpm = -3", r"speed\.rpm = -3: must lie between 0 and 50000"),
        (LEON + "[speed]\nrpm = 1e6", r"speed\.rpm = 1e\+06"),
        (LEON + "[speed]\nrpm = []", r"speed\.rpm = \[\]: must contain at least one speed"),
        (
            LEON + "[material]\npreset = 'leon-2001'\nnu = 0.5",
            r"material\.nu = 0\.5: must be above −1 and below 0\.5",
        ),
        (LEON + "[material]\nE_GPa = 210.0", r"material\.nu is missing"),
        (LEON + "[forces]\npin_N = [1.0, 0.0]", r"forces\.pin_N.*cannot be combined with \[engine\]"),
        ("[rod]\npreset = 'leon-2001'\n[forces]\npin_N = [1.0]", r"must be \[axial, transverse\]"),
        ("[rod]\nlength_mm = 141.0", r"rod\.big_end_bore_mm is missing"),
        ("[rod]\nlength_mm = 1.0\nbig_end_bore_mm = 5.0\nsmall_end_bore_mm = 2.0", r"rod\.length_mm = 1"),
        (
            "[rod]\nmass_kg = 1.0\nlength_mm = 100.0",
            r"rod\.center_of_gravity_mm is missing, but mass_kg is given",
        ),
        ("rod = 3", r"rod = 3: must be a table"),
        ("[speed]\nrpm = 1", r"has no \[rod\] table"),
        ("[rod", r"is not valid TOML"),
        (LEON.replace("94.0", "94,0"), r"not valid TOML.*Write 94\.0"),
        (LEON.replace("stroke_mm = 94.0", "stroke_in = 3.7"), r"Give stroke_mm, which is 25.4 times"),
        (LEON + "[material]\nE_ksi = 30000", r"Give E_GPa, which is 0.00689476 times the value in ksi"),
        ("[rod]\nstep = 'rod.SLDPRT'", r"Export STEP from SolidWorks"),
    ],
)
def test_bad_studies_are_refused_by_name(text, says, tmp_path):
    with pytest.raises(InvalidValue, match=says):
        study = parsed(text, tmp_path)
        study.engine.engine(study.rod.length)


def test_a_transverse_force_needs_a_clamp_whether_from_the_study_or_the_flags(tmp_path):
    study = parsed("[rod]\npreset = 'leon-2001'\n[forces]\npin_N = [1.0, 2.0]", tmp_path)
    with pytest.raises(InvalidValue, match=r"transverse component.*clamped"):
        study.require_loading()
    with pytest.raises(InvalidValue, match=r"transverse component.*clamped"):
        prepare(study)
    Flags(support=Support.CLAMPED).applied(study).require_loading()


def test_an_unknown_study_lists_the_shipped_ones():
    with pytest.raises(InvalidValue, match=r"neither a shipped study nor an existing file.*leon-2001"):
        load_study("lion-2001")


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("rod.ipt", "Export STEP from Inventor"),
        ("rod.f3d", "Export STEP from Fusion"),
        ("rod.prt", "Export STEP from NX or Creo"),
        ("rod.3mf", "Save it as STL"),
        ("rods.step", r"is not an existing file\. Did you mean rod\.step\?$"),
        ("rod.stl", r"is not an existing file\. Check its name"),
        ("gone/rod.step", r"There is no folder .*gone\.$"),
    ],
)
def test_a_file_that_cannot_be_read_is_answered_with_what_to_do(name, says, tmp_path):
    (tmp_path / "rod.step").touch()
    with pytest.raises(InvalidValue, match=says):
        load_study(tmp_path / name)


def test_flags_say_how_the_file_of_a_rod_is_read(tmp_path):
    for name in ("rod.step", "rod.stl", "cap.stl"):
        (tmp_path / name).touch()
    study = load_study(tmp_path / "rod.step")
    keys = {"unit": "in", "solids": ["Rod", "Cap"], "cap": "assumed", "swap_ends": True}
    read = python_flags({**keys, "big_end_bore": 50.0}).applied(study).rod.cad
    assert (read.unit, read.solids, read.cap, read.big_end_bore) == ("in", ("Rod", "Cap"), "assumed", 50.0)
    assert read.swap_ends
    again = python_flags({"small_end_bore": 20.0}).applied(replace(study, rod=replace(study.rod, file=read)))
    assert again.rod.cad == replace(read, small_end_bore=20.0)
    assert parsed(again.text(), tmp_path).rod == again.rod
    mesh = python_flags({"cap": tmp_path / "cap.stl"}).applied(load_study(tmp_path / "rod.stl")).rod.mesh
    assert mesh.cap == tmp_path / "cap.stl"
    with pytest.raises(InvalidValue, match="--unit = 'in': says how a CAD file or a mesh is read"):
        python_flags({"unit": "in"}).applied(load_study())


def test_relative_paths_start_at_the_study(tmp_path):
    study = parsed(LEON.replace("gas = ", "gas = 'mine.csv' # "), tmp_path)
    assert study.engine.gas == str((tmp_path / "mine.csv").resolve())


@pytest.mark.parametrize(
    ("text", "speeds"),
    [
        ("6000", (6000,)),
        ("800,3000,6000", (800, 3000, 6000)),
        ("800:1400:200", (800, 1000, 1200, 1400)),
        ("800:1500:200", (800, 1000, 1200, 1400, 1500)),
        ("1000,900:1000:50", (1000, 900, 950)),
    ],
)
def test_speeds_are_read_as_written(text, speeds):
    assert parse_speeds(text) == speeds


@pytest.mark.parametrize("text", ["fast", "", "1:2", "5:1:1", "1:9:0", "1:9:-1", "nan", "inf", "0:1e9:1"])
def test_other_speeds_are_refused(text):
    with pytest.raises(InvalidValue, match="--rpm"):
        parse_speeds(text)


@given(st.floats(0, 5000), st.floats(0, 5000), st.floats(10, 1000))
def test_a_range_holds_both_ends_and_rises(start, span, step):
    speeds = parse_speeds(f"{start!r}:{start + span!r}:{step!r}")
    assert speeds[0] == start
    assert math.isclose(speeds[-1], start + span)
    assert all(b > a for a, b in pairwise(speeds))


def test_python_flags_take_python_values():
    study = python_flags({"rpm": [800, 3000], "element": "p1"}).applied(load_study())
    assert study.speed.rpm == (800.0, 3000.0)
    assert study.mesh.element is Element.P1
    with pytest.raises(InvalidValue, match="Did you mean size"):
        python_flags({"sise": 3.0})


def test_the_template_is_a_study(tmp_path):
    text = template()
    assert parsed(text, tmp_path).engine.gas == "otto"
    assert set(tomllib.loads(text)) == {
        "rod", "material", "engine", "speed", "mesh", "analysis", "contact", "output",
    }  # fmt: skip


@pytest.mark.parametrize("value", ["1e308", "-1e308", "1e-308", "2e12"])
@pytest.mark.parametrize("key", ["engine.bore_mm", "mesh.size_mm", "analysis.tolerance_percent"])
def test_sizes_beyond_any_engine_are_refused(key, value, tmp_path):
    table, name = key.split(".")
    text = LEON.replace("bore_mm = 76.0\n", "" if name == "bore_mm" else "bore_mm = 76.0\n")
    text += f"{name} = {value}\n" if table == "engine" else f"[{table}]\n{name} = {value}\n"
    with pytest.raises(InvalidValue, match=rf"{key} = .*magnitude must be 0 or between 1e-12 and 1e\+12"):
        parsed(text, tmp_path)


@pytest.mark.parametrize("flag", ["size", "tolerance", "min_safety"])
def test_flags_of_such_sizes_are_refused_too(flag, tmp_path):
    with pytest.raises(InvalidValue, match="magnitude must be 0 or between"):
        Flags(**{flag: 1e-308}).applied(parsed(LEON, tmp_path))


def test_a_center_of_gravity_beyond_the_bores_is_refused(tmp_path):
    mass = "mass_kg = 0.785\ncenter_of_gravity_mm = {}\ninertia_kg_m2 = 3.9e-3\n"
    assert parsed(LEON.replace("[engine]", mass.format(64) + "[engine]"), tmp_path).rod.mass
    for place in (-6000, 0, 141, 6000):
        with pytest.raises(InvalidValue, match=r"center_of_gravity_mm = .*must lie between .* 0 to 141 mm"):
            parsed(LEON.replace("[engine]", mass.format(place) + "[engine]"), tmp_path)


def test_given_masses_that_the_solid_has_not_are_told(tmp_path):
    mass = "mass_kg = 0.785\ncenter_of_gravity_mm = 64\ninertia_kg_m2 = 3.9e-3\n"
    rod = parsed(LEON.replace("[engine]", mass + "[engine]"), tmp_path).rod
    assert rod.mass_notes(rod.mass) == []
    (note,) = rod.mass_notes(rod.mass.times(0.5))
    assert "mass_kg = 0.785 (solid: 0.3925)" in str(note)
    assert "inertia" in str(note)
    assert "gravity" not in str(note)
    assert parsed(LEON, tmp_path).rod.mass_notes(rod.mass) == []


@pytest.mark.skipif(os.name != "posix", reason="names are no bytes elsewhere, and links loop otherwise")
def test_paths_that_no_file_of_a_run_could_name_are_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InvalidValue, match=r"--out .*must be valid UTF-8"):
        Flags(out=Path("\udcff")).applied(parsed(LEON, tmp_path))
    (tmp_path / "\udcff.toml").write_text(LEON)
    with pytest.raises(InvalidValue, match=r"STUDY .*must be valid UTF-8"):
        load_study("\udcff.toml")
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(InvalidValue, match=r"--out .*is not a valid path"):
        Flags(out=Path("a")).applied(parsed(LEON, tmp_path))


def test_a_solid_from_a_file_has_no_dimensions_to_fit(tmp_path):
    (tmp_path / "rod.step").write_text("ISO-10303-21;")
    study = parsed('[rod]\nstep = "rod.step"\n[forces]\npin_N = [1.0, 0.0]', tmp_path)
    with pytest.raises(InvalidValue, match=r"rod\.step.* is an imported solid"):
        study.rod.solid()


def test_a_windows_path_between_double_quotes_gets_the_remedy():
    with pytest.raises(InvalidValue) as caught:
        parse_study('[rod]\nstep = "C:\\Users\\me\\rod.step"\n', "mine", Path())
    assert "'C:\\Users\\me\\rod.step', or with slashes: \"C:/Users/me/rod.step\"" in str(caught.value)
