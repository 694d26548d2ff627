"""What the sheet solves again: what assumptions change, and the least change with which a rod passes."""

import re
from dataclasses import replace
from math import sqrt

import pytest
from reports import reported_rod
from studies import plain_study

from fea.analysis.pipeline import RefinedRod, prepare
from fea.analysis.result import WhatIf, run_result
from fea.apps.run_study import run_study
from fea.apps.what_if.remedies import (
    VARIED,
    DimensionEffect,
    Draft,
    assumed_changes,
    dimension_remedy,
    exponents,
    least_factors,
)
from fea.apps.what_if.solve import what_if
from fea.base.note import assumption
from fea.judge.safety_factor import SafetyFactor
from fea.machine.clock import Clock
from fea.output.report.advice import Advice
from fea.output.report.sheet import sheet_rows
from fea.study.changes import TABLES
from fea.study.tables import keys_of

pytestmark = pytest.mark.slow


SHANK = "shank_width"


class Stands:
    """In place of a draft: factors are powers of a dimension, a bar with 10 % of the stress among them."""

    def __init__(self, study, **exponents):
        self.study, self.exponents = study, exponents
        self.run = {mode: SafetyFactor(1.0, 0.9, 1.1, mode=mode) for mode in exponents}

    def factors(self, study):
        of = study.rod.dimensions.shank_width / self.study.rod.dimensions.shank_width
        return {
            mode: SafetyFactor(of**power, 0.9 * of**power, 1.1 * of**power, mode=mode)
            for mode, power in self.exponents.items()
        }


@pytest.fixture(scope="module")
def run():
    return reported_rod()[1]


def test_a_dimension_is_the_nearest_one_that_suffices():
    # 0.9 (x/10)² = 1.01 at 10.59, 0.95 x/10 = 1.01 at 10.63: both hold from there, rounded up.
    run = {"yielding": SafetyFactor(1.0, 0.9), "fatigue": SafetyFactor(1.0, 0.95)}
    one = DimensionEffect(SHANK, 10.0, 6.0, 14.0, {"yielding": 2.0, "fatigue": 1.0})
    assert one.wanted(run, 1.0)[0] == pytest.approx(10.7)
    thinner = one._replace(exponents={"yielding": -2.0, "fatigue": -1.0})
    assert thinner.wanted(run, 1.0)[0] == pytest.approx(9.4)  # 10 × 0.95/1.01 = 9.406
    # Fatigue does not depend on it, and decides as soon as yielding does not.
    stuck = one._replace(exponents={"yielding": 2.0, "fatigue": 0.0})
    assert stuck.wanted(run, 1.0)[1] == pytest.approx(0.95)
    found = {"yielding": SafetyFactor(1.2**3), "fatigue": SafetyFactor(1.2)}
    assert exponents(run, found, 1.2) == pytest.approx({"yielding": 3.0, "fatigue": 1.0})


def test_where_no_dimension_suffices_the_best_is_named(run, monkeypatch):
    draft = Stands(run.study, fatigue=0.2)
    monkeypatch.setattr("fea.apps.what_if.remedies.dimensions_at", lambda _rod, _place: (SHANK,))
    text, passes = dimension_remedy(draft, run.summary, "shank")
    assert not passes
    now = run.study.rod.dimensions.shank_width
    assert f"shank width {1.4 * now:.1f} mm (now {now:.1f} mm)" in text
    assert f"about {1.4**0.2:.2f} against fatigue" in text


def test_what_suffices_is_solved_by_a_whole_run(run, monkeypatch):
    solved = []
    monkeypatch.setattr("fea.apps.what_if.remedies.dimensions_at", lambda _rod, _place: (SHANK,))

    def checked(what, study, _rpm):
        solved.append((what, study))
        return what, True

    monkeypatch.setattr("fea.apps.what_if.remedies._checked", checked)
    assert dimension_remedy(Stands(run.study, fatigue=2.0), run.summary, "shank")[1]
    ((_, study),) = solved
    ratio = study.rod.dimensions.shank_width / run.study.rod.dimensions.shank_width
    assert ratio == pytest.approx(sqrt(1.01 / 0.9), rel=0.01)


def test_twice_the_force_halves_the_factor():
    study = plain_study().with_(engine=None, speed=None, forces={"pin_N": [20000.0, 0.0]})
    study = study.with_(analysis={"pressure": "cosine-180", "tolerance_percent": 0}, mesh={"size_mm": 14})
    adapted = RefinedRod(prepare(study))
    summary = run_result(study, adapted, adapted.at(None)).summary
    draft = Draft(study, summary, alone=False)
    twice = draft.factors(study.with_(forces={"pin_N": [40000.0, 0.0]}))
    assert twice["yielding"] == pytest.approx(summary.min_safety_factor / 2, rel=1e-6)  # all is linear
    assert draft.factors(study)["yielding"] == pytest.approx(summary.min_safety_factor, rel=1e-9)


def test_assumptions_are_found_by_their_keys_and_solved_one_by_one(run):
    for key in VARIED:
        table, _, name = key.rpartition(".")
        assert name in keys_of(TABLES[table or "engine"])
    notes = (
        "assumed piston_mass_kg = 0.38 (0.6 g/cm³ × bore³)",
        "assumed friction 0.15 between the parts (assembly.joint_friction)",
        "assumed small-end clearance 0.0144 mm (contact.small_end_clearance_mm)",
        "peak_pressure_bar = 164, computed for petrol: from late to early combustion it is 74 to 164 bar",
    )
    summary = replace(run.summary, notes=tuple(assumption(text) for text in notes))
    varied = {}

    def factors(study):
        varied["mass"] = study.engine.piston_mass_kg
        varied.setdefault("peak", study.engine.peak_pressure_bar)
        varied["clearance"] = study.contact.small_end_clearance_mm
        return {"yielding": SafetyFactor(0.8)}

    draft = Stands(run.study, yielding=1.0)
    draft.factors, draft.alone = factors, True  # without bolts, so without their friction
    changes = list(assumed_changes(draft, summary, ""))
    assert [change.text.partition(",")[0] for change in changes] == [
        "peak pressure 164 bar", "piston mass", "clearance of the small end",
    ]  # fmt: skip
    assert {(change.now, change.then) for change in changes} == {(1.0, 0.8)}
    assert varied["peak"] == 74
    assert varied["clearance"] == pytest.approx(0.0288)


def test_a_heavier_piston_takes_what_its_inertia_adds(run):
    mass = run.study.engine.piston_mass_kg
    draft = Draft(run.study, run.summary, alone=False)
    heavier = draft.factors(run.study.with_(engine={"piston_mass_kg": 1.1 * mass}))
    now = least_factors(run.summary)
    # Inertia of the piston is most of the force in tension, by which the rod fails.
    assert 0.91 < heavier["fatigue"] / now["fatigue"] < 0.97


def test_the_sheet_says_what_was_solved(run):
    lenient = replace(run.summary.survival, required_safety_factor=0.5, answer="undecided")
    asked = replace(run, study=run.study.with_(analysis={"min_safety": 0.5}))
    asked = replace(asked, summary=replace(run.summary, survival=lenient))
    solved = replace(asked, what_if=what_if(asked, Clock()))
    assert solved.what_if.assumed[0].text.startswith("dimensions there")
    remedies = Advice(solved).remedies()
    assert re.match(
        r"Big end \w+ [\d.]+ mm \(now [\d.]+ mm\): it meets the required .*, solved again$", remedies[0]
    )
    sheet = {row.title: row for row in sheet_rows(solved, None)}
    assert sheet["What would make it pass"].value == remedies[0]


def test_of_several_speeds_the_governing_one_is_solved_and_the_others_say_so(tmp_path, monkeypatch):
    solved = []

    def stub(run, _clock):
        solved.append(run.rpm)
        return WhatIf(remedies=("Another rod.",))

    monkeypatch.setattr("fea.apps.what_if.solve.what_if", stub)
    study = plain_study().with_(analysis={"tolerance_percent": 0}, mesh={"size_mm": 14})
    study = study.with_(output={"report": True, "screenshot": False}, speed={"rpm": [6000.0, 3000.0]})
    run_study(replace(study, output=replace(study.output, directory=str(tmp_path / "runs"))))
    fast, slow = (
        (tmp_path / "runs" / f"{rpm}rpm" / "report.html").read_text("utf-8") for rpm in (6000, 3000)
    )
    assert solved == [6000.0]  # at which inertia is four times as large
    assert "Another rod." in fast
    assert "governing speed only" not in fast
    assert "governing speed only" in slow


def test_the_sheet_says_why_nothing_was_solved(run):
    film = replace(run.summary, model=replace(run.summary.model, pressure="oil-film"))
    left = replace(run, summary=film, what_if=what_if(replace(run, summary=film), Clock()))
    assert any("on oil films" in line for row in sheet_rows(left, None) for line in row.more)
