"""Rods from every source, through the program."""

import re
from dataclasses import replace

import meshio
import numpy as np
import pytest
from cad_files import cad_file
from program import COARSE, fea, figures
from studies import ENGINE, PLAIN, PRESSED

from geometry.presets import PRESETS

pytestmark = pytest.mark.slow


LEON_2001 = PRESETS["leon-2001"]


def test_a_step_file_gives_what_the_dimensions_gave(tmp_path):
    material = '[material]\npreset = "leon-2001"\n' + PRESSED
    (tmp_path / "drawn.toml").write_text(PLAIN + material)
    (tmp_path / "mine.toml").write_text(f'[rod]\nstep = "drawn.step"\n{material}{ENGINE}')
    assert fea("rod", "drawn.toml", "--step", "drawn.step", "--quiet", cwd=tmp_path).returncode == 0
    drawn, read = (figures("rod", study, cwd=tmp_path) for study in ("drawn.toml", "mine.toml"))
    assert read["volume_mm3"] == pytest.approx(drawn["volume_mm3"], rel=1e-5)  # six digits are printed
    assert read["symmetry"] == "quarter"
    assert len(read["sections"]) == len(drawn["sections"])
    for name in ("area_mm2", "inertia_y_mm4", "inertia_z_mm4"):  # cut from flat-sided elements
        assert read["least_section"][name] == pytest.approx(drawn["least_section"][name], rel=0.01)
    assert read["slenderness"] == pytest.approx(drawn["slenderness"], rel=0.01)
    listed = fea("rod", "drawn.step", *COARSE, cwd=tmp_path).stdout
    assert " at (0, 0, 0) mm in the file" in listed  # and not at the kernel's 1e-15
    run = figures("run", "mine.toml", *COARSE, cwd=tmp_path)
    reference = figures("run", "drawn.toml", *COARSE, cwd=tmp_path)
    assert run["trusted"]
    for case, load in reference["loads"].items():
        assert run["loads"][case]["crank_axial_N"] == pytest.approx(load["crank_axial_N"], rel=1e-4, abs=1)
    # other elements, the same rod: peaks agree to the discretisation error of so coarse a mesh
    stress = [summary["results"]["tension"]["max_von_mises_MPa"] for summary in (run, reference)]
    assert stress[0] == pytest.approx(stress[1], rel=0.1)
    columns = [summary["buckling"]["column"]["planes"] for summary in (run, reference)]
    for plane in ("in_plane", "sideways"):
        loads = [column[plane]["rankine_N"] for column in columns]
        assert loads[0] == pytest.approx(loads[1], rel=0.01)


def test_a_bushing_of_bronze_is_a_part_with_its_own_yield(tmp_path):
    text = (
        '[rod]\npreset = "leon-2001"\nbushing_mm = 2.0\n[material]\npreset = "leon-2001"\n' + PRESSED + ENGINE
    )
    bronze = "[material.bushing]\nE_GPa = 110.0\nnu = 0.34\ndensity_kg_m3 = 8800.0\nyield_MPa = {}\n"
    (tmp_path / "strong.toml").write_text(text + bronze.format(2000.0))
    (tmp_path / "weak.toml").write_text(text + bronze.format(1.0))
    strong, weak = (figures("run", f"{name}.toml", *COARSE, cwd=tmp_path) for name in ("strong", "weak"))
    assert strong["trusted"]
    assert weak["trusted"]
    # the field is the same; only the judgement of the bushing differs
    assert (
        weak["results"]["tension"]["max_displacement_mm"]
        == strong["results"]["tension"]["max_displacement_mm"]
    )
    of_weak, of_strong = (one["results"]["tension"] for one in (weak, strong))
    assert of_weak["linings"]["bushing"]["safety_factor"] < 0.1 < of_weak["min_safety_factor"]
    assert of_strong["linings"]["bushing"]["safety_factor"] > 1
    assert of_weak["min_safety_factor"] == of_strong["min_safety_factor"]  # it does not end the rod
    grid = meshio.read(next(tmp_path.glob("results/weak-*/tension.vtu")))
    middle = grid.points[grid.cells[0].data[:, :4]].mean(axis=1)
    within = np.hypot(middle[:, 0] - 141.0, middle[:, 1]) < 12.0 + 2.0
    np.testing.assert_array_equal(grid.cell_data["part"][0], within)
    (tmp_path / "typo.toml").write_text(text + bronze.format(1.0).replace("bushing", "bushin"))
    done = fea("run", "typo.toml", cwd=tmp_path)
    assert done.returncode == 2
    assert "[material.bushin] does not name a part" in done.stderr
    assert "The parts of this rod are: rod, bushing" in done.stderr


def test_fit_meets_targets_or_says_that_it_cannot(tmp_path):
    free = "big_end_ring_mm,small_end_ring_mm"
    met = fea("rod", "--fit", free, "--mass-kg", 0.7, "--center-of-gravity-mm", 60, cwd=tmp_path)
    assert met.stdout.startswith("# all targets are met")
    assert met.returncode == 0
    assert all(len(digits) <= 7 for digits in re.findall(r"\d+\.\d+", met.stdout))
    (tmp_path / "fitted.toml").write_text(met.stdout)
    assert (
        fea("run", "fitted.toml", *COARSE, "--pressure", "cosine-180", "--quiet", cwd=tmp_path).returncode
        == 0
    )
    rod = figures("rod", "fitted.toml", cwd=tmp_path)
    assert rod["mass_kg"] == pytest.approx(0.7, rel=2e-3)
    assert rod["center_of_gravity_mm"][0] == pytest.approx(60, rel=2e-3)
    missed = fea("rod", "--fit", free, "--mass-kg", 0.3, "--center-of-gravity-mm", 130, cwd=tmp_path)
    assert missed.stdout.startswith("# the targets cannot be met together")
    assert missed.returncode == 5
    assert "comes closest to the targets" in missed.stderr


@pytest.mark.parametrize(
    ("rod", "code", "says"),
    [
        ('step = "none.step"', 2, "is not a file"),
        ('step = "text.step"', 3, "is not a STEP file"),
        ('step = "text.step"\nlength_mm = 3.0', 2, "cannot be combined with step"),
        ('preset = "leon-2001"\nshank_width_mm = 99.0', 2, "rod.shank_width_mm"),
        ('preset = "leon-2001"\nweb_thickness_mm = -1.0', 2, "rod.web_thickness_mm"),
        ('preset = "leon-2001"\nsmall_end_bore_mm = 500.0', 2, "reduce the bores or rings"),
    ],
)
def test_bad_rods_are_refused(rod, code, says, tmp_path):
    (tmp_path / "text.step").write_text("not a solid")
    (tmp_path / "bad.toml").write_text(f'[rod]\n{rod}\n[material]\npreset = "leon-2001"\n{ENGINE}')
    done = fea("run", "bad.toml", cwd=tmp_path)
    assert done.returncode == code, done.stderr
    assert says in done.stderr
    assert not (tmp_path / "results").exists()


def test_a_cad_file_alone_is_measured_asked_about_and_run(tmp_path):
    (tmp_path / "rod.igs").write_bytes(cad_file(replace(LEON_2001, shank_section="rectangular"), "igs"))
    measured = figures("rod", "rod.igs", "--size", "14", cwd=tmp_path)
    assert [bore["diameter_mm"] for bore in measured["bores"]] == pytest.approx([50, 24], rel=1e-4)
    assert measured["solids"][0]["role"] == "rod"
    assert "material: assumed" in measured["assumed"][0]
    asked = fea("run", "rod.igs", cwd=tmp_path)
    line, _, study = asked.stderr.partition("\n\n")
    assert asked.returncode == 2
    assert "--engine" in line
    (tmp_path / "rod.toml").write_text(study + PRESSED)
    assert figures("run", "rod.toml", *COARSE, cwd=tmp_path)["trusted"]
    flags = ("--engine", "leon-2001", "--material", "c70-2005", "--pressure", "cosine-180")
    named = figures("run", "rod.igs", *flags, *COARSE, cwd=tmp_path)
    assert named["trusted"]
    assert not any("material: assumed" in note for note in named["notes"])
    unknown = fea("run", "rod.igs", "--material", "no-such-steel", cwd=tmp_path)
    assert (unknown.returncode, "`fea materials` lists" in unknown.stderr) == (2, True)


def test_a_run_goes_to_another_program_and_its_mesh_comes_back(tmp_path):
    text = (
        '[rod]\npreset = "leon-2001"\nshank_section = "rectangular"\n[forces]\npin_N = [2e4, 0.0]\n' + PRESSED
    )
    (tmp_path / "mine.toml").write_text(text)
    first = figures("run", "mine.toml", "--size", 20, "--element", "p1", "--out", "run", cwd=tmp_path)
    done = fea("export", "run", "rod.inp", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("Wrote rod.inp\nNote: pressures and inertia are nodal forces")
    measured = figures("rod", "rod.inp", cwd=tmp_path)
    assert measured["mass_kg"] == pytest.approx(first["rod"]["mass_kg"], rel=1e-6)
    assert measured["bores"][0]["diameter_mm"] == pytest.approx(50.0, rel=1e-5)
    assert "unit" in measured
    asked = fea("run", "rod.inp", cwd=tmp_path)
    assert asked.returncode == 2
    assert f'mesh = "{tmp_path / "rod.inp"}"' in asked.stderr
    refused = fea("run", "rod.inp", "--size", 5, cwd=tmp_path)
    assert refused.returncode == 2
    assert "a mesh from a file is solved as it is" in refused.stderr
    assert fea("export", "run", "rod.step", cwd=tmp_path).returncode == 2
