"""The builder's sheet: its rows, what fills those that are empty, and what it works out again."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from program import fea
from reports import reported_rod

from fea.base.choices import Fatigue, Finish
from fea.base.note import assumption, doubt, warning
from fea.judge.fatigue import FatigueField, goodman
from fea.output.folder import SUMMARY, PictureError, is_earlier_run
from fea.output.report.advice import Advice
from fea.output.report.assumptions import in_words, note_groups
from fea.output.report.found_limits import found_limits
from fea.output.report.page import sheet_page, write_pdf
from fea.output.report.sheet import by_proportions, sheet_rows
from fea.output.stored_run import read_run
from fea.study.flags import Flags
from fea.study.plausibility import assumed_dimensions
from fea.study.study import load_study
from geometry.presets import PRESETS
from geometry.rod import proportioned


@pytest.fixture(scope="module")
def run():
    return reported_rod()[1]


def test_every_row_says_something_and_links_where_more_stands(run):
    rows = {row.title: row for row in sheet_rows(run, None)}
    assert list(rows) == [
        "Highest speed", "Highest boost", "What fails first", "Bolts", "Bearings",
        "Assumptions that change it most", "What would make it pass",
    ]  # fmt: skip
    assert all(row.value for row in rows.values())
    assert rows["Highest speed"].command.startswith("fea limits ")
    assert rows["Bearings"].command.endswith("--film --report")
    page = re.sub(r"<style.*?</style>", "", sheet_page(replace(run, summary=replace(run.summary, study="x"))))
    words = " ".join(re.findall(r">([^<>]+)<", page))
    assert not re.findall(r"\b[a-z]+_[a-zA-Z_]+\b", words), "raw keys"
    assert "href=" not in page.replace('href="data:,"', "")  # the sheet alone has no sections
    assert "<script" not in page


def test_the_headline_names_assumed_proportions(run):
    assert by_proportions(run) == "big end ring, big end width, big end fillet"
    measured = {"big_end_ring_mm": 8.9, "big_end_width_mm": 29.3}
    other = replace(run, study=run.study.with_rod(**measured))
    assert by_proportions(other) == ""
    assert "By assumed proportions: the rod does not survive" in sheet_page(run)


def test_dimensions_are_assumed_where_the_program_would_choose_them():
    usual = proportioned(141.0, 50.0, 24.0, shank_width=13.7)
    assumed = assumed_dimensions(usual)
    assert "shank_width" not in assumed
    assert {"big_end_ring", "small_end_ring", "shank_depth_small_end", "web_thickness"} <= assumed
    assert not assumed & {"length", "big_end_bore", "small_end_bore"}
    assert "shank_width" in assumed_dimensions(PRESETS["leon-2001"])


def test_another_strength_gives_the_factor_of_a_further_run():
    # Goodman on paper: 1/n = 100/200 + 50/500 = 0.6; with 0.8 of the limit 1/n = 0.725
    field = FatigueField(
        Fatigue.GOODMAN, np.array([50.0, -10.0]), np.array([100.0, 90.0]), np.array(200.0), 500.0
    )
    assert field.least() == pytest.approx(1 / 0.6)
    assert field.least(0.8) == pytest.approx(1 / 0.725)
    for criterion in Fatigue:
        own = replace(field, criterion=criterion)
        assert own.least(own.needed(1.7)) == pytest.approx(1.7)
    assert replace(field, mean=np.array([600.0, 0.0])).needed(1.0) == np.inf


def test_effects_of_assumptions_are_those_of_the_fields(run):
    advice, envelope = Advice(run), run.summary.envelope
    assert advice.field.least() == pytest.approx(envelope.min_fatigue_safety_factor, rel=1e-5)
    material, rest = advice.material, envelope.endurance["rod"].regions["rest"].endurance_MPa
    limit = run.envelope["endurance_limit"]
    # All of it again with the endurance limit of the other finish, by its definition.
    forged = 272.0 * material.ultimate_strength**-0.995 * material.endurance_limit  # Shigley, table 6-2
    other = np.where(np.isclose(limit, rest), forged, limit)
    factors = goodman(run.envelope["mean"], run.envelope["amplitude"], other, material.ultimate_strength)
    assert advice.with_finish("shot-peened", Finish.AS_FORGED) == pytest.approx(factors.min(), rel=1e-5)
    effects = advice.effects()
    assert len(effects) == 3
    assert all(re.search(r": \d\.\d\d → \d\.\d\d$", effect) for effect in effects)
    needed = re.search(r"endurance limit of (\d+) MPa there \(now (\d+) MPa\)", " ".join(advice.remedies()))
    bar = envelope.min_fatigue_safety_factor / envelope.min_fatigue_safety_factor.low
    assert advice.field.least(float(needed[1]) / float(needed[2])) == pytest.approx(bar, rel=0.02)


def test_bolts_are_no_matter_of_the_rods_strength(run):
    failing = replace(run.summary.survival, mode="yielding of the bolts")
    other = replace(run, summary=replace(run.summary, survival=failing))
    assert Advice(other).remedies() == [
        "Not worked out: what decides is grade, thread and preload of the bolts"
    ]
    assert by_proportions(other) == ""


def test_a_command_names_the_study_with_what_flags_changed(run, tmp_path, monkeypatch):
    """By its own file where that answers for the run, else by the one in the folder of the run."""
    monkeypatch.chdir(tmp_path)
    own = replace(run, summary=replace(run.summary, study="mine"))
    Path("mine.toml").write_text(run.study.text(), encoding="utf-8")
    part = Path("results", ".mine-6000rpm.0123abcd.part")  # while it is written

    def said(other):
        rows = {row.title: row for row in sheet_rows(replace(own, study=other), part)}
        return rows["Highest speed"].command

    assert said(run.study) == "fea limits mine.toml, then fea report"
    there = "fea limits results/mine-6000rpm/study.toml --out results/mine-limits, then fea report"
    assert said(Flags(material="4340-aircraft").applied(run.study)) == there
    assert said(Flags(min_safety=1.2).applied(run.study)) == there
    Path("mine.toml").write_text(run.study.with_(speed=[1000, 2000]).text(), encoding="utf-8")
    assert said(run.study) == there
    Path("mine.toml").unlink()
    assert said(run.study) == there


def test_limits_beside_the_run_are_found_if_they_are_of_its_rod(run, tmp_path):
    folder, beside = tmp_path / "run", tmp_path / "x-limits"
    beside.mkdir()
    point = {"bar": 60.0, "mode": "fatigue", "place": "small end", "rpm": 6790.0, "boost_bar": 0.0}
    figures = {
        "schema": "fea/limits/1", "largest_rpm": point | {"value": 6788.0},
        "largest_peak_pressure_bar": point | {"value": 92.0, "rpm": 6000.0, "boost_bar": 0.61},
    }  # fmt: skip
    (beside / SUMMARY).write_text(json.dumps(figures))
    (beside / "study.toml").write_text(run.study.text(), encoding="utf-8")
    rows = {row.title: row for row in sheet_rows(run, folder)}
    assert rows["Highest speed"].value == "6790 ± 60 rpm"
    assert rows["Highest speed"].more == ("There the small end fails by fatigue",)
    assert rows["Highest boost"].value == "0.61 bar of boost"
    assert "92 bar peak at 6000 rpm" in rows["Highest boost"].more[0]
    assert found_limits(folder, run.study.with_rod(shank_width_mm=12.0)) == {}


def test_notes_are_grouped_by_consequence_and_in_words():
    notes = [
        doubt("the mesh is coarse"),
        warning("bolts: embedding is not deducted (assembly.bolt_embedding_um)"),
        assumption("assumed friction 0.12 in the thread (assembly.thread_friction)", "bolts"),
        assumption("assumed half the ultimate strength as endurance limit", "fatigue"),
        assumption("assumed piston_mass_kg = 0.38 (0.6 g/cm³ × bore³)", "engine toyota-2jz"),
    ]
    assert in_words(notes[2]) == "friction 0.12 in the thread"
    assert in_words(notes[4]) == "piston mass 0.38 kg (0.6 g/cm³ × bore³)"
    assert in_words(notes[1]) == "bolts: embedding is not deducted"
    groups = note_groups(notes, "fatigue")
    assert [len(group.lines) for group in groups] == [2, 2, 1]
    assert groups[1].lines[0] == ("fatigue strength", "half the ultimate strength as endurance limit")
    assert note_groups(notes, "yielding of the bolts")[1].lines[0][0] == "bolts"


def test_a_stored_run_has_the_notes_of_the_run(run, tmp_path):
    written = run.write(tmp_path / "run")
    again = read_run(written)
    assert again.summary.notes == run.summary.notes
    assert sheet_rows(again, None) == sheet_rows(run, None)
    (written / "sheet.html").write_text(sheet_page(again), encoding="utf-8")
    assert is_earlier_run(written)


def test_without_a_chromium_it_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setattr("shutil.which", lambda _name: None)
    with pytest.raises(PictureError, match=r"Open .*sheet\.html in any browser and print it into a file"):
        write_pdf(tmp_path / "sheet.html", tmp_path / "sheet.pdf")
    assert not (tmp_path / "sheet.pdf").exists()


def test_given_forces_have_a_sheet_without_an_engine(run):
    study = replace(load_study("leon-2001"), engine=None)
    rows = sheet_rows(replace(run, study=study, summary=replace(run.summary, engine=None)), None)
    assert {"Highest speed", "Highest boost", "Bearings"}.isdisjoint({row.title for row in rows})


@pytest.mark.slow
def test_fea_report_writes_the_sheet_alone(run, tmp_path):
    written = run.write(tmp_path / "run")
    done = fea("report", str(written), "--sheet", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, f"Wrote {Path('run', 'sheet.html')}\n")
    page = (written / "sheet.html").read_text(encoding="utf-8")
    assert "By assumed proportions: the rod does not survive" in page
    assert all(f"<dt>{row.title}</dt>" in page for row in sheet_rows(read_run(written), written))
    assert not (written / "report.html").exists()
