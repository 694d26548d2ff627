"""What bolts, joint and fits of an assembled rod do, against equilibrium and themselves."""

import math
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
import pyvista as pv
from facets import WrittenSeats, integral
from hypothesis import given
from hypothesis import strategies as st
from vtkmodules.vtkFiltersCore import vtkArrayCalculator
from written_figures import buckling, result, summary

from fea import prepare
from fea.analysis.assembly_report import LARGEST, WITHIN, Onsets, assembly_figures, onset, touch_notes
from fea.analysis.figures import LiningFigures
from fea.analysis.pipeline import RefinedRod, solve_speed
from fea.analysis.result import run_result
from fea.analysis.summary_figures import BoltsFigures, JointCaseFigures, JointFigures, OnsetFigures
from fea.analysis.survival import factors, factors_of_assembly, survival
from fea.apps.export_run import prepared_again
from fea.apps.result import analyse
from fea.apps.studio.figures import figures as shown_figures
from fea.base.choices import Symmetry
from fea.judge.safety_factor import SafetyFactor
from fea.output.assembly_statements import assembly_lines, linings
from fea.output.json_file import read_summary
from fea.output.stored_run import StoredRun
from fea.output.tables import assembly_tables
from fea.study.study import parse_study
from geometry.errors import InvalidValue
from geometry.surfaces import Surface
from loads.instants import ASSEMBLY
from loads.instants import given as pulled
from mesh.tetmesh import FACET_TURN

pytestmark = [pytest.mark.usefixtures("coarse_bores"), pytest.mark.slow]

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
BUSHED = ROD.replace("[material]", "bushing_mm = 2.0\n[material]")
ASSEMBLED = "[assembly]\nbolt_preload_kN = 30.0\nbolt_grade = 10.9\n"


def read(text, rod=ROD):
    return parse_study(rod + text, "assembled", Path.cwd())


@pytest.fixture(scope="module")
def pulled_rod():
    """A rod that is pulled at rest: what acts on its cap is bolts, joint and pin alone."""
    fits = "bushing_interference_mm = 0.02\nshell_thickness_mm = 2.0\n"
    return analyse(read("[forces]\npin_N = [30e3, 0.0]\n" + ASSEMBLED + fits, BUSHED))


@pytest.fixture(scope="module")
def folder(pulled_rod, tmp_path_factory):
    written = tmp_path_factory.mktemp("pulled") / "run"
    pulled_rod.write(written)
    return written


@pytest.fixture(scope="module")
def rod():
    return prepare(read("[forces]\npin_N = [40e3, 0.0]\n" + ASSEMBLED))


def test_nothing_but_bolts_acts_on_the_joint_of_an_assembled_rod(pulled_rod):
    state = pulled_rod.cases[ASSEMBLY].assembly
    assert [bolt.force for bolt in state.bolts] == pytest.approx([PRELOAD, PRELOAD], rel=1e-12)
    assert state.joint.force == pytest.approx(2 * PRELOAD, rel=1e-9)
    assert state.joint.open_share < 0.01
    assert state.joint.slip == 0
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
    borne = found.values[contact.assembled.stops] @ [
        way * bolt.area for way, bolt in zip([1, -1, 1, -1], contact.problem.bolts[2:], strict=True)
    ]
    across = pin @ [-normal[1], normal[0]]
    assert borne
    assert state.joint.shear in (pytest.approx(abs(across + way * borne), rel=1e-6) for way in (1, -1))
    assert state.joint.slip_reserve == pytest.approx(state.joint.friction / state.joint.shear)


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


def test_pressures_and_gaps_are_written_on_both_sides(pulled_rod, folder):
    written = meshio.read(folder / "given.vtu")
    assert pulled_rod.summary.assembly.parts == ("rod", "cap", "bushing", "upper shell", "lower shell")
    assert set(np.unique(written.cell_data["part"][0])) == set(range(5))
    pressure, gap = written.point_data["contact_pressure"], written.point_data["gap"]
    mesh, joint = pulled_rod.mesh, pulled_rod.cases["given"].assembly.joint
    sums = []
    for side in (Surface.JOINT, Surface.JOINT_CAP):
        sums.append(integral(mesh.points, mesh.facets[side], pressure))
        assert gap[mesh.facets[side][:, :3]].max() == pytest.approx(joint.opening, rel=2.5e-4)
    moved = written.point_data["displacement"][:, 0]
    one, other = mesh.facets[Surface.JOINT], mesh.facets[Surface.JOINT_CAP][:, FACET_TURN[6]]
    assert (moved[one] - moved[other]).max() == pytest.approx(joint.opening, rel=0.3)
    assert sums == pytest.approx([joint.force, joint.force], rel=1e-4)
    vertices = np.unique(mesh.facets[Surface.JOINT][:, :3])
    assert not pressure[vertices[gap[vertices] > 0]].any()
    assert (folder / "joint.png").stat().st_size < 300e3


def test_the_largest_stress_that_is_not_masked_is_the_one_reported(folder):
    """As the two clicks in ParaView of docs/do/paraview.md: its Calculator, and the range of the result."""
    results = read_summary(folder).results
    for name, figures in results.items():
        grid = pv.read(folder / f"{name}.vtu")
        clicked = vtkArrayCalculator()
        clicked.SetInputData(grid)
        for array in ("von_mises", "masked"):
            clicked.AddScalarArrayName(array)
        clicked.SetFunction("von_mises*(1-masked)")
        clicked.Update()
        _, largest = clicked.GetOutput().GetPointData().GetArray("resultArray").GetRange()
        assert largest == pytest.approx(figures.max_von_mises_MPa, rel=1e-6)
        assert grid["von_mises"].max() == pytest.approx(figures.unmasked_max_von_mises_MPa, rel=1e-6)
    assert any(each.unmasked_max_von_mises_MPa > 1.1 * each.max_von_mises_MPa for each in results.values())


def test_what_presses_on_each_seat_integrates_to_its_force(folder):
    written, shown = WrittenSeats(folder / "contact.vtu"), pv.read(folder / "contact.vtu")
    figures = read_summary(folder)
    bolts, fits = figures.assembly.bolts, figures.assembly.fits
    for name, joint in figures.assembly.joint.by_case.items():
        bolt_force, load = sum(bolt.force_N for bolt in bolts.by_case[name]), figures.loads[name]
        seats = {"joint": joint.clamp_force_N, "bolt_head": bolt_force, "bolt_thread": bolt_force}
        for seat, fit in (("bushing_seat", fits["bushing"]), ("shell_seat", fits["shells"])):
            seats[seat] = fit.by_case[name].mean_pressure_MPa * written.integral(seat)
        assert set(written.names) == {*seats, "small_end_bore", "big_end_bore"}
        pressure = f"pressure_{name}"
        for seat, force in seats.items():
            # summary.json holds six digits.
            assert written.integral(seat, pressure) == pytest.approx(force, rel=1e-5), seat
            # VTK divides a facet into four plane triangles: an annulus under a bolt gets 48 straight sides.
            drawn = shown.threshold(0.5, scalars=seat).integrate_data()
            assert drawn[pressure][0] == pytest.approx(force, rel=1e-2), seat
        for seat, force in (("small_end_bore", load.pin_axial_N), ("big_end_bore", -load.crank_axial_N)):
            # Between the nodes of a facet, the direction of the traction is quadratic instead of radial.
            along = written.integral(seat, f"traction_{name}")[0]
            assert along == pytest.approx(force, rel=1e-3, abs=1e-9 * PRELOAD), seat


def test_half_a_rod_says_the_same_as_a_quarter():
    found = []
    for symmetry in (Symmetry.QUARTER, Symmetry.HALF):
        study = read(ENGINE + ASSEMBLED)
        rod = prepare(replace(study, analysis=replace(study.analysis, symmetry=symmetry)))
        load = next(case for case in rod.loading.at(rod.mass, 6000.0).cases if case.name == "compression")
        found.append(rod.pins.state_under(load))
    one, other = found
    assert one.joint.shear > 100
    for name in ("force", "shear", "max_pressure", "slipping_share", "slip", "area"):
        assert getattr(one.joint, name) == pytest.approx(getattr(other.joint, name), rel=1e-6), name
    assert [bolt.at[1] for bolt in one.bolts] == pytest.approx([36.3, -36.3])
    of_place = [{round(bolt.at[1], 6): bolt.force for bolt in state.bolts} for state in found]
    assert of_place[0] == pytest.approx(of_place[1], rel=1e-8)


def test_a_joint_opens_and_comes_apart_where_it_is_said_to(rod):
    pins, case = rod.pins, pulled(40e3)
    states = {ASSEMBLY: pins.state_under(case, 0.0), case.name: pins.state_under(case)}
    onsets = Onsets(pins, {case.name: case}, states)

    def joint(factor):
        return pins.state_under(case, factor).joint

    opens, separates = onsets.opens().load_factor, onsets.separates().load_factor
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
    usual = {"yield_safety_factor": 2.0, "bending_fatigue_safety_factor": 3.0, "max_case": "tension"}
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
        (assembly(bending_fatigue_safety_factor=0.8), r"the bolts fail by fatigue, safety factor 0\.80"),
        (assembly(yield_safety_factor=0.9), r"the bolts yield, safety factor 0\.90 \(tension\)"),
    ],
)
def test_bolts_and_joint_count_for_survival(figures, said):
    found = factors({"tension": result(min_safety_factor=9.0)}, buckling(), None, figures)
    assert re.match(said, survival([*found, SafetyFactor(9.0, mode="fatigue")]).text)


@pytest.mark.parametrize(
    ("bolts", "kinds"),
    [
        ({"seat_lift_ratio": 0.9, "shear_N": 0.0}, []),
        ({"seat_lift_ratio": 1.3, "shear_N": 0.0}, ["warning"]),
        ({"seat_lift_ratio": 1.3, "shear_N": 1200.0}, ["warning", "remark"]),
        ({"seat_lift_ratio": 0.9, "shear_N": 1200.0}, ["remark"]),
    ],
)
def test_a_seat_that_lifts_and_a_bolt_that_bears_on_its_hole_are_said(bolts, kinds):
    found = list(touch_notes(assembly(**bolts)))
    assert [note.kind for note in found] == kinds
    text = " ".join(note.text for note in found)
    assert ("1.30 times" in text) == (bolts["seat_lift_ratio"] > 1)
    assert ("by up to 1.2 kN" in text) == (bolts["shear_N"] > 0)


def test_a_joint_that_slides_does_not_survive():
    figures = assembly()
    case = replace(figures.joint.by_case["tension"], slip_reserve=1.0 + 1e-9)
    figures.joint = replace(figures.joint, by_case={"tension": case})
    assert survival(factors({"tension": result()}, buckling(), None, figures)).text.startswith(
        "the joint slips"
    )
    figures.bolts = replace(figures.bolts, hole_play_mm=0.0)  # they bear what friction does not
    assert survival(factors({"tension": result()}, buckling(), None, figures)).answer == "does not yield"


def test_bushing_and_shells_have_a_line_of_their_own():
    bushing, upper, lower = (
        LiningFigures(safety_factor=f, specific_load_MPa=p)
        for f, p in ((0.9, 94.0), (1.4, 40.0), (1.2, 40.0))
    )
    cases = {"gas": result(linings={"bushing": bushing, "upper shell": upper, "lower shell": lower})}
    cases |= {"tension": result(linings={"bushing": replace(bushing, safety_factor=1.1)})}
    (said,) = linings(SimpleNamespace(results=cases))
    assert "bushing 0.90 (gas; 94 MPa over its bore); shell 1.20 (gas; 40 MPa over its bore)" in said
    assert list(linings(SimpleNamespace(results={"gas": result()}))) == []


def test_the_studio_counts_bolts_and_joint_as_a_run_does(rod):
    result = solve_speed(rod, None)
    run, shown = run_result(rod.study, RefinedRod(rod), result).summary, shown_figures(rod, result)
    worst = min(factors_of_assembly(run.assembly), key=lambda one: one.low)
    assert (shown.bolts.factor, shown.bolts.where) == (worst, worst.mode)
    every = factors(run.results, run.buckling, run.envelope, run.assembly)
    assert getattr(shown, shown.governs).factor == pytest.approx(min(every))


def test_a_reader_learns_what_the_bolts_and_the_joint_do(pulled_rod):
    figures = pulled_rod.summary.assembly
    opens = OnsetFigures(case="given", load_factor=0.5, largest_factor=LARGEST)
    figures = replace(figures, joint=replace(figures.joint, opens=opens))
    lines = "\n".join(assembly_lines(figures))
    assert re.search(r"Bolts, M9x1: 3\d\.\d kN \(given\), bending", lines)
    rows = dict(next(assembly_tables(summary(assembly=figures))).rows)
    assert 0 < float(rows["load factor Φ of the bolt with the largest force"]) < 1
    assert 0 < figures.bolts.seat_lift_ratio < 1
    assert figures.bolts.hole_play_mm == 0.0 <= figures.bolts.shear_N
    assert figures.bolts.shear_MPa == pytest.approx(figures.bolts.shear_N / 51.04, rel=0.02)
    assert rows["load factor Φ of a central load"].startswith("0.2")
    assert "Joint: opens at the bore at" in lines
    assert assembly_figures(prepare(read("[forces]\npin_N = [1e3, 0.0]\n")), {}) is None
    assert summary().assembly is None
