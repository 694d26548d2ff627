import json

import meshio
import pytest
from printed import flowing, require_brief
from program import PLAIN, fea


def test_buckling_leaves_factors_shapes_and_a_run_that_may_be_replaced(tmp_path):
    run = fea("run", *PLAIN, "--buckling", "--out", "out", "--min-safety", "2.5", cwd=tmp_path)
    assert run.returncode == 6, run.stderr
    require_brief(run.stdout)
    figures = json.loads((tmp_path / "out" / "summary.json").read_text())
    found = figures["buckling"]
    factors = [mode["factor"] for mode in found["modes"]["compression"]]
    assert factors == sorted(factors)
    plane = found["column"]["planes"]["in_plane"]
    said = f"Buckling: {plane['safety_factor']:.2f} in the plane of motion, under "
    assert said in run.stdout
    assert f"modes of the solid {factors[0]:.2f}." in flowing(run.stdout)
    assert plane["safety_factor"] == pytest.approx(plane["rankine_N"] / found["column"]["force_N"], rel=1e-5)
    shapes = meshio.read(tmp_path / "out" / "buckling.vtu").point_data
    assert sorted(shapes) == ["mode_1", "mode_2", "mode_3"]
    again = fea("run", *PLAIN, "--out", "out", "--quiet", cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    assert not (tmp_path / "out" / "buckling.vtu").exists()
    assert "modes" not in json.loads((tmp_path / "out" / "summary.json").read_text())["buckling"]
