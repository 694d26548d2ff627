import json

import meshio
import numpy as np
import pytest
from printed import flowing, require_brief
from program import fea
from studies import DUTY, LEON, PLAIN, PRESSED

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
