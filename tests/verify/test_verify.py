import json

import pytest

from fea.__main__ import call
from fea.output.pictures.picture import is_complete_png
from fea.solid.traction import traction_forces
from fea.verify import benchmark, verify
from fea.verify.benchmark import Benchmark, Quantity
from fea.verify.body import STEEL, LoadedBody, furthest, held, pressure, rectangle
from geometry.bodies import Prism
from geometry.errors import InvalidValue
from geometry.surfaces import Surface
from mesh.generate import mesh_body


def peak(computed):
    return Quantity("peak", "MPa", -200.0, computed, 0.5, "a reason")


def test_the_error_is_relative_and_signed():
    assert peak(-201.0).error_percent == pytest.approx(-0.5)
    assert peak(-198.0).error_percent == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("computed", "passed"), [(-200.9, True), (-201.1, False), (-198.9, False), (float("nan"), False)]
)
def test_what_is_beyond_its_tolerance_or_no_number_fails(computed, passed):
    assert peak(computed).passed is passed


def test_the_cases_asked_of_the_project_are_there():
    asked = {"le1", "le10", "le11", "lame", "goodier", "plate-with-hole", "cook", "patch", "manufactured"}
    more = {"rotating-disc", "accelerated-bar", "pin-loaded-eye", "persson", "roller", "contact-patch"}
    assert asked | more <= set(verify.CASES)


def test_a_new_benchmark_is_one_function(monkeypatch, capsys):
    """The recipe of CONTRIBUTING.md."""
    names = (Surface.SYMMETRY_Y, Surface.LOADED, Surface.FREE, Surface.CLAMPED)
    monkeypatch.setitem(benchmark.CASES, "toy-bar", None)  # it is taken away afterwards
    monkeypatch.delitem(benchmark.CASES, "toy-bar")

    @benchmark.benchmark("Hooke 1678", size=2.0)
    def toy_bar(size):
        """Bar in tension."""
        mesh = mesh_body(Prism(rectangle((0.0, 20.0), (0.0, 4.0), names), (0.0, 4.0)), size)
        forces = traction_forces(mesh, Surface.LOADED, pressure(-100.0))
        body = LoadedBody(mesh, STEEL, forces, held(mesh, {Surface.CLAMPED: (0,)})).solved()
        stress = furthest(body.stress[:, 0], 100.0)
        yield Quantity("σxx, worst node", "MPa", 100.0, stress, 1e-6, "it is linear")
        return body.dofs

    assert verify.CASES["toy-bar"].title == "Bar in tension"
    assert call(["verify", "toy-bar"]) == 0
    assert "All 1 quantities" in capsys.readouterr().out
    with pytest.raises(ValueError, match="two benchmark problems are named toy-bar"):
        benchmark.benchmark("Hooke 1678", size=2.0)(toy_bar.compute)


def test_an_unknown_case_is_refused_before_anything_is_computed():
    told = []
    with pytest.raises(
        InvalidValue, match=r"is not a benchmark\. Choose from accelerated-bar, bent-bolt, bolted-joint, "
    ):
        verify.verify(["patch", "le99"], told.append)
    assert told == []


def test_an_unknown_case_is_wrong_usage(capsys):
    assert call(["verify", "le99"]) == 2
    assert "le10" in capsys.readouterr().err


def test_json_is_rows_and_nothing_else(capsys):
    assert call(["verify", "patch", "accelerated-bar", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["case"] for row in rows] == ["patch"] * 4 + ["accelerated-bar"] * 2
    keys = {"case", "quantity", "target", "computed", "error_percent", "dofs", "seconds", "pass", "source"}
    for found in rows:
        assert keys <= found.keys()
        assert found["pass"] is True


def test_the_table_names_every_quantity(capsys):
    assert call(["verify", "lame"]) == 0
    out = capsys.readouterr().out
    assert "radial displacement" in out
    assert "hoop stress" in out
    assert "All 2 quantities of 1 benchmark problems" in out


def test_a_row_out_of_tolerance_fails_the_command(monkeypatch, capsys):
    wrong = Benchmark("patch", "t", "s", lambda size: (yield peak(-210.0)), 1.0)
    monkeypatch.setitem(benchmark.CASES, "patch", wrong)
    assert call(["verify", "patch"]) == 5
    out = capsys.readouterr().out
    assert "FAIL" in out
    assert "1 of 1 quantities" in out


def test_the_report_tells_command_sources_and_reasons(tmp_path, capsys):
    path = tmp_path / "new" / "verification.md"
    assert call(["verify", "plate-with-hole", "patch", "--report", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)
    text = path.read_text(encoding="utf-8")
    assert "fea verify plate-with-hole patch --report verification.md" in text
    assert str(tmp_path) not in text
    for name in ("plate-with-hole", "patch"):
        case = verify.CASES[name]
        assert case.source in text
        assert all(row.quantity.why in text for row in case.rows(2.8))
    plot = path.with_name("verification-convergence.png")
    assert f"]({plot.name})" in text
    assert is_complete_png(plot)
    assert plot.stat().st_size < 300_000


def test_nothing_to_plot_no_plot(tmp_path):
    path = tmp_path / "patch.md"
    assert call(["verify", "patch", "--report", str(path), "--quiet"]) == 0
    assert not list(tmp_path.glob("*.png"))
    assert "Convergence" not in path.read_text(encoding="utf-8")
