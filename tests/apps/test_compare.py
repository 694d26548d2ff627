"""`fea compare`: what differs between studies, what the tables say of it, and the page."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from program import fea

from fea.apps.compare.run_compare import ComparedStudy, compare, differences, judged_alike, named_designs
from fea.apps.compare.tables import _change
from fea.apps.result import analyse
from fea.judge.safety_factor import SafetyFactor
from fea.study.speed_tables import SpeedTable
from fea.study.study import load_study
from geometry.errors import InvalidValue

PLAIN = load_study("leon-2001")
SIMPLE = Path(__file__).parents[1] / "support" / "plain.toml"  # is solved sooner
THIN = replace(PLAIN.with_rod(web_thickness_mm=4.0), name="thin", speed=SpeedTable(5000.0))


def test_keys_that_differ_are_told_apart_by_what_they_say():
    found = {one.key: one for one in differences([PLAIN, THIN])}
    assert found.keys() == {"rod.web_thickness_mm", "speed.rpm"}
    assert found["rod.web_thickness_mm"].of_design
    assert found["rod.web_thickness_mm"].values[1] == 4.0
    assert not found["speed.rpm"].of_design
    assert differences([PLAIN, PLAIN]) == []


def test_a_default_that_is_given_is_no_difference_and_friction_is_an_assumption():
    bolted = load_study("leon-2001-bolted")
    said = replace(PLAIN, analysis=replace(PLAIN.analysis, pressure="contact"))
    assert differences([PLAIN, said]) == []
    rough = replace(bolted, assembly=replace(bolted.assembly, joint_friction=0.3))
    assert [one.of_design for one in differences([bolted, rough])] == [False]


def test_judged_alike_leaves_only_the_rods_different():
    alike = [one.study for one in judged_alike([ComparedStudy(PLAIN), ComparedStudy(THIN)])]
    assert [one.key for one in differences(alike)] == ["rod.web_thickness_mm"]
    assert alike[1].speeds() == PLAIN.speeds()


def test_a_change_says_whether_error_bars_hide_it():
    wide, near, far = SafetyFactor(1.0, 0.9, 1.1), SafetyFactor(1.1, 1.0, 1.2), SafetyFactor(1.5, 1.4, 1.6)
    assert _change(wide, near) == "+10 %, within the bars"
    assert _change(wide, far) == "+50 %"
    assert _change(2.0, 1.0) == "−50 %"
    assert _change(2.0, 2.0) == "the same"
    assert _change(None, 1.0) == _change("a", "b") == ""


@pytest.mark.parametrize(
    ("names", "materials", "what"),
    [
        (["leon-2001"], (), "STUDY"),
        (["leon-2001"] * 7, (), "STUDY"),
        (["leon-2001", "molina-2024"], ("EN24", "300M"), "--material"),
        (["leon-2001"], ("EN24",), "--material"),
        (["leon-2001"], ("EN24", "cheese"), "material"),
        (["leon-2001", "nothing"], (), "STUDY"),
    ],
)
def test_what_cannot_be_compared_is_refused(names, materials, what):
    with pytest.raises(InvalidValue, match=what):
        named_designs(names, materials)


def test_limits_of_given_forces_are_refused_before_anything_is_solved():
    still = replace(PLAIN, engine=None)
    with pytest.raises(InvalidValue):
        compare([ComparedStudy(PLAIN), ComparedStudy(still)])


def test_two_studies_make_a_table_a_page_and_json(tmp_path):
    thin = load_study(str(SIMPLE)).with_rod(shank_width_mm=9.0)
    thin = replace(thin, speed=SpeedTable(5000.0))
    (tmp_path / "thin.toml").write_text(thin.text(), encoding="utf-8")
    arguments = ("compare", SIMPLE, "thin.toml", "--size", 14, "--out", "page.html")
    done = fea(*arguments, "--same", "--min-safety", 0.1, "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    first, second = (design["summary"] for design in found["designs"])
    assert found["dimensions"]["rod.shank_width_mm"][1] == 9
    assert found["assumptions"] == {}
    assert second["rpm"] == first["rpm"] == 6000
    assert second["rod"]["mass_kg"] < first["rod"]["mass_kg"]
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert len(page) < 40_000
    assert "src=" not in page.replace("img-src", "")
    assert "http://" not in page
    assert "https://" not in page
    for text in ("plain", "thin", "shank width, mm", "second to first", "All are judged by the same"):
        assert text in page
    assert "shank_width_mm" not in page


def test_one_study_in_two_materials_and_a_required_factor(tmp_path):
    arguments = ("--material", "ti-6al-4v", "EN24", "--size", 14, "--min-safety", 9)
    done = fea("compare", SIMPLE, *arguments, cwd=tmp_path)
    assert done.returncode == 6, done.stderr
    assert (tmp_path / "results" / "compare-plain-ti-6al-4v-plain-EN24.html").is_file()
    for text in ("density, kg/m³", "4430", "Safety factors, with error bars"):
        assert text in done.stdout


def test_runs_that_are_solved_are_compared_as_they_are(tmp_path, monkeypatch):
    for name, width in (("wide", 12.0), ("thin", 9.0)):
        study = replace(load_study(str(SIMPLE)).with_rod(shank_width_mm=width), name=name)
        study = study.with_(mesh={"size_mm": 14}, analysis={"tolerance_percent": 0, "cycle": name == "wide"})
        result = analyse(replace(study, speed=SpeedTable(5000.0)))
        result.write(tmp_path / name)
    fast, place = {"mode": "fatigue", "place": "shank", "at_mm": [1, 2, 3]}, tmp_path / "thin-limits"
    fast |= dict.fromkeys(("rpm", "value", "peak_pressure_bar", "bar", "gas_scale", "boost_bar"), 4650.0)
    fast |= dict.fromkeys(("crank_deg", "safe_from"))
    found = {
        "schema": "fea/limits/1",
        "text": "",
        "required_safety_factor": 1,
        "largest_rpm": fast,
        "largest_peak_pressure_bar": None,
    }
    place.mkdir()
    (place / "summary.json").write_text(json.dumps(found), encoding="utf-8")
    (place / "study.toml").write_bytes((tmp_path / "thin" / "study.toml").read_bytes())
    monkeypatch.setattr("fea.apps.compare.run_compare.refined_rod", None)  # nothing is solved
    runs = named_designs([str(tmp_path / "wide"), str(tmp_path / "thin")])
    wide, thin = compare(runs, limits=True).designs
    assert (wide.name, thin.name, thin.limits.largest_rpm.value) == ("wide", "thin", 4650)
    assert wide.lacks == f"limits (fea limits {tmp_path}/wide/study.toml --out {tmp_path}/wide-limits)"
    assert thin.lacks == (
        f"the crank cycle (fea run {tmp_path}/thin/study.toml --cycle --out {tmp_path}/thin)"
    )
    with pytest.raises(InvalidValue, match=r"solved, with other analysis\.cycle"):
        compare(runs, alike=True)
    done = fea("compare", "wide", "thin", "--rpm", 4000, cwd=tmp_path)
    assert done.returncode == 2
    assert "solved already, without --rpm" in done.stderr
    done = fea("compare", "wide", "thin", "--units", "us", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for text in ("mass, lb", "was solved without", "4650"):
        assert text in done.stdout


def test_the_program_refuses_in_a_line(tmp_path):
    for arguments in (("leon-2001",), ("leon-2001", "molina-2024", "--out", "page.txt")):
        done = fea("compare", *arguments, cwd=tmp_path)
        assert done.returncode == 2
        assert len(done.stderr.splitlines()) <= 2
    assert not list(tmp_path.iterdir())
