"""`fea bolts`: stretch and torque by hand, the joint diagram in closed form, rows against whole runs."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from program import fea
from scipy.interpolate import PchipInterpolator

from fea.apps.bolts.preloads import PreloadedJoint
from fea.apps.bolts.run_bolts import OWN_GRADE, bolt_options, bolts
from fea.apps.result import analyse
from fea.judge.bolt_choice import choose_bolt, seats_of
from fea.study.assembly_table import threads_for_hole
from fea.study.material_table import MaterialTable
from fea.study.study import load_study
from geometry.errors import InvalidValue

pytestmark = pytest.mark.slow


SIZE = 20.0  # mm: what is compared is solved on the same mesh
# Rod, cap and two bolts: pockets, bushing and shells tell nothing of what is tested, and take the most time.
SHIPPED = load_study("leon-2001-bolted").with_rod(shank_section="rectangular", shank_width_mm=30.0)
LOOSE = {"bushing_interference_mm": None, "shell_thickness_mm": None, "shell_interference_mm": None}
BOLTED = replace(SHIPPED, assembly=replace(SHIPPED.assembly, **LOOSE))
PRESENT = choose_bolt(BOLTED.assembly, seats_of(BOLTED.rod.dimensions), None, BOLTED.material.material())


def coarse(**assembly):
    table = replace(BOLTED.assembly, **assembly)
    return replace(BOLTED, assembly=table, mesh=replace(BOLTED.mesh, size_mm=SIZE))


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    """The program's table, as JSON and as a file."""
    place = tmp_path_factory.mktemp("bolts")
    (place / "rod.toml").write_text(coarse().text(), encoding="utf-8")
    done = fea("bolts", "rod.toml", "--json", "--out", "bolts.csv", cwd=place)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), (place / "bolts.csv").read_text(encoding="utf-8")


def row_of(rows, thread, grade, *, present=False):
    (found,) = (
        row for row in rows if (row["thread"], row["grade"], row["present"]) == (thread, grade, present)
    )
    return found


def test_the_threads_of_a_hole_fill_it():
    assert [thread.name for thread in threads_for_hole(9.0)] == ["M9x1", "M9x1.25", "M8x1", "M8x1.25"]
    assert [thread.name for thread in threads_for_hole(9.6)][:2] == ["3/8-24", "3/8-16"]
    assert threads_for_hole(2.9) == []


def test_stretch_and_torque_are_those_by_hand(printed):
    rows, table = printed
    # M9x1, 40 mm of grip, 2 d + 6 mm of thread of which 0.9 d + 2 P are in the nut and beyond (ISO 4014); E
    # of steel, 0.12 of friction in thread and under a head of 13.05 mm. VDI 2230-1, sections 5.1.1 and R13.
    d, pitch, grip, preload, friction, modulus = 9.0, 1.0, 40.0, 42e3, 0.12, 205e3
    free, root = 2 * d + 6 - (0.9 * d + 2 * pitch), d - 17 / 12 * math.sqrt(3) / 2 * pitch
    own, core = math.pi / 4 * d**2, math.pi / 4 * root**2
    stretch = preload / modulus * ((0.5 * d + grip - free) / own + (free + 0.5 * d) / core)
    flanks = d - 0.75 * math.sqrt(3) / 2 * pitch
    torque = preload * (0.16 * pitch + 0.58 * flanks * friction + (1.45 * d + 9.0) / 4 * friction)
    now = row_of(rows, "M9x1", "12.9", present=True)
    assert now["stretch_mm"] == pytest.approx(stretch, rel=1e-5)
    assert now["stretch_in"] == pytest.approx(stretch / 25.4, rel=1e-5)
    assert now["torque_Nm"] == pytest.approx(torque / 1e3, rel=1e-5)
    assert table.splitlines()[0].startswith("thread,grade,present,preload_kN,torque_Nm,stretch_mm")
    assert len(table.splitlines()) == 1 + len(rows)


def test_the_present_bolt_is_judged_as_the_run_does_and_others_as_their_runs_do(printed):
    rows, _ = printed
    assert [row["present"] for row in rows].count(True) == 1
    assembly = analyse(coarse()).summary.assembly
    run, onset = assembly.bolts, assembly.joint.opens
    now = row_of(rows, "M9x1", "12.9", present=True)
    # The same contact, solved from other first guesses.
    assert now["yield_factor"] == pytest.approx(run.yield_safety_factor, rel=1e-3)
    assert now["fatigue_factor"] == pytest.approx(run.bending_fatigue_safety_factor, rel=2e-3)
    # The run multiplies the load of a case, and the table looks for the speed that makes as much of it.
    assert onset.case == "tension"
    assert now["opening_factor_low"] * 0.95 < onset.load_factor < now["opening_factor_high"] * 1.05
    for thread, grade in (("M9x1", "8.8"), ("M8x1", "10.9")):
        row = row_of(rows, thread, grade)
        free = coarse(bolt_thread=thread, bolt_grade=grade, bolt_preload_kN=None)
        other = analyse(free).summary.assembly.bolts
        assert row["preload_kN"] == pytest.approx(other.preload_N / 1e3, rel=1e-5)
        assert row["yield_factor_low"] < other.yield_safety_factor < row["yield_factor_high"]
        assert row["fatigue_factor_low"] < other.bending_fatigue_safety_factor < row["fatigue_factor_high"]


def test_more_preload_opens_the_joint_later_and_tires_the_bolt_less(printed):
    alike = [row for row in printed[0] if row["thread"] == "M9x1" and "ARP" not in row["grade"]]
    alike = sorted(alike, key=lambda row: row["preload_kN"])
    for key in ("opens_at_rpm", "opening_factor", "fatigue_factor"):
        values = [row[key] for row in alike]
        assert values == sorted(values)


def joint_of(gain, cases=1):
    """A joint under whose preloads F the present bolt gains `gain(F)`, and nothing bends."""
    forces = np.linspace(10e3, 80e3, 200)
    course = np.zeros((len(forces), cases, 2, 5))
    course[..., 0] = gain(forces)[:, None, None]
    joint = object.__new__(PreloadedJoint)
    joint.present, joint._cases, joint._bolts = PRESENT, range(cases), 2
    joint._course = lambda _bolt: PchipInterpolator(forces, course, axis=0)
    return joint


def of_thread(name):
    table = replace(BOLTED.assembly, bolt_thread=name)
    return choose_bolt(table, seats_of(BOLTED.rod.dimensions), None, BOLTED.material.material())


def test_while_the_joint_is_closed_a_bolt_gains_by_its_load_factor():
    """VDI 2230-1, R3: ΔF = δ_P/(δ_S + δ_P) F_A, of parts whose δ_P is that of the new bolt's seats."""
    other = of_thread("M8x1")
    parts = other.parts_compliance
    ratio = (PRESENT.bolt.compliance + parts) / (other.bolt.compliance + parts)
    gained = joint_of(lambda forces: np.full_like(forces, 1000.0))._gains(other)[..., 0]
    assert gained == pytest.approx(1000.0 * ratio, rel=1e-9)


def test_where_the_joint_is_apart_a_bolt_carries_the_load_however_stiff_it_is():
    gained = joint_of(lambda forces: 55e3 - forces)._gains(of_thread("M8x1"))[..., 0]
    assert PRESENT.preload + gained == pytest.approx(55e3, rel=1e-9)


def test_strengths_of_the_study_stand_as_a_grade_of_their_own():
    own = {"bolt": MaterialTable(E_GPa=205, nu=0.3, density_kg_m3=7850, yield_MPa=1200, ultimate_MPa=1400)}
    study = replace(BOLTED, part_material=own)
    setup = SimpleNamespace(bolts=())
    found, refused = bolt_options(study, setup, PRESENT)
    assert [one.grade for one in found if one.present] == [OWN_GRADE]
    assert {one.grade for one in found} > {OWN_GRADE, "12.9", "L19"}
    assert not refused


@pytest.mark.parametrize(
    ("study", "what"),
    [
        (load_study("leon-2001"), r"\[assembly\]"),
        (replace(BOLTED, engine=None), "STUDY"),
        (replace(BOLTED, speed=replace(BOLTED.speed, rpm=0.0)), r"speed\.rpm"),
    ],
)
def test_what_has_no_bolts_or_no_speed_is_refused(study, what):
    with pytest.raises(InvalidValue, match=what):
        bolts(study)


def test_the_program_refuses_in_a_line(tmp_path):
    for arguments in (("leon-2001",), ("leon-2001-bolted", "--out", "bolts.txt"), ("nothing",)):
        done = fea("bolts", *arguments, cwd=tmp_path)
        assert done.returncode == 2
        assert done.stderr.startswith("fea: ")
        assert len(done.stderr.splitlines()) <= 2
    assert not list(tmp_path.iterdir())
