"""`fea loads` and `fea reproduce` as a user calls them."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from traces import absolute, gauge, written

from fea.__main__ import call
from fea.study.study import load_study, parse_study


@pytest.fixture
def piston_study(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(
        "[rod]\nlength_mm = 120\nmass_kg = 0.384\ncenter_of_gravity_mm = 31.77\ninertia_kg_m2 = 9.4e-4\n"
        '[engine]\nstroke_mm = 77\nbore_mm = 73.6\npiston_mass_kg = 0.208\ncylinders = 3\ngas = "motored"\n'
        "compression_ratio = 9\n[speed]\nrpm = 3000\n",
        encoding="utf-8",
    )
    return str(path)


def test_loads_json_of_one_and_of_several_speeds(piston_study, capsys):
    assert call(["loads", piston_study, "--json"]) == 0
    one = json.loads(capsys.readouterr().out)
    assert one["rpm"] == 3000
    assert one["extremes"]["gas_N"]["max_crank_deg"] == 360
    assert call(["loads", piston_study, "--rpm", "1000,2000", "--json"]) == 0
    assert [item["rpm"] for item in json.loads(capsys.readouterr().out)] == [1000, 2000]


def test_loads_csv_has_the_promised_columns_and_cylinders(piston_study, tmp_path, capsys):
    file = tmp_path / "cycle.csv"
    assert call(["loads", piston_study, "--cylinders", "all", "--csv", str(file)]) == 0
    assert "whole engine" in capsys.readouterr().out
    with file.open(encoding="utf-8") as handle:
        rows = list(csv.DictReader(handle))
    assert len(rows) == 4 * 721
    assert list(rows[0])[:4] == ["cylinder", "rpm", "crank_deg", "gas_N"]
    assert rows[0]["gas_N"] == ""  # the whole engine has no one gas force
    torque = np.array([float(row["torque_Nm"]) for row in rows]).reshape(4, 721)
    np.testing.assert_allclose(torque[0], torque[1:].sum(axis=0), atol=1e-4)


def test_loads_plot(piston_study, tmp_path, capsys):
    file = tmp_path / "torque.png"
    assert call(["loads", piston_study, "--rpm", "1000,3000", "--plot", str(file)]) == 0
    assert file.read_bytes()[:4] == b"\x89PNG"
    assert str(file) in capsys.readouterr().out.replace("\n", "")


def test_loads_plot_where_it_cannot_be_written(piston_study, tmp_path, capsys):
    assert call(["loads", piston_study, "--plot", str(tmp_path / "none" / "x.png")]) == 2
    assert "does not exist" in capsys.readouterr().err
    assert call(["loads", piston_study, "--plot", str(tmp_path / "x.docx")]) == 2
    assert ".png or .pdf or .svg" in capsys.readouterr().err
    assert call(["loads", piston_study, "--csv", str(tmp_path)]) == 2
    assert "is a directory" in capsys.readouterr().err


def test_loads_needs_an_engine(capsys):
    assert call(["loads", "leon-2001-as-published"]) == 2
    assert "no [engine]" in capsys.readouterr().err


@pytest.mark.parametrize("study", ["columba-2022", "molina-2024"])
def test_shipped_studies_of_dynamics(study, capsys):
    assert call(["loads", study, "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)) == 3


def test_reproduce_json_and_report(tmp_path, capsys):
    report = tmp_path / "reproduction.md"
    assert call(["reproduce", "molina-2024", "--json", "--report", str(report)]) == 0
    rows = json.loads(capsys.readouterr().out)
    promised = {
        "source",
        "table",
        "quantity",
        "at",
        "unit",
        "published",
        "as_published",
        "corrected",
        "cause",
    }
    assert promised <= set(rows[0])
    text = report.read_text(encoding="utf-8")
    assert "0 are unexplained" in text
    assert "reproduction-molina-2024.png" in text
    assert str(tmp_path) not in text
    assert (tmp_path / "reproduction-molina-2024.png").stat().st_size < 300_000


def test_reproduce_prints_counts_and_misprints(capsys):
    assert call(["reproduce"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "2359 printed figures were compared" in out
    assert "0 are unexplained" in out
    assert "62.61 was used instead of the 62.81" in out


def test_reproduce_leaves_with_5_when_a_figure_is_unexplained(monkeypatch, capsys):
    from fea.verify.reproduce import leon

    monkeypatch.setitem(leon.STUDY.data["expressions"], "LAMBDA_POSITION", "0.15")
    assert call(["reproduce", "leon-2001"]) == 5
    assert "UNEXPLAINED" in capsys.readouterr().out


def test_reproduce_refuses_an_unknown_study(capsys):
    assert call(["reproduce", "nobody-1999"]) == 2
    assert "leon-2001" in capsys.readouterr().err


def test_the_cycle_is_not_written_over_the_trace_it_comes_from(tmp_path, capsys):
    trace = tmp_path / "gas.csv"
    trace.write_text("crank_deg,pressure_bar\n0,1\n240,2\n480,1\n")
    study = tmp_path / "s.toml"
    engine = "stroke_mm = 94.0\nbore_mm = 76.0\npiston_mass_kg = 1.3\ngas = 'gas.csv'\n"
    study.write_text(f"[rod]\npreset = 'leon-2001'\n[engine]\n{engine}")
    assert call(["loads", str(study), "--csv", str(trace)]) == 2
    assert "is the study's own pressure trace" in capsys.readouterr().err
    assert trace.read_text().startswith("crank_deg,pressure_bar\n0,1")


@pytest.fixture
def traced(piston_study, tmp_path):
    """A study whose gas is a trace: its text and further keys of [engine] as arguments."""

    def write(trace, keys=""):
        (tmp_path / "bench.csv").write_text(trace, encoding="utf-8")
        text = Path(piston_study).read_text(encoding="utf-8")
        gas = f'"bench.csv"\n{keys}\n[speed]'
        study = tmp_path / "traced.toml"
        study.write_text(text.replace('"motored"\ncompression_ratio = 9\n[speed]', gas), encoding="utf-8")
        return str(study)

    return write


def test_a_foreign_trace_gives_the_forces_of_ours(traced, tmp_path, capsys):
    degrees = np.arange(0.0, 720.0)
    ours = written(degrees, gauge(degrees), header=["crank_deg,pressure_bar"])
    foreign = written(
        degrees - 360, absolute(degrees - 360) / 10, separator=";", comma=True, header=["CA [deg];Pcyl [MPa]"]
    )
    found = []
    for text in (ours, foreign):
        assert call(["loads", traced(text), "--json"]) == 0
        found.append(json.loads(capsys.readouterr().out))
    np.testing.assert_allclose(found[1]["mean_torque_Nm"], found[0]["mean_torque_Nm"], rtol=1e-6)
    pulls = [report["extremes"]["crank_axial_N"]["max"] for report in found]
    np.testing.assert_allclose(pulls[1], pulls[0], rtol=1e-6)
    assert "assuming" not in found[0]["note"]
    assert found[1]["trace"]["unit"] == "MPa"
    assert found[1]["trace"]["offset_bar"] == 0
    peak = gauge(degrees).max()
    assert [report["trace"]["peak_bar"] for report in found] == pytest.approx([peak, peak], rel=1e-5)
    assert 'pressure_reference = "absolute"' in found[1]["note"]
    plot = tmp_path / "forces.svg"
    assert call(["loads", traced(foreign), "--plot", str(plot), "--quiet"]) == 0
    assert "bench.csv, as read" in plot.read_text(encoding="utf-8")


def test_what_was_assumed_stands_in_the_resolved_study(traced):
    degrees = np.arange(0.0, 720.0)
    study = load_study(traced(written(degrees - 180, absolute(degrees - 360), header=["CA,p [bar]"])))
    again = parse_study(study.text(), "again", Path("/"))
    assert again.engine.angle_offset_deg == 180
    assert again.engine.pressure_reference == "absolute"
    assert again.text() == study.text()
    trace, same = (s.engine.gas_model(s.engine.engine(120.0)) for s in (study, again))
    np.testing.assert_array_equal(trace.pressures, same.pressures)
    assert same.remarks == ()


def test_the_resolved_study_of_a_trace_of_ours_says_no_more_than_the_study(traced):
    degrees = np.arange(0.0, 720.0)
    study = load_study(traced(written(degrees, gauge(degrees), header=["crank_deg,pressure_bar"])))
    assert study.engine.resolved() == study.engine


def test_keys_of_a_trace_need_a_trace(piston_study, tmp_path, capsys):
    study = tmp_path / "motored.toml"
    text = Path(piston_study).read_text(encoding="utf-8")
    study.write_text(text.replace("compression_ratio = 9", 'compression_ratio = 9\npressure_unit = "bar"'))
    assert call(["loads", str(study)]) == 2
    assert "engine.pressure_unit = 'bar': says how a file is to be read" in capsys.readouterr().err


def test_a_trace_that_makes_the_engine_absorb_power_is_told(traced, capsys):
    degrees = np.arange(0.0, 720.0)
    turned = written(degrees, np.roll(gauge(degrees), 180), header=["crank_deg,pressure_bar"])
    assert call(["loads", traced(turned), "--json"]) == 0
    note = json.loads(capsys.readouterr().out)["note"]
    assert "the mean torque over the cycle is -" in note
    assert "peaks at 558°, far from firing TDC at 360°" in note


def test_an_indicated_torque_below_the_brake_torque_is_doubted(traced, capsys):
    degrees = np.arange(0.0, 720.0)
    study = Path(traced(written(degrees, gauge(degrees), header=["crank_deg,pressure_bar"])))
    text = study.read_text(encoding="utf-8")
    full = "full_load = [{{ rpm = 100, torque_Nm = {0} }}, {{ rpm = 20000, torque_Nm = {0} }}]\n[speed]"
    for torque, doubted in ((1.0, False), (900.0, True)):
        study.write_text(text.replace("[speed]", full.format(torque)), encoding="utf-8")
        assert call(["loads", str(study)]) == 0
        assert ("below its brake torque" in " ".join(capsys.readouterr().out.split())) == doubted


def test_a_pressure_that_peaks_between_degrees_is_told(piston_study, tmp_path, capsys):
    study = tmp_path / "knock.toml"
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    study.write_text(text.replace('"motored"\ncompression_ratio = 9', '"knock.csv"'), encoding="utf-8")
    rows = ["crank_deg,pressure_bar", "0,0", "350,20", "372,50", "372.4,80", "372.8,50", "400,10", "540,1"]
    (tmp_path / "knock.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    assert call(["loads", str(study), "--json"]) == 0
    assert "peaks at 372.4°, 80 bar, between whole degrees" in json.loads(capsys.readouterr().out)["note"]
    assert call(["loads", piston_study, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["note"] is None
