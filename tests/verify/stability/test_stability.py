"""Extreme cases: none is wrong, what breaks is marked, and the report says so."""

import pytest

from fea import run
from fea.study.flags import Flags
from fea.study.study import load_study
from fea.verify.stability import bodies, runs
from fea.verify.stability.outcome import ExtremeRow, Outcome, judged
from fea.verify.stability.stability import CASES, counts, stability, write_report
from geometry.errors import InvalidValue

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def rows():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runs, "WEBS", (0.6,))  # thinner ones take seconds, as finer elements below
        patch.setattr(bodies, "MEMBRANE_SIZES", (12.0, 6.0))
        # The balance of the loads on the mesh is that of any pin model.
        patch.setattr(runs, "load_study", lambda name: Flags(pressure="cosine-180").applied(load_study(name)))
        return stability()


def test_none_is_wrong_and_metals_are_right(rows):
    assert not [row for row in rows if row.verdict is Outcome.WRONG]
    ordinary = {"material contrast": 1.0, "slenderness, p2": 10.0, "near-incompressible stress, p2": 0.3}
    found = {row.case: row.verdict for row in rows if ordinary.get(row.case) == row.value}
    assert found == dict.fromkeys(ordinary, Outcome.RIGHT)


def test_what_breaks_is_marked(rows):
    off = [
        row for row in rows if row.case.startswith("near-incompressible") and row.result_error_percent > 20
    ]
    assert len(off) >= 5
    assert {row.verdict for row in off} == {Outcome.MARKED}


def test_the_condition_follows_slenderness(rows):
    """κ grows with (L/h)⁴, as the softest mode of a beam does."""
    found = {row.value: row.condition_estimate for row in rows if row.case.startswith("slenderness")}
    assert found[100] / found[10] == pytest.approx(1e4, rel=0.2)


def named(rows, *cases):
    return [row for row in rows if row.case in cases]


def test_each_is_noticed_before_it_is_off(rows):
    """Along every parameter the first value that is marked comes no later than the first that is off."""
    off = [row for row in rows if row.result_error_percent is not None and row.tolerance_percent is not None]
    off = [row for row in off if row.result_error_percent > row.tolerance_percent]
    assert {row.case for row in off} >= {"bending, p1", "wall of a ring, p1"}
    assert all(row.verdict is Outcome.MARKED for row in off)
    assert all(
        row.noticed_by for row in named(off, "bending, p1", "wall of a ring, p1", "wall of a ring, p2")
    )


def test_slivers_are_noticed_by_their_shape_long_before_they_matter(rows):
    slivers = named(rows, "sliver, p2")
    assert [bool(row.noticed_by) for row in slivers] == [row.value < 5e-3 for row in slivers]
    assert slivers[-1].condition_estimate > 1e5 * slivers[0].condition_estimate
    assert slivers[-1].result_error_percent > 1e4 * slivers[0].result_error_percent


def test_elements_of_second_order_bend_whatever_their_size(rows):
    assert max(row.result_error_percent for row in named(rows, "bending, p2")) < 1e-8
    first = [row.result_error_percent for row in named(rows, "bending, p1")]
    assert first == sorted(first)
    assert first[-1] > 40


def test_loads_on_the_mesh_balance_at_every_extreme(rows):
    engines = [row for row in rows if row.case.endswith(", mesh")]
    assert {row.value for row in named(engines, "engine speed, mesh")} >= {0, 1, 20_000}
    assert {row.value for row in engines if row.verdict is Outcome.REFUSED} == {1000.0}  # bar
    assert max(row.result_error_percent for row in engines if row.verdict is Outcome.RIGHT) < 1e-11


def test_a_case_that_is_off_unnoticed_is_wrong():
    def verdict(error, *noticed_by):
        return judged(("c", "p", 1.0), error, 1.0, {}, noticed_by).verdict

    assert verdict(0.5) is Outcome.RIGHT
    assert verdict(2.0) is Outcome.WRONG
    assert verdict(2.0, "a check") is Outcome.MARKED
    assert verdict(float("nan")) is Outcome.WRONG
    assert "1 wrong" in counts([ExtremeRow("c", "p", 1.0, verdict=Outcome.WRONG)])


def test_a_case_that_is_not_there_is_refused():
    with pytest.raises(InvalidValue, match="contrast"):
        stability(["nonsense"])


def test_the_report_and_its_plot(rows, tmp_path):
    rows = [row for row in rows if "p2" in row.case][:30]
    write_report(tmp_path / "new" / "stability.md", rows, "fea stability")
    text = (tmp_path / "new" / "stability.md").read_text()
    assert all(row.case in text for row in rows)
    assert 10_000 < (tmp_path / "new" / "stability.png").stat().st_size < 300_000
    assert len(CASES) >= 6


@pytest.mark.parametrize(("nu", "element", "trusted"), [(0.4, "p2", True), (0.45, "p1", False)])
def test_a_run_marks_a_material_that_hardly_gives(tmp_path, monkeypatch, nu, element, trusted):
    monkeypatch.chdir(tmp_path)
    preset = 'preset = "leon-2001"'
    text = f"[rod]\n{preset}\n[material]\n{preset}\nnu = {nu}\n[forces]\npin_N = [1e4, 0]\n"
    (tmp_path / "s.toml").write_text(text)
    summary = run("s.toml", size=12, element=element)
    assert summary["checks"][f"poissons_ratio_{element}"]["pass"] is trusted
    assert summary["trusted"] is trusted
