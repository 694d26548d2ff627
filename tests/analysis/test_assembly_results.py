"""What bolts, joint and fits of an assembled rod do, against equilibrium and themselves."""

import math
import re
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from written_figures import buckling, result, summary

from fea import analyse, prepare
from fea.analysis.assembly_report import assembly_figures
from fea.analysis.figures import BoltsFigures, JointCaseFigures, JointFigures, OnsetFigures
from fea.analysis.survival import factors, survival
from fea.apps.report_run import prepared_again
from fea.base.choices import Symmetry
from fea.output.stored_run import StoredRun
from fea.output.terminal.assembly import assembly_lines
from fea.pins.load_limits import LARGEST, WITHIN, LoadLimits, onset
from fea.study.study import parse_study
from geometry.errors import InvalidValue
from geometry.surfaces import Surface
from loads.cases import ASSEMBLY
from loads.cases import given as pulled
from mesh.tetmesh import FACET_TURN

PRELOAD = 30e3
ROD = (
    '[rod]\npreset = "leon-2001"\nshank_section = "rectangular"\n'
    "cap_bolt_mm = 9.0\ncap_bolt_spacing_mm = 72.6\ncap_boss_length_mm = 40.0\n"
    'cap_boss_fillet_mm = 4.0\n[material]\npreset = "leon-2001"\n[mesh]\nsize_mm = 18.0\n'
)
ENGINE = (
    '[engine]\nstroke_mm = 94.0\nbore_mm = 76.0\npiston_mass_kg = 1.3345\ngas = "leon-2001"\n'
    "[speed]\nrpm = 6000\n"
)
ASSEMBLED = "[assembly]\nbolt_preload_kN = 30.0\nbolt_grade = 10.9\n"


def read(text, rod=ROD):
    return parse_study(rod + text, "assembled", Path.cwd())


@pytest.fixture(scope="module")
def pulled_rod():
    """A rod that is pulled at rest: what acts on its cap is bolts, joint and pin alone."""
    return analyse(read("[forces]\npin_N = [30e3, 0.0]\n" + ASSEMBLED))


@pytest.fixture(scope="module")
def rod():
    return prepare(read("[forces]\npin_N = [40e3, 0.0]\n" + ASSEMBLED))


def on_faces(mesh, facets, values):
    """Means (n,) of values at the vertices of facets, and area vectors (n, 3)."""
    a, b, c = mesh.points[facets[:, :3]].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a) / 2
    return values[facets[:, :3]].mean(axis=1), normal


def test_nothing_but_bolts_acts_on_the_joint_of_an_assembled_rod(pulled_rod):
    state = pulled_rod.cases[ASSEMBLY].assembly
    assert [bolt.force for bolt in state.bolts] == pytest.approx([PRELOAD, PRELOAD], rel=1e-12)
    assert state.joint.force == pytest.approx(2 * PRELOAD, rel=1e-9)
    assert state.joint.open_share == state.joint.opening == state.joint.slip == 0
    assert state.joint.shear < 1e-9 * PRELOAD
    assert pulled_rod.trusted


def test_an_assembled_rod_is_not_prepared_again_from_the_mesh_of_its_run(pulled_rod):
    study = read("[forces]\npin_N = [30e3, 0.0]\n" + ASSEMBLED)
    with pytest.raises(InvalidValue, match=r"separate parts.*Export its results"):
        prepared_again(StoredRun(Path("run"), study, pulled_rod.summary, {}))


def test_the_cap_is_in_equilibrium_across_and_along_an_oblique_joint():
    rod = prepare(read("[forces]\npin_N = [30e3, 0.0]\n" + ASSEMBLED + "split = 12.0\n"))
    contact, cell = rod.pins.assembly, rod.mesh.cell
    (found,) = rod.pins.states(pulled(30e3)[None])
    bore = contact.problem.own(1)
    forces = (contact.problem.forces[:, bore] @ found.values[bore]).reshape(-1, 3)
    pin = 2 * forces[np.unique(cell.tets[cell.part == 1]), :2].sum(axis=0)
    assert not contact.problem.cut_y
    normal = np.array([math.cos(math.radians(12)), math.sin(math.radians(12))])
    state = contact.sums(found)
    assert state.bolt_force - state.joint.force == pytest.approx(-(pin @ normal), rel=1e-6)
    assert state.joint.shear == pytest.approx(abs(pin @ [-normal[1], normal[0]]), rel=1e-6)
    assert state.joint.slip_safety == pytest.approx(state.joint.friction / state.joint.shear)


def test_the_load_factor_divides_the_load_between_bolts_and_joint(pulled_rod):
    figures = pulled_rod.summary.assembly
    joint, bolts = figures.joint.by_case["given"], figures.bolts.by_case["given"]
    gained = sum(bolt.change_N for bolt in bolts)
    shared = np.mean([bolt.load_factor for bolt in bolts])
    assert shared * joint.separating_N == pytest.approx(gained, rel=1e-9)
    assert 0 < shared < 1
    lost = figures.joint.by_case[ASSEMBLY].clamp_force_N - joint.clamp_force_N
    assert gained + lost == pytest.approx(joint.separating_N)


def test_bores_are_round_as_assembled_but_not_as_made(pulled_rod):
    case = pulled_rod.cases[ASSEMBLY]
    assert np.abs(case.distortion).max() < 1e-12
    assert np.abs(case.displacement).max() > 1e-3
    ovality = pulled_rod.summary.assembly.ovality["big_end_bore"]
    assert ovality[ASSEMBLY].ovality_mm < 1e-12
    assert ovality["given"].ovality_mm > 0.01


def test_pressures_and_gaps_are_written_on_both_sides(pulled_rod, tmp_path):
    pulled_rod.write(tmp_path / "run")
    written = meshio.read(tmp_path / "run" / "given.vtu")
    assert pulled_rod.summary.assembly.parts == ("rod", "cap")
    assert set(np.unique(written.cell_data["part"][0])) == {0, 1}
    pressure, gap = written.point_data["contact_pressure"], written.point_data["gap"]
    mesh, joint = pulled_rod.mesh, pulled_rod.cases["given"].assembly.joint
    sums = []
    for side in (Surface.JOINT, Surface.JOINT_CAP):
        values, area = on_faces(mesh, mesh.facets[side], pressure)
        sums.append(values @ np.linalg.norm(area, axis=1))
        assert gap[mesh.facets[side][:, :3]].max() == pytest.approx(joint.opening, rel=1e-6)
    moved = written.point_data["displacement"][:, 0]
    one, other = mesh.facets[Surface.JOINT], mesh.facets[Surface.JOINT_CAP][:, FACET_TURN[6]]
    assert (moved[one] - moved[other]).max() == pytest.approx(joint.opening, rel=0.3)
    assert sums == pytest.approx([joint.force, joint.force], rel=0.02)
    vertices = np.unique(mesh.facets[Surface.JOINT][:, :3])
    rim = np.intersect1d(vertices, mesh.facets[Surface.BIG_END_BORE])
    inner = np.setdiff1d(vertices, rim)
    assert not pressure[inner[gap[inner] > 0]].any()
    assert (tmp_path / "run" / "joint.png").stat().st_size < 300e3


def test_half_a_rod_says_the_same_as_a_quarter():
    found = []
    for symmetry in (Symmetry.QUARTER, Symmetry.HALF):
        study = read(ENGINE + ASSEMBLED)
        rod = prepare(replace(study, analysis=replace(study.analysis, symmetry=symmetry)))
        load = next(case for case in rod.loading.at(rod.mass, 6000.0).cases if case.name == "compression")
        found.append(rod.pins.state_under(load))
    one, other = found
    assert one.joint.shear > 100
    for name in ("force", "shear", "largest", "slipping_share", "slip", "area"):
        assert getattr(one.joint, name) == pytest.approx(getattr(other.joint, name), rel=1e-6), name
    assert [bolt.at[1] for bolt in one.bolts] == pytest.approx([36.3, -36.3])
    of_place = [{round(bolt.at[1], 6): bolt.force for bolt in state.bolts} for state in found]
    assert of_place[0] == pytest.approx(of_place[1], rel=1e-8)


def test_a_joint_opens_and_comes_apart_where_it_is_said_to(rod):
    pins, case = rod.pins, pulled(40e3)
    limits = LoadLimits(pins, case, pins.state_under(case))

    def joint(factor):
        return pins.state_under(case, factor).joint

    opens, separates = limits.opens(), limits.separates()
    assert 0 < opens < 1 < separates
    assert joint(opens * 0.95).edge_pressure > 0 == joint(opens * 1.05).edge_pressure
    assert joint(separates * 0.95).force > 0
    assert joint(separates * 1.05).force == pytest.approx(0, abs=1e-3 * PRELOAD)


@given(st.floats(0.05, 0.9 * LARGEST), st.floats(0.1, 10))
def test_the_onset_of_what_falls_to_zero(zero, slope):
    assert onset(lambda factor: slope * (zero - factor)) == pytest.approx(zero, rel=2 * WITHIN)
    lost = -0.1 * slope
    found = onset(lambda factor: slope * (zero - factor) if factor < zero else lost)
    assert found == pytest.approx(zero, rel=2 * WITHIN)


def test_nothing_begins_where_nothing_is_left_or_everything_holds():
    assert onset(lambda factor: -factor) == 0.0
    assert onset(lambda _: 1.0) is None


def assembly(**bolts):
    usual = {"yield_safety_factor": 2.0, "fatigue_safety_factor": 3.0, "max_case": "tension"}
    known = dict.fromkeys(BoltsFigures.__dataclass_fields__, 1.0) | usual | bolts
    case = JointCaseFigures(
        **dict.fromkeys(JointCaseFigures.__dataclass_fields__, 1.0) | {"slip_reserve": 4.0}
    )
    joint = JointFigures(
        friction=0.15,
        separates=OnsetFigures(case="tension", load_factor=1.5, largest_factor=LARGEST),
        by_case={"tension": case},
    )
    return type("Figures", (), {"bolts": BoltsFigures(**known), "joint": joint})


@pytest.mark.parametrize(
    ("figures", "said"),
    [
        (assembly(), r"survives, safety factor 1\.50 \(tension\) against separation of the joint"),
        (assembly(fatigue_safety_factor=0.8), r"the bolts fail by fatigue, safety factor 0\.80"),
        (assembly(yield_safety_factor=0.9), r"the bolts yield, safety factor 0\.90 \(tension\)"),
    ],
)
def test_bolts_and_joint_count_for_survival(figures, said):
    found = factors({"tension": result(min_safety_factor=9.0)}, buckling(), None, figures)
    assert re.match(said, survival(found).text)


def test_a_joint_that_slides_does_not_survive():
    figures = assembly()
    case = replace(figures.joint.by_case["tension"], slip_reserve=1.0 + 1e-9)
    figures.joint = replace(figures.joint, by_case={"tension": case})
    assert survival(factors({"tension": result()}, buckling(), None, figures)).text.startswith(
        "the joint slips"
    )


def test_a_reader_learns_what_the_bolts_and_the_joint_do(pulled_rod):
    lines = "\n".join(assembly_lines(pulled_rod.summary.assembly))
    assert re.search(
        r"Bolts, M9x1: at most 3\d\.\d kN \(given\), load factor Φ 0\.\d+ \(VDI 2230: 0\.2", lines
    )
    assert "Joint: opens at the bore at" in lines
    assert assembly_lines(None) == []
    assert assembly_figures(prepare(read("[forces]\npin_N = [1e3, 0.0]\n")), {}) is None
    assert summary().assembly is None
