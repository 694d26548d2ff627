"""What a run of a bolted rod prints; that of other rods is looked at where they are run."""

from dataclasses import fields, replace
from io import StringIO

import pytest
from printed import after_the_table, flowing, require_brief
from rich.console import Console

from fea.analysis.summary_figures import FilmFigures
from fea.apps.result import analyse
from fea.output.terminal.run import print_runs

pytestmark = [pytest.mark.usefixtures("coarse_bores"), pytest.mark.slow]


@pytest.fixture(scope="module")
def bolted():
    return analyse("leon-2001-bolted", size=25).summary


def printed(summary, folder, *, verbose=False):
    console = Console(file=StringIO(), width=80)
    print_runs([(folder, summary)], console, verbose=verbose)
    return console.file.getvalue()


def test_bolts_joint_and_fits_take_a_line_each(bolted, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = printed(bolted, tmp_path)
    require_brief(text)
    most = bolted.survival.fatigue_at_most
    assert f"fails by fatigue, safety factor at most {most:.2f} (" in text
    heads = [line.partition(" ")[0].strip(",:") for line in after_the_table(text)]
    assert heads[:3] == ["Governs", "Bolts", "Joint"]
    assert str(bolted.model.elements) in heads
    assert not any(line.startswith((" joint", " shells")) for line in text.splitlines())
    weakest = bolted.results["tension"].weakest
    assert (weakest.where, weakest.part) == ("shank towards the small end", "rod")
    assert {case.singular_where.partition(" ")[0] for case in bolted.results.values()} == {"rim"}


def test_films_leave_room_for_bolts_and_joint(bolted, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    values = dict.fromkeys((item.name for item in fields(FilmFigures)), 12.5)
    film = FilmFigures(**values | {"verdict": "mixed"})
    text = printed(replace(bolted, film={"big_end": film, "small_end": film}), tmp_path)
    require_brief(text)
    heads = [line.partition(" ")[0].strip(",:") for line in after_the_table(text)]
    kept = [head for head in heads if head in ("Governs", "Bolts", "Joint", "Oil")]
    assert kept[:4] == ["Governs", "Bolts", "Joint", "Oil"]


def test_what_governs_of_them_gets_its_table(bolted, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    bolts = replace(bolted, survival=replace(bolted.survival, mode="fatigue of the bolts", case=None))
    text = printed(bolts, tmp_path)
    require_brief(text)
    assert "Governs: fatigue of the bolts." in text
    assert {"clamped", "open", "gap"} <= set(text.split())
    assert "lifted" not in text  # of the fits
    tension = bolted.results["tension"]
    shells = replace(tension, weakest=replace(tension.weakest, part="upper shell"))
    yields = replace(bolted.survival, mode="yielding", case="tension", place=None)
    cases = bolted.results | {"tension": shells}
    text = printed(replace(bolted, results=cases, survival=yields), tmp_path)
    assert any(line.split()[:1] == ["shells"] for line in text.splitlines())
    assert "(upper shell)" in text


def test_verbose_prints_all_tables_and_every_note(bolted, tmp_path):
    text = printed(bolted, tmp_path, verbose=True)
    for name in ("joint", "bushing", "shells"):
        assert any(line.split()[:1] == [name] for line in text.splitlines())
    notes = (*bolted.notes, *bolted.left_out)
    assert len(notes) > 20
    assert all(f"- {note}" in flowing(text) for note in notes)
