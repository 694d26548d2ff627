import csv
import json
import re

import meshio
import numpy as np
import pytest
from printed import flowing, require_brief
from program import fea
from studies import PLAIN, PRESSED

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cycle") / "sweep"
    (folder.parent / "plain.toml").write_text(PLAIN + PRESSED)
    flags = ("--rpm", "3000,6000", "--cycle", "--size", "14", "--out", folder)
    return folder, fea("run", "plain.toml", *flags, cwd=folder.parent)


def test_cycle_leaves_an_envelope_a_history_and_a_map(sweep):
    folder, run = sweep
    assert run.returncode == 0, run.stderr
    fast = folder / "6000rpm"
    envelope = meshio.read(fast / "envelope.vtu").point_data
    assert {"von_mises", "crank_deg", "mean", "amplitude", "stress_ratio", "crossland_safety_factor"} <= set(
        envelope
    )
    figures = json.loads((fast / "summary.json").read_text())["envelope"]
    assert figures["min_safety_factor"] == pytest.approx(envelope["safety_factor_node"].min(), rel=2.5e-4)
    assert figures["min_fatigue_safety_factor"] == pytest.approx(
        envelope["fatigue_safety_factor"].min(), rel=2.5e-4
    )
    # --tolerance 1.5 gives 0.681.
    share = figures["fatigue_error_percent"] / 100
    assert 0 < share < 0.4
    assert pytest.approx(figures["min_fatigue_safety_factor"], rel=share) == 0.681
    assert len(figures["spots"]) == 5
    assert len(figures["spots"][0]["history_MPa"]) == 721
    assert figures["spots"][0]["crossland_safety_factor"] > 0
    assert (fast / "history.png").stat().st_size > 10_000
    rows = list(csv.DictReader((folder / "cycle_map.csv").read_text().splitlines()))
    assert [float(row["rpm"]) for row in rows] == [3000, 6000]
    assert float(rows[1]["yield_safety_factor"]) == pytest.approx(figures["min_safety_factor"], rel=1e-5)
    require_brief(run.stdout)
    assert "safety factor below 1: yield" in run.stdout


def test_a_sweep_with_its_map_may_be_replaced_by_its_load_cases(sweep):
    folder, _ = sweep
    judged = json.loads((folder / "6000rpm" / "summary.json").read_text())["envelope"]
    flags = ("--rpm", "3000,6000", "--size", "14", "--out", folder, "--quiet")
    assert fea("run", "plain.toml", *flags, cwd=folder.parent).returncode == 0
    assert not (folder / "6000rpm" / "envelope.vtu").exists()
    # The cycle contains the load cases, and little that is worse than they are.
    found = json.loads((folder / "6000rpm" / "summary.json").read_text())["survival"]
    assert 0 <= found["fatigue_at_most"] / judged["min_fatigue_safety_factor"] - 1 < 0.01
    assert found["fatigue_where"]


def test_many_speeds_leave_fields_at_the_worst_and_figures_at_all(tmp_path):
    speeds = "0,1000:6000:500"
    gauge = '[[gauge]]\nname = "shank"\nat_mm = [72, 0, 6]\ndirection = [1, 0, 0]\nlength_mm = 3.0\n'
    (tmp_path / "plain.toml").write_text(PLAIN + PRESSED + gauge)
    flags = ("--cycle", "--size", "20", "--out", "many")
    run = fea("run", "plain.toml", "--rpm", speeds, *flags, cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    runs = {rpm: tmp_path / "many" / f"{rpm}rpm" for rpm in (0, *range(1000, 6001, 500))}
    summaries = {rpm: json.loads((folder / "summary.json").read_text()) for rpm, folder in runs.items()}
    assert {rpm for rpm, folder in runs.items() if (folder / "tension.vtu").exists()} == {6000}
    assert all(
        (folder / "loads.csv").exists() and (folder / "study.toml").exists() for folder in runs.values()
    )
    assert any("many speeds" in item["why"] for item in summaries[1000]["left_out"])
    assert not any("many speeds" in item["why"] for item in summaries[6000]["left_out"])
    require_brief(run.stdout)
    assert "Fields are written at the worst speeds, 6000 rpm." in run.stdout
    # What is superposed at 5500 rpm is what a run of its own solves there.
    alone = fea("run", runs[5500] / "study.toml", "--out", "alone", "--json", cwd=tmp_path)
    solved = json.loads(alone.stdout)
    for name in ("min_safety_factor", "min_fatigue_safety_factor"):
        assert summaries[5500]["envelope"][name] == pytest.approx(solved["envelope"][name], rel=5e-3)
    for case, result in solved["results"].items():
        assert summaries[5500]["results"][case]["max_von_mises_MPa"] == pytest.approx(
            result["max_von_mises_MPa"], rel=5e-3
        )
    (of_many,), (of_one,) = summaries[5500]["gauges"], solved["gauges"]
    history = np.array(of_one["history_um_m"])
    assert np.abs(np.array(of_many["history_um_m"]) - history).max() < 5e-3 * np.abs(history).max()
    assert {strain["error_um_m"] for strain in of_many["cases"].values()} == {None}
    rows = list(csv.DictReader((tmp_path / "many" / "map.csv").read_text().splitlines()))
    (row,) = (row for row in rows if (row["rpm"], row["case"]) == ("5500", "tension"))
    assert float(row["shank_um_m"]) == pytest.approx(of_one["cases"]["tension"]["strain_um_m"], rel=5e-3)
    # What is said of the mesh and of the loads is what holds at that speed.
    said = {rpm: {item["what"] for item in summary["left_out"]} for rpm, summary in summaries.items()}
    assert {rpm for rpm, what in said.items() if "inertia of the rod" in what} == {0}
    # Error bars are those of what is solved.
    alike = {note for note in solved["notes"] if not note.startswith("cannot govern")}
    assert alike <= set(summaries[5500]["notes"])
    assert all(
        any("times the default" in note for note in figures["notes"]) for figures in summaries.values()
    )
    # The critical speed lies between the speeds beside it, nearer than interpolation would place it.
    critical = summaries[6000]["critical_speeds_rpm"]["fatigue"]
    factors = {rpm: summary["envelope"]["min_fatigue_safety_factor"] for rpm, summary in summaries.items()}
    below = min(rpm for rpm, factor in factors.items() if factor < 1)
    assert below - 500 < critical < below
    assert f"fatigue from {round(critical, -1):.0f} rpm" in flowing(run.stdout)


def test_given_forces_have_no_cycle(tmp_path):
    study = tmp_path / "press.toml"
    study.write_text(
        '[rod]\npreset = "leon-2001"\n[forces]\npin_N = [1000.0, 0.0]\n[analysis]\ncycle = true\n'
    )
    run = fea("run", study, cwd=tmp_path)
    assert run.returncode == 2
    assert "[forces], which have no crank cycle. Give an [engine]" in run.stderr


def test_a_speed_without_any_load_is_refused(tmp_path):
    (tmp_path / "still.toml").write_text(
        """rod.preset = "leon-2001"
material.preset = "leon-2001"
engine = { stroke_mm = 94, bore_mm = 76, piston_mass_kg = 1.3, gas = "none" }
mesh.size_mm = 25
analysis.cycle = true
speed.rpm = [0, 3000]
"""
    )
    run = fea("run", "still.toml", cwd=tmp_path)
    assert run.returncode == 2
    assert "applies no load to the rod" in run.stderr
    assert not (tmp_path / "results").exists()


def test_a_forged_rod_is_judged_by_the_surface_of_each_region(tmp_path):
    (tmp_path / "forged.toml").write_text(
        """rod.preset = "leon-2001"
material = { preset = "forged-steel-2005", surface = "as-forged", reliability_percent = 99, support = false }
engine = { stroke_mm = 94, bore_mm = 76, piston_mass_kg = 1.3, gas = "none" }
mesh.size_mm = 25
analysis = { cycle = true, pressure = "cosine-180" }
"""
    )
    run = fea("run", "forged.toml", "--out", "o", "--verbose", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    rows = [line.split() for line in run.stdout.splitlines()]
    of_region = {row[1]: row for row in rows if row[:1] == ["rod,"]}
    for region, finish, surface in (("rest", "as-forged", 0.30), ("faces", "machined,", 0.735)):
        assert of_region[region][2:7] == ["423", "1", "1", "0.814", finish]
        assert float(of_region[region][-2]) == pytest.approx(surface, abs=5e-3)
    summary = json.loads((tmp_path / "o" / "summary.json").read_text())
    said = [*summary["notes"], *(f"{item['what']}: {item['why']}" for item in summary["left_out"])]
    assert len(said) > 3
    assert all(f"- {note}" in flowing(run.stdout) for note in said)
    assert max(map(len, run.stdout.splitlines())) <= 80
    envelope = summary["envelope"]
    regions = envelope["endurance"]["rod"]["regions"]
    assert regions["faces"] == {
        "finish": "machined",
        "surface_factor": 0.735432,
        "endurance_MPa": 253.192,
        "assumed": True,
    }
    # The web is as it was forged, and fails long before a machined bore could.
    worst = envelope["fatigue"]
    assert (worst["surface_region"], worst["endurance_MPa"]) == ("rest", regions["rest"]["endurance_MPa"])
    fields = meshio.read(tmp_path / "o" / "envelope.vtu").point_data
    limits = np.unique(fields["endurance_limit"])
    of_regions_and_inside = [103.3, 253.2, 344.3]
    assert limits == pytest.approx(of_regions_and_inside, rel=5e-4)
    assert fields["fatigue_safety_factor"].min() == pytest.approx(worst["fatigue_safety_factor"], rel=2.5e-4)
    weakest = fields["fatigue_safety_factor"].argmin()
    utilised = fields["amplitude"] / fields["endurance_limit"] + fields["mean"].clip(min=0) / 938
    assert utilised[weakest] == pytest.approx(1 / worst["fatigue_safety_factor"], rel=1e-4)
    crossland = fields["crossland_safety_factor"].min()
    assert crossland == pytest.approx(envelope["min_crossland_safety_factor"], rel=1e-3)
    assert envelope["crossland"]["surface_region"] == "rest"


TWO_STROKE = """[rod]
length_mm = 110.0
big_end_bore_mm = 30.0
small_end_bore_mm = 20.0
shank_section = "rectangular"
[material]
preset = "c70-2005"
[engine]
stroke_mm = 54.5
bore_mm = 54.0
piston_mass_kg = 0.15
strokes = 2
gas = "otto"
compression_ratio = 12.0
peak_pressure_bar = 60.0
roller_bearings = ["big end"]
[speed]
rpm = 10000
"""


def test_a_two_stroke_run_stays_within_one_revolution(tmp_path):
    (tmp_path / "two.toml").write_text(TWO_STROKE + PRESSED)
    flags = ("--cycle", "--size", "14", "--report", "--out", "run")
    run = fea("run", "two.toml", *flags, cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    out = tmp_path / "run"
    summary = json.loads((out / "summary.json").read_text())
    assert summary["engine"]["strokes"] == 2
    assert all(0 <= load["crank_deg"] < 360 for load in summary["loads"].values())
    assert summary["envelope"]["instants"] == 361
    assert {len(spot["history_MPa"]) for spot in summary["envelope"]["spots"]} == {361}
    with (out / "loads.csv").open() as file:
        angles = [float(row["crank_deg"]) for row in csv.DictReader(file)]
    np.testing.assert_allclose(angles, np.arange(361.0))
    assert meshio.read(out / "envelope.vtu").point_data["crank_deg"].max() <= 360
    times = [float(time) for time in re.findall(r'timestep="([^"]+)"', (out / "cases.pvd").read_text())]
    assert len(times) == len(summary["loads"])
    assert 0 <= min(times) <= max(times) < 360
    page = (out / "report.html").read_text()
    assert "at 0° the engine fires" in page
    assert 'max="360"' in page
    assert not re.search(r'max="720"|720°|>540°<', page)
    assert any("rollers of the big end" in note["what"] for note in summary["left_out"])
    assert any("exhaust_port_deg = 95" in note for note in map(str, summary["notes"]))
    assert "strokes = 2" in (out / "study.toml").read_text()
    refused = fea("run", "two.toml", "--film", cwd=tmp_path)
    assert refused.returncode == 2
    assert "big end runs on rollers" in refused.stderr
