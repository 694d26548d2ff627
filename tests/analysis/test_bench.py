"""Fatigue tests between two forces, against the closed form of a pulled section."""

from dataclasses import replace

import numpy as np
import pytest

from fea import load_study
from fea.analysis.bench import bench_figures
from fea.analysis.pipeline import prepare, refined_rod, solve_speed
from fea.analysis.result import run_result
from fea.base.choices import Finish
from fea.judge.safety_factor import CycleLife
from fea.machine.clock import Clock
from fea.output import json_file
from fea.output.json_file import as_dict
from fea.output.life_statements import fatigue_test
from fea.output.statements import full_statements
from fea.study.material_table import MaterialTable
from fea.study.option_tables import ForcesTable, MeshTable
from fea.study.study import parse_study
from geometry.errors import InvalidValue

LEON = load_study("leon-2001").with_(engine=None, speed=None, forces={"pin_N": [1.0, 0.0]})
# Basquin's line 1000 MPa (2 N)^−0.1 of polished specimens ends at 200 MPa, 4.9e6 cycles.
COEFFICIENT, EXPONENT, ULTIMATE, ENDURANCE = 1000.0, -0.1, 900.0, 200.0
STEEL = MaterialTable(
    E_GPa=207.0,
    nu=0.3,
    density_kg_m3=7800.0,
    yield_MPa=700.0,
    ultimate_MPa=ULTIMATE,
    endurance_MPa=ENDURANCE,
    surface=Finish.POLISHED,
    fatigue_strength_coefficient_MPa=COEFFICIENT,
    fatigue_strength_exponent=EXPONENT,
)


def rig_of(axial, ratio, material=STEEL):
    analysis = replace(LEON.analysis, pressure="cosine-180")
    forces = ForcesTable((axial, 0.0), ratio)
    mesh = MeshTable(size_mm=10.0)
    return replace(LEON, forces=forces, mesh=mesh, analysis=analysis, material=material)


@pytest.fixture(scope="module")
def rod():
    return prepare(rig_of(40e3, -1.25))


def of_middle(rod, axial, ratio, material=STEEL):
    """The figures of the middle of the shank, where the stress of a section is even, with its area."""
    study = rig_of(axial, ratio, material)
    rod = prepare(study, mesh=rod.mesh)
    result, points = solve_speed(rod, None), rod.mesh.whole.points
    elsewhere = (np.abs(points[:, 0] - 72.0) > 4) | (np.abs(points[:, 1]) > 4)
    cases = {
        name: replace(case, error=replace(case.error, masked=elsewhere))
        for name, case in result.cases.items()
    }
    found = bench_figures(rod, replace(result, cases=cases))
    stations = np.linspace(0.0, rod.mesh.bores.rod_length, len(rod.shank[0]))
    return found, np.interp(found.at_mm[0], stations, [section.area for section in rod.shank[0]])


# Pull is more than push, the reverse by a force that compresses, pull alone, and a pull that never ends.
@pytest.mark.parametrize(
    ("axial", "ratio", "largest"),
    [(34e3, -0.5, 34e3), (-30e3, -1.25, 24e3), (40e3, 0.0, 40e3), (44e3, 0.2, 44e3)],
)
def test_a_section_fails_after_the_cycles_of_its_line(rod, axial, ratio, largest):
    found, area = of_middle(rod, axial, ratio)
    assert found.forces_N == pytest.approx((largest, ratio * largest))
    # The stress of a section midway along a shank, seven widths from either eye, is even within 3 %.
    amplitude, mean = largest * (1 - ratio) / 2 / area, largest * (1 + ratio) / 2 / area
    assert found.amplitude_MPa == pytest.approx(amplitude, rel=0.03)
    assert found.mean_MPa == pytest.approx(mean, rel=0.03)
    # From there on the formulas are exact: Goodman's line, no benefit of compression, and Basquin's line.
    tension = max(found.mean_MPa, 0.0) / ULTIMATE
    assert 1 / found.safety_factor == pytest.approx(found.amplitude_MPa / ENDURANCE + tension)
    reversed_ = found.amplitude_MPa / (1 - tension)
    assert 1e4 < found.life.cycles == pytest.approx((reversed_ / COEFFICIENT) ** (1 / EXPONENT) / 2, rel=1e-6)
    # Strengths that are lower by 16 %: fewer cycles by the tenth power of that.
    assert found.life.low == pytest.approx(
        found.life.cycles * (1 - found.life.band_percent / 100) ** 10, rel=1e-6
    )
    assert not found.life.assumed


def test_a_small_force_never_breaks_a_steel_and_a_large_one_within_cycles_of_strain(rod):
    found, _ = of_middle(rod, 10e3, -1.0)
    assert found.life.cycles == np.inf
    assert found.life.unlimited
    assert found.safety_factor > 1
    found, _ = of_middle(rod, 100e3, -1.0)
    assert found.life.by_strain
    assert found.life.cycles <= 1e4
    without_line = replace(STEEL, endurance_MPa=None, E_GPa=70.0, density_kg_m3=2700.0)
    aluminium = replace(
        without_line, fatigue_strength_coefficient_MPa=None, fatigue_strength_exponent=None, surface=None
    )
    rod = prepare(rig_of(40e3, -1.25, aluminium), mesh=rod.mesh)
    assert bench_figures(rod, solve_speed(rod, None)) is None


def test_a_test_is_judged_by_its_factor_and_says_its_cycles(rod):
    study = rig_of(12e3, -1.25)
    adapted = refined_rod(study, (None,), Clock(), None, rod.mesh)
    found = run_result(study, adapted, adapted.at(None)).summary
    assert set(found.results) == {"upper", "lower"}
    assert found.loads["lower"].pin_axial_N == pytest.approx(-15e3)
    factor = found.bench.safety_factor
    assert found.survival.mode == "fatigue"
    assert found.survival.safety_factor == factor < 1.3
    assert "over-rev" not in found.survival.text
    (line,) = fatigue_test(found)
    assert line in set(full_statements(found, "results"))
    assert line.startswith("Fatigue test between -15 kN and 12 kN (R = -1.25): factor ")
    assert "(S–N line, strength ± 16 %)" in line
    never = replace(found.bench.life, cycles=np.inf, low=np.inf, high=np.inf)
    assert as_dict(never)["cycles"] is None
    assert json_file._read(CycleLife, as_dict(never)) == never
    (line,) = fatigue_test(replace(found, bench=replace(found.bench, life=never)))
    assert "; lasts unlimited cycles (S–N" in line
    (line,) = fatigue_test(replace(found, bench=replace(found.bench, life=None)))
    assert line.endswith("no S–N line is known or can be assumed.")


RIG = "[rod]\npreset = 'leon-2001'\n[forces]\npin_N = [{}, {}]\nratio = {}\n"


@pytest.mark.parametrize(
    ("forces", "more", "said"),
    [
        ((1e3, 0, 1.5), "", r"forces\.ratio = 1\.5: must be below 1"),
        ((1e3, 0, 1.0), "", "equal ones make no cycle"),
        ((-1e3, 0, 0.0), "", r"must be below 0 where pin_N \(-1000 N\) compresses"),
        ((0, 1e3, -1.0), "", "along the rod alone"),
        ((1e3, 0, -1.0), "[speed]\nrpm = 3000", r"speed\.rpm.*has no speed"),
        ((1e3, 0, -1.0), "[duty]\nrpm = [3000]\nhours = [1]", r"duty\.rpm.*\[forces\]"),
    ],
)
def test_levels_that_make_no_test_are_refused(tmp_path, forces, more, said):
    with pytest.raises(InvalidValue, match=said):
        parse_study(RIG.format(*forces) + more, "rig", tmp_path)


def test_a_test_is_written_and_read_again(tmp_path):
    study = parse_study(RIG.format(-50e3, 0, -1.25), "rig", tmp_path)
    assert study.forces.levels() == (40e3, -50e3)
    assert parse_study(study.text(), "rig", tmp_path).forces == study.forces
