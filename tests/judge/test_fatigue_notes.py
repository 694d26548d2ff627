import pytest

from fea.base.checks import check
from fea.base.choices import Fatigue, Finish
from fea.base.note import NoteKind
from fea.judge.fatigue import check_notes, fatigue_notes
from fea.study.material_table import MaterialTable


@pytest.mark.parametrize("name", ["tilt", "small_strain", "small_displacement"])
def test_a_failed_check_of_the_model_is_put_into_words(name):
    assert len(check_notes({name: check(name, 1.0)})) == 1
    assert check_notes({name: check(name, 0.0)}) == ()


def test_only_strengths_that_the_criterion_needs_are_missed():
    known = {"E_GPa": 200.0, "nu": 0.3, "density_kg_m3": 7800.0, "yield_MPa": 600.0}
    material = MaterialTable(**known, endurance_MPa=300.0).material()
    assumed = fatigue_notes([material], Fatigue.SODERBERG)
    assert {note.kind for note in assumed} == {NoteKind.ASSUMPTION}
    warned, *again = fatigue_notes([material], Fatigue.GOODMAN)
    assert "without endurance_MPa or ultimate_MPa" in str(warned)
    assert again == list(assumed)
    (note,) = fatigue_notes([MaterialTable(**known).material()], Fatigue.SODERBERG)
    assert "ultimate" not in str(note)


SHOT = ["a machined surface of bores and faces", "a shot-peened surface of rest"]
MEDIAN = "the median strength (reliability 50 %)"


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"preset": "leon-2001"}, ["half the ultimate strength as endurance limit", *SHOT, MEDIAN]),
        ({"preset": "c70-2005", "reliability_percent": 99.0}, SHOT),
        ({"preset": "c70-2005", "surface": Finish.AS_FORGED}, [SHOT[0], MEDIAN]),
        (
            {"preset": "al-7075-t6"},
            [*(f"{each} (with the factor of a steel of the same strength)" for each in SHOT), MEDIAN],
        ),
    ],
)
def test_what_is_assumed_of_endurance_is_said(keys, said):
    notes = fatigue_notes([MaterialTable(**keys).material()], Fatigue.GOODMAN)
    assumed = [str(note) for note in notes if note.kind is NoteKind.ASSUMPTION]
    assert assumed == [f"fatigue: assumed {what}" for what in said]


def test_what_the_factor_of_a_metal_without_a_limit_means_is_said():
    metals = [MaterialTable(preset=name).material() for name in ("7075-T6", "2618-T61", "c70-2005")]
    (said,) = (note for note in fatigue_notes(metals, Fatigue.GOODMAN) if note.kind is NoteKind.WARNING)
    assert "a factor of 1 means 5e+08 cycles, 1e+09 revolutions" in str(said)


def test_nothing_is_assumed_where_everything_is_given():
    given = MaterialTable(preset="hard-steel-1945", surface=Finish.POLISHED, reliability_percent=99.0)
    assert fatigue_notes([given.material()], Fatigue.GOODMAN) == ()
