import pytest

from fea.base.checks import check
from fea.base.choices import Fatigue, Finish, Loading
from fea.base.note import NoteKind
from fea.judge.fatigue import check_notes, fatigue_notes
from fea.study.material_table import MaterialTable
from geometry.errors import InvalidValue


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
HALF = "half the ultimate strength as endurance limit"
MEDIAN = "the median strength (reliability 50 %)"


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        (
            {"preset": "leon-2001"},
            [f"{HALF} in bending, and 0.85 of it under axial load", *SHOT, MEDIAN],
        ),
        ({"preset": "leon-2001", "loading": Loading.BENDING}, [HALF, *SHOT, MEDIAN]),
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
    assert "a factor of 1 means 5·10⁸ cycles, 10⁹ revolutions" in str(said)


def test_nothing_is_assumed_where_everything_is_given():
    given = MaterialTable(preset="hard-steel-1945", surface=Finish.POLISHED, reliability_percent=99.0)
    assert fatigue_notes([given.material()], Fatigue.GOODMAN) == ()


STEEL = {"E_GPa": 207.0, "nu": 0.3, "density_kg_m3": 7800.0, "yield_MPa": 600.0, "ultimate_MPa": 900.0}


def test_an_estimated_limit_is_that_under_axial_load_and_a_given_one_is_not_changed():
    """0.85 · 0.5 · 900 MPa; a limit or an S–N line that the study gives is of its own tests."""
    assert MaterialTable(**STEEL).material().endurance_limit == pytest.approx(382.5)
    assert MaterialTable(**STEEL, loading=Loading.BENDING).material().endurance_limit == 450.0
    assert MaterialTable(**STEEL, endurance_MPa=400.0).material().endurance_limit == 400.0
    line = {"fatigue_strength_coefficient_MPa": 1350.0, "fatigue_strength_exponent": -0.087}
    assert MaterialTable(**STEEL, **line).material().endurance_limit == 450.0


@pytest.mark.parametrize(
    ("keys", "supported"),
    [
        ({}, True),
        ({"support": False}, False),
        ({"size_mm": 20.0}, False),
        ({"loading": Loading.BENDING}, False),
        ({"loading": Loading.AXIAL}, True),
        ({"ultimate_MPa": None}, False),
        ({"E_GPa": 71.7}, False),
    ],
)
def test_gradients_support_steels_without_a_factor_of_size(keys, supported):
    assert MaterialTable(**STEEL | keys).material().support is supported


@pytest.mark.parametrize(
    ("keys", "rule"),
    [
        ({"support": True, "size_mm": 20.0}, "material.support = True: cannot be combined with size_mm"),
        ({"support": True, "E_GPa": 71.7}, "is known of steel of known ultimate_MPa only"),
        ({"fatigue_ductility_coefficient": 0.6}, "fatigue_ductility_exponent"),
        ({"fatigue_ductility_exponent": 0.6, "fatigue_ductility_coefficient": 0.6}, "must lie between -1"),
    ],
)
def test_what_cannot_be_judged_is_refused(keys, rule):
    with pytest.raises(InvalidValue, match=rule):
        MaterialTable(**STEEL | keys).material()
