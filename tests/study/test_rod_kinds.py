"""Rods by kind: drawn from a length and two bores, with a cap whose bolts have room."""

import pytest

from fea.__main__ import call
from fea.judge.bolt_choice import seats_of
from fea.study.rod_table import rod_of_kind
from fea.study.study import load_study
from geometry.errors import InvalidValue
from geometry.section import HeightField


@pytest.mark.parametrize("kind", ["h-beam", "i-beam"])
@pytest.mark.parametrize(
    ("bores", "thread"),
    [((152.4, 56.515, 23.55), "3/8-24"), ((100.0, 37.0, 16.0), "1/4-28"), ((180.0, 66.0, 30.0), "7/16-20")],
)
def test_heads_have_seats_and_bolts_suit_the_big_end(kind, bores, thread):
    made = rod_of_kind(kind, *bores)
    assert made.thread.name == thread
    assert made.rod.cap_bolt == made.thread.diameter
    assert 2 * seats_of(made.rod).room >= 1.5 * made.thread.diameter
    assert (made.rod.length, made.rod.big_end_bore, made.rod.small_end_bore) == bores


def test_a_six_inch_h_beam_weighs_what_it_should():
    made = rod_of_kind("h-beam", 152.4, 56.515, 23.55, "7/16-20 UNF")
    # Weighed without its bolts: 645 g (post of 2010 at forum.grumpysperformance.com, topic 3540).
    assert HeightField(made.rod).mass().mass * 7.85e-3 == pytest.approx(645, rel=0.1)


def test_an_engine_gets_a_rod_of_a_kind(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given = [
        "--length",
        "6 in",
        "--big-end-bore",
        "2.225 in",
        "--small-end-bore",
        "23.55",
        "--thread",
        "M10x1",
    ]
    assert call(["init", "a.toml", "--kind", "h-beam", "--engine", "chevrolet-454", *given]) == 0
    study = load_study("a.toml")
    assert study.rod.dimensions.length == pytest.approx(152.4)
    assert study.assembly.bolt_thread == "M10x1"
    assert study.rod.dimensions.cap_bolt == 10.0
    assert call(["init", "b.toml", "--engine", "chevrolet-454", "--thread", "M10x1"]) == 2
    assert call(["init", "b.toml", "--kind", "h-beam"]) == 2
    with pytest.raises(InvalidValue, match="must be one of h-beam, i-beam"):
        rod_of_kind("x-beam", 152.4, 56.515, 23.55)
