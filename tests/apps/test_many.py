"""Many studies at once: in order, one error beside the results of the others, and the table of all."""

import pickle
import sys
from contextlib import contextmanager
from types import SimpleNamespace

import pytest
from studies import plain_study

import fea
from fea.apps.many import analyse_many
from fea.machine import clock

QUICK = {"rpm": 6000, "size": 20, "pressure": "cosine-180"}


@pytest.fixture(scope="module")
def results():
    plain = plain_study()
    grams = plain.with_(engine={"piston_mass_kg": 500})
    webs = [plain.with_(rod={"shank_width_mm": width}) for width in (18.0, 12.0)]
    return analyse_many([webs[0], grams, webs[1]], workers=2, **QUICK)


@pytest.mark.slow
def test_results_stand_in_the_order_of_their_studies(results):
    assert len(results) == 3
    assert [entry.study.rod.dimensions.shank_width for entry in results.succeeded] == [18.0, 12.0]
    assert results[0].summary.rod.mass_kg > results[2].summary.rod.mass_kg
    assert results[2:][0] is results[2]


def test_an_error_is_the_entry_of_its_study_and_the_others_go_on(results):
    assert list(results.errors) == [1]
    assert isinstance(results[1], fea.InvalidValue)
    assert repr(results).startswith(
        "<2 results, 1 error>\nstudy 1: InvalidValue: engine.piston_mass_kg = 500"
    )
    assert "give unusual=True" in str(results[1])


def test_results_are_those_of_one_analysis_without_its_fields(results):
    again = fea.analyse(results[0].study)
    assert results[0].summary.results["tension"].max_von_mises_MPa == pytest.approx(
        again.summary.results["tension"].max_von_mises_MPa, rel=1e-6
    )
    assert len(pickle.dumps(results)) < 2e6
    with pytest.raises(fea.InvalidValue, match="kept without its fields"):
        _ = results[0].cases["tension"]


def test_a_row_for_each_study_says_how_they_differ_and_what_came_out(results):
    pytest.importorskip("pandas")
    table = results.to_frame()
    assert list(table.columns[:2]) == ["rod.shank_width_mm", "engine.piston_mass_kg"]
    assert list(table["rod.shank_width_mm"])[::2] == [18.0, 12.0]
    assert table.loc[0, "mass_kg"] == results[0].summary.rod.mass_kg
    assert table["mass_kg"].isna().tolist() == [False, True, False]
    assert table.loc[1, "error"] == str(results[1])


def test_fields_are_kept_where_they_are_asked_for():
    (kept,) = analyse_many([plain_study()], fields=True, workers=1, **QUICK)
    tension = kept.cases["tension"]
    assert tension.stress.shape == (len(kept.mesh.points), 6)
    assert kept.fields["tension"]["von_mises"].max() == pytest.approx(tension.max_von_mises)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (([],), None),
        (("leon-2001",), "studies = 'leon-2001': is one study"),
        (([], {"workers": 0}), "workers = 0: must be at least 1"),
        (([], {"sise": 12}), "Did you mean size"),
        (([], {"out": "here"}), "unknown key"),
    ],
)
def test_what_is_wrong_for_all_is_refused_at_once(arguments, says):
    studies, flags = (*arguments, {})[:2]
    if says is None:
        assert len(analyse_many(studies, **flags)) == 0
        return
    with pytest.raises(fea.InvalidValue, match=says):
        analyse_many(studies, **flags)


@pytest.mark.parametrize(("progress", "shown"), [(None, ""), (False, ""), (True, "0 of 3\n1 of 3\n")])
def test_progress_is_shown_in_scripts_where_it_is_asked_for(progress, shown, monkeypatch):
    said = []

    @contextmanager
    def progress_line(first, *, silent):
        assert not silent
        said.append(first)
        yield said.append

    monkeypatch.setattr(clock, "progress_line", progress_line)
    with clock.progress_shown(progress, "0 of 3") as show:
        show("1 of 3")
    assert "".join(f"{text}\n" for text in said) == shown


@pytest.mark.parametrize(("progress", "shown"), [(None, ["0 of 3", "1 of 3"]), (False, [])])
def test_progress_in_a_notebook_is_a_text_that_changes(progress, shown, monkeypatch):
    said = []

    def display(data, **_options):
        said.append(data["text/plain"])
        return SimpleNamespace(update=display)

    monkeypatch.setitem(
        sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: SimpleNamespace(kernel=1))
    )
    monkeypatch.setitem(sys.modules, "IPython.display", SimpleNamespace(display=display))
    with clock.progress_shown(progress, "0 of 3") as show:
        show("1 of 3")
    assert said == shown
