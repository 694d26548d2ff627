import json

import meshio
import numpy as np
import pytest
from printed import flowing, require_brief
from program import fea
from studies import DUTY, LEON, PLAIN, PRESSED

pytestmark = pytest.mark.slow


STUDY = DUTY.replace(LEON, PLAIN) + PRESSED + "[mesh]\nsize_mm = 14.0\n"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("duty")
    (folder / "used.toml").write_text(STUDY)
    return folder / "out", fea("run", "used.toml", "--out", "out", cwd=folder)


def test_a_duty_runs_its_speeds_and_leaves_the_life(run):
    out, done = run
    assert done.returncode == 0, done.stderr
    lives = [json.loads((out / f"{rpm}rpm" / "summary.json").read_text())["life"] for rpm in (4000, 6000)]
    assert lives[0] == lives[1]
    life = lives[0]
    assert life["duty"][1]["damage_percent"] > 99
    low, high = life["band_hours"]
    assert low < life["hours"] < high
    fields = meshio.read(out / "6000rpm" / "envelope.vtu")
    damage = fields.point_data["damage_per_hour"]
    assert damage.max() == pytest.approx(life["damage_per_hour"], rel=2.5e-4)
    away = np.linalg.norm(fields.points - life["at_mm"], axis=1)
    assert damage[away.argmin()] == damage.max()
    require_brief(done.stdout)
    assert f"Life over the duty: {life['hours']:.3g} h ({low:.3g} h to {high:.3g} h)" in flowing(done.stdout)
    assert "at 6000 rpm" in done.stdout
    left_out = json.loads((out / "4000rpm" / "summary.json").read_text())["left_out"]
    assert any("fretting" in item["what"] for item in left_out)


def test_one_of_its_speeds_runs_again_with_the_same_life(run):
    out, _ = run
    alone = fea("run", "study.toml", "--json", "--out", out.parent / "again", cwd=out / "6000rpm")
    assert alone.returncode == 0, alone.stderr
    before = json.loads((out / "6000rpm" / "summary.json").read_text())
    assert json.loads(alone.stdout)["life"] == before["life"]


def test_a_duty_that_is_none_leaves_nothing(tmp_path):
    (tmp_path / "used.toml").write_text(STUDY.replace("[90, 10]", "[90, 20]"))
    done = fea("run", "used.toml", "--out", "out", cwd=tmp_path)
    assert done.returncode == 2
    assert "duty.share_percent" in done.stderr
    assert not (tmp_path / "out").exists()


LOGGED = """[duty]
log = "lap.csv"
[[gauge]]
name = "shank"
at_mm = [72.0, 4.2, 6.0]
direction = [1, 0, 0]
length_mm = 3.0
measured = [1500.0, -800.0, -700.0, 100.0, -900.0]
"""


def test_a_log_and_gauges_leave_their_files_and_their_sections(tmp_path):
    head, _, rest = STUDY.partition("[duty]")
    (tmp_path / "logged.toml").write_text(head + rest[rest.index("\n[") + 1 :] + LOGGED)
    lines = "".join(f"{0.05 * k:.2f},{4000 if k % 40 < 30 else 6000}\n" for k in range(400))
    (tmp_path / "lap.csv").write_text(f"time [s],rpm\n{lines}")
    done = fea("run", "logged.toml", "--report", "--verbose", "--out", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["rpm"] == 6000
    assert summary["life"]["log"]["hours"] == pytest.approx(20 / 3600)
    said = flowing(done.stdout)
    assert "times lap.csv: " in said
    assert "With a critical damage of 0.3" in said
    assert (tmp_path / "out" / "log.csv").read_text().startswith("time_s,rpm,damage_percent\n")
    rows = (tmp_path / "out" / "gauges.csv").read_text().splitlines()
    assert len(rows) == 1 + 5 + 721
    assert rows[1].startswith("shank,tension,")
    assert rows[1].endswith(",1500")
    page = (tmp_path / "out" / "report.html").read_text()
    assert all(
        name in page for name in ('id="chart-log-damage"', "Strain gauges", "shank, highest of the cycle")
    )
    # Without the log, the run is still read; a gauge beside the rod is refused before anything is solved.
    (tmp_path / "lap.csv").unlink()
    again = fea("report", "out", cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    (tmp_path / "far.toml").write_text(
        (tmp_path / "logged.toml").read_text().replace("72.0, 4.2", "72.0, 40")
    )
    (tmp_path / "lap.csv").write_text(f"time [s],rpm\n{lines}")
    refused = fea("run", "far.toml", "--out", "far", cwd=tmp_path)
    assert refused.returncode == 2
    assert "from the free surface of the rod" in refused.stderr
    assert not (tmp_path / "far").exists()
