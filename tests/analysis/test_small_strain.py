from contextlib import chdir

import pytest

from fea import run

STUDY = """
[rod]
preset = "leon-2001"
[material]
E_GPa = {modulus}
nu = 0.3
density_kg_m3 = 7800.0
yield_MPa = 600.0
[forces]
pin_N = [30000.0, 0.0]
[mesh]
size_mm = 20.0
element = "p1"
"""


@pytest.mark.parametrize(
    ("modulus", "failed"),
    [(200.0, set()), (2.0, {"small_strain"}), (0.2, {"small_strain", "small_displacement"})],
)
def test_what_linear_elasticity_does_not_hold_for_is_not_trusted(tmp_path, modulus, failed):
    """Some 400 MPa at the peak: a strain of 0.2 % in steel, of 20 % in a plastic."""
    (tmp_path / "s.toml").write_text(STUDY.format(modulus=modulus))
    with chdir(tmp_path):
        summary = run("s.toml", out="r")
    assert {name for name, check in summary["checks"].items() if not check["pass"]} >= failed
    assert summary["trusted"] is (not failed)
