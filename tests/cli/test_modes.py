import json

import meshio
from program import PLAIN, fea


def test_modes_as_json_and_shapes_in_a_file(tmp_path):
    run = fea("modes", *PLAIN, "--rpm", "6000", "--count", "3", "--vtu", "modes.vtu", "--json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    figures = json.loads(run.stdout)
    assert figures["trusted"]
    assert [mode["frequency_Hz"] for mode in figures["modes"]] == sorted(
        mode["frequency_Hz"] for mode in figures["modes"]
    )
    shapes = meshio.read(tmp_path / "modes.vtu").point_data
    assert sorted(shapes) == ["mode_1", "mode_2", "mode_3"]
    assert shapes["mode_1"].shape == (figures["nodes"], 3)


def test_modes_as_a_table(tmp_path):
    run = fea("modes", *PLAIN, "--count", "2", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    assert "order at" in run.stdout
    assert "sideways" in run.stdout
