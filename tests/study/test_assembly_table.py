"""[assembly] of a study: what is read, completed, written again, and refused."""

import dataclasses
import math
import re
import tomllib
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from fea.analysis.assembling import AssemblySetup
from fea.base.choices import BoltGrade, ThreadRolled
from fea.base.note import NoteKind
from fea.judge.bolt_choice import BoltSeats, choose_bolt, seats_of
from fea.study.assembly_table import AssemblyTable
from fea.study.documents import study_schema, template
from fea.study.flags import Flags
from fea.study.material_table import MaterialTable
from fea.study.study import load_study, parse_study
from geometry.errors import InvalidValue
from geometry.rod import proportioned

ROD = (
    '[rod]\npreset = "leon-2001"\nbushing_mm = 1.5\ncap_bolt_mm = 9.0\ncap_bolt_spacing_mm = 72.0\n'
    "cap_boss_length_mm = 40.0\ncap_boss_fillet_mm = 4.0\n"
)
SEATS = BoltSeats(hole=9.0, length=40.0, cap=20.0, room=8.0, outer=18.0)


def read(text, rod=ROD):
    return parse_study(rod + text, "test", Path.cwd())


def assembling(text):
    found = AssemblySetup.of(read(text))
    assert found is not None
    return found


def bolt(text="", seats=SEATS):
    study = read(f"[assembly]\n{text}")
    own = study.part_material.get("bolt")
    return choose_bolt(study.assembly, seats, own, study.material.material())


def test_an_assembly_puts_the_pins_in_contact_unless_it_is_told_otherwise():
    assert read("[assembly]\n").analysis.in_contact
    assert read("[assembly]\n[analysis]\ncycle = true\n").analysis.in_contact
    with pytest.raises(InvalidValue, match=r'analysis\.pressure.*\[assembly\].*pressure = "contact"'):
        read('[assembly]\n[analysis]\npressure = "cosine-180"\n')
    with pytest.raises(InvalidValue, match=r"analysis\.pressure"):
        Flags(pressure="webster").applied(read("[assembly]\n"))


def test_a_resolved_study_runs_again_and_gives_the_same():
    text = "[assembly]\nsplit = 0.0\nbolt_grade = 12.9\nbolt_torque_Nm = 55.0\n[material.bolt]\n"
    text += "preset = 'bolt-12.9'\n"
    study = read(text)
    again = parse_study(study.text(), "test", Path.cwd())
    assert again == dataclasses.replace(study, part_material=again.part_material, material=again.material)
    assert again.text() == study.text()
    assert "assembly" in tomllib.loads(study.text())
    assert "assembly" not in tomllib.loads(load_study().text())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "bolt_preload_kN = 3.0\nbolt_torque_Nm = 3.0",
            r"bolt_preload_kN = 3: cannot be combined with bolt_torque",
        ),
        ("bolt_preload_kN = 0.0", "must be positive"),
        ("bolt_nut_mm = 13.0\nbolt_engaged_mm = 9.0", "cannot be combined with bolt_engaged_mm"),
        ("thread_friction = 0.0", r"must lie between 0\.01 and 1"),
        ("joint_friction = -0.1", "must lie between 0 and 1"),
        ("temperature_C = 1200.0", "must lie between -60 and 300"),
        ("split = 80.0", "must lie between -75 and 75"),
        ('split = "cracked"', "Choose from straight or give a number"),
        ("bolt_grade = 11.9", r"is not a grade of bolts.*\[material\.bolt\]"),
        ('bolt_thread = "3/8"', "does not say how many threads an inch has"),
        ("bolt_angle_deg = 60.0", "needs bolt_torque_Nm, the snug torque"),
        ("shell_interference_mm = 0.03", "needs shell_thickness_mm"),
        ("bolt_tightening_factor = 0.9", "must lie between 1 and 4"),
        ("bushing_interference_mm = -0.01", "must not be negative"),
    ],
)
def test_values_that_no_assembly_has_are_refused(text, said):
    with pytest.raises(InvalidValue, match=said):
        read(f"[assembly]\n{text}\n")


def test_a_rod_without_bolt_holes_bushing_or_parts_is_refused():
    plain = '[rod]\npreset = "leon-2001"\n'
    with pytest.raises(InvalidValue, match=r"rod\.cap_bolt_mm is missing.*cap_bolt_spacing_mm"):
        read("[assembly]\n", plain)
    with pytest.raises(InvalidValue, match=r"bushing_interference_mm.*rod\.bushing_mm"):
        read("[assembly]\nbushing_interference_mm = 0.03\n", ROD.replace("bushing_mm = 1.5\n", ""))


def test_materials_of_the_parts_are_their_own_or_usual_ones():
    study = read("[assembly]\n[material.shell]\npreset = 'leon-2001'\n")
    parts = ("rod", "cap", "bushing", "upper shell", "lower shell")
    rod, cap, bushing, *shells = study.materials(parts)
    assert rod == cap == study.material.material()
    assert bushing == dataclasses.replace(MaterialTable(preset="cusn8p").material(), lining=True)
    assert shells == [dataclasses.replace(MaterialTable(preset="leon-2001").material(), lining=True)] * 2
    assert read("").materials(("rod", "bushing"))[1] == study.material.material()
    with pytest.raises(InvalidValue, match=r"\[material\.shell\] does not name a part"):
        study.materials(("rod", "cap"))


def test_what_is_left_out_is_assumed_and_said():
    found = bolt()
    assert (found.bolt.thread.name, found.bolt.rolled) == ("M9x1", ThreadRolled.BEFORE)
    assert found.bolt.grip == SEATS.length
    # 90 % of the yield strength of class 10.9, by hand: 0.9 · 940 · 51.04 / √(1 + 3 · 0.2746²).
    assert found.preload == pytest.approx(39.0e3, rel=1e-3)
    assumed = [note for note in found.notes if note.kind is NoteKind.ASSUMPTION]
    said = " ".join(map(str, assumed))
    for key in ("thread", "grip_mm", "head_mm", "nut_mm", "shank_mm", "grade", "preload_kN", "thread_rolled"):
        assert f"bolt_{key}" in said
    assert all(note.text.startswith("assumed ") for note in assumed)
    others = [str(note) for note in found.notes if note not in assumed]
    assert all("assumed" not in text for text in others)
    assert "90% of the yield strength" in others[0]
    assert any("embedding is not deducted" in str(note) for note in found.notes)


def test_torque_stretch_and_preload_agree():
    by_force = bolt("bolt_preload_kN = 30.0")
    by_torque = bolt(f"bolt_torque_Nm = {by_force.bolt.lever * 30.0!r}")
    by_stretch = bolt(f"bolt_stretch_mm = {30e3 * by_force.bolt.stretch_compliance!r}")
    assert by_torque.preload == pytest.approx(30e3, rel=1e-12)
    assert by_stretch.preload == pytest.approx(30e3, rel=1e-12)
    assert "by a stretch of" in " ".join(map(str, by_stretch.notes))


def test_strengths_are_those_of_the_material_or_of_the_grade():
    assert bolt('bolt_grade = "12.9"').bolt.strength.yield_strength == 1100.0
    own = "[material.bolt]\nyield_MPa = 1300.0\nultimate_MPa = 1450.0\n"
    found = bolt("bolt_grade = 12.9\n" + own).bolt.strength
    assert (found.yield_strength, found.ultimate) == (1300.0, 1450.0)
    assert found.proof == pytest.approx(0.88 * 1300.0)
    assert read("[assembly]\nbolt_grade = 8.8\n").assembly.grade is BoltGrade.G8_8
    with pytest.raises(InvalidValue, match=r"material\.bolt\.ultimate_MPa"):
        bolt("[material.bolt]\nyield_MPa = 1300.0\nultimate_MPa = 1200.0\n")


def test_embedding_that_is_given_is_taken_from_the_preload():
    plain, embedded = bolt("bolt_preload_kN = 30.0"), bolt("bolt_preload_kN = 30.0\nbolt_embedding_um = 11.0")
    compliance = plain.bolt.compliance + plain.parts_compliance
    assert plain.preload - embedded.preload == pytest.approx(0.011 / compliance)
    assert embedded.tightening.preload == 30e3
    with pytest.raises(InvalidValue, match="all of the preload"):
        bolt("bolt_preload_kN = 1.0\nbolt_embedding_um = 500.0")


ROD_BOLT = (
    'bolt_thread = "3/8-24"\nbolt_grade = "ARP 2000"\nbolt_lubricant = "moly"\nbolt_grip_mm = 31.115\n'
    "bolt_engaged_mm = 9.525\nbolt_free_thread_mm = 5.0\n"
)
ROD_SEATS = BoltSeats(hole=9.6, length=50.0, cap=25.0, room=9.5, outer=22.0)


def test_a_maker_s_stretch_and_torque_agree_within_their_scatter():
    """A cap screw 3/8-24, 1.6 inches under its head, of ARP 2000: .0055 to .0060 inch, or 45 to 50 lbf ft.

    Both are meant for 75 % of the yield strength (ARP's table of torques); a torque scatters by 23 % or more.
    """
    found = {
        key: [bolt(f"{ROD_BOLT}{key} = {unit * value}\n", ROD_SEATS) for value in values]
        for key, unit, values in (
            ("bolt_stretch_mm", 25.4, (0.0055, 0.0060)),
            ("bolt_torque_Nm", 1.355818, (45.0, 50.0)),
        )
    }
    share = {
        key: [one.tightening.preload / (1240.0 * one.bolt.thread.stress_area) for one in bolts]
        for key, bolts in found.items()
    }
    assert share["bolt_stretch_mm"] == pytest.approx([0.66, 0.72], abs=0.005)
    assert share["bolt_torque_Nm"] == pytest.approx([0.75, 0.84], abs=0.005)
    # ARP's own preload of 3/8-24 by 39 lbf ft of its moly lubricant: 10 512 lbf.
    by_table = bolt(f"{ROD_BOLT}bolt_torque_Nm = {39 * 1.355818}\n", ROD_SEATS).tightening.preload
    assert by_table == pytest.approx(10_512 * 4.448222, rel=0.03)


def test_a_bolt_of_one_section_stretches_by_hooke():
    text = ROD_BOLT.replace("5.0", "0.0") + "bolt_shank_mm = 9.525\nbolt_stretch_mm = 0.15\n[material.bolt]\n"
    found = bolt(text + "E_GPa = 210.0\n", ROD_SEATS)
    d, root = 9.525, found.bolt.thread.root_diameter
    # F = E ΔL/Σ(l/A): head and shank of the nominal section, half a diameter of engaged thread of the core.
    lengths = (0.5 * d + 31.115) / (math.pi / 4 * d**2) + 0.5 * d / (math.pi / 4 * root**2)
    assert found.tightening.preload == pytest.approx(210e3 * 0.15 / lengths, rel=1e-9)


def test_an_angle_adds_what_bolt_and_parts_take_up_until_the_bolt_yields():
    snug = bolt(ROD_BOLT + "bolt_torque_Nm = 20.0\n", ROD_SEATS)
    turned = bolt(ROD_BOLT + "bolt_torque_Nm = 20.0\nbolt_angle_deg = 30.0\n", ROD_SEATS)
    travel = 30 / 360 * 25.4 / 24
    added = travel / (snug.bolt.compliance + snug.parts_compliance)
    assert turned.tightening.preload - snug.tightening.preload == pytest.approx(added, rel=1e-9)
    beyond = bolt(ROD_BOLT + "bolt_torque_Nm = 20.0\nbolt_angle_deg = 120.0\n", ROD_SEATS)
    assert beyond.tightening_stress == pytest.approx(1240.0, rel=1e-9)
    assert any("turns them beyond yield" in str(note) for note in beyond.notes)
    assert not any("beyond yield" in str(note) for note in turned.notes)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("bolt_stretch_mm = 0.14", "by a stretch of 0.14 mm (5.51 thousandths of an inch)"),
        ("bolt_stretch_mm = 0.14", "usually ±9 to 23 % (VDI 2230)"),
        ("bolt_torque_Nm = 60.0", "by 60 N·m with friction 0.09 in the thread and 0.09 under the head"),
        ("bolt_torque_Nm = 20.0\nbolt_angle_deg = 30.0", "±5 to 12 %"),
    ],
)
def test_a_run_says_how_the_preload_follows_and_how_it_scatters(text, said):
    assert any(said in str(note) for note in bolt(f"{ROD_BOLT}{text}\n", ROD_SEATS).notes)
    factor = bolt(f"{ROD_BOLT}{text}\nbolt_tightening_factor = 1.2\n", ROD_SEATS).notes
    assert not any("usually ±" in str(note) for note in factor)


def test_grades_of_makers_are_known_and_an_estimate_is_said():
    assert not any("an estimate" in str(note) for note in bolt(ROD_BOLT, ROD_SEATS).notes)
    found = bolt(ROD_BOLT.replace("ARP 2000", "L19"), ROD_SEATS)
    assert any("the yield strength of L19, an estimate" in str(note) for note in found.notes)
    assert found.bolt.rolled is ThreadRolled.AFTER
    # The grade's strengths are 180 and 220 ksi, and 88 % of the yield strength stands for the proof strength.
    strength = bolt(ROD_BOLT, ROD_SEATS).bolt.strength
    assert (strength.yield_strength, strength.ultimate) == pytest.approx((1241, 1517), rel=2e-3)
    assert strength.proof == pytest.approx(0.88 * strength.yield_strength)


def test_a_given_friction_counts_beside_a_lubricant():
    dry = bolt(ROD_BOLT.replace("moly", "dry") + "thread_friction = 0.1\n", ROD_SEATS)
    assert dry.bolt.thread_friction == 0.1
    moly = bolt(ROD_BOLT + "thread_friction = 0.1\n", ROD_SEATS)
    assert dry.bolt.lever > 1.3 * moly.bolt.lever


def test_tightening_is_judged():
    assert any("exceeds the proof load" in str(note) for note in bolt("bolt_stretch_mm = 0.195").notes)
    assert any("tightening yields them" in str(note) for note in bolt("bolt_preload_kN = 45.0").notes)
    with pytest.raises(
        InvalidValue, match=r"bolt_preload_kN = 50: breaks the bolt.*ultimate strength is 1040"
    ):
        bolt("bolt_preload_kN = 50.0")
    scattered = bolt("bolt_preload_kN = 32.0\nbolt_tightening_factor = 1.6").notes
    assert any("may leave only 20 kN" in str(note) for note in scattered)
    # 39 kN on π/4 (10² − 9²) mm².
    assert any("2613 MPa under head or nut" in str(note) for note in bolt("bolt_head_mm = 10.0").notes)


@pytest.mark.parametrize(
    ("text", "engaged", "grip"),
    [
        ("bolt_grip_mm = 28.0", 11.25, 28.0),
        ("bolt_engaged_mm = 10.0", 10.0, 30.0),
        ("bolt_grip_mm = 28.6", 11.4, 28.6),  # what would be left of the hole, 0.15 mm, is used
        ("bolt_grip_mm = 40.0", 0.0, 40.0),
    ],
)
def test_a_grip_shorter_than_the_bosses_is_that_of_a_screw(text, engaged, grip):
    found = bolt(text).bolt
    assert (found.engaged, found.grip) == (pytest.approx(engaged), pytest.approx(grip))
    assert (found.nut_diameter == 0) == (engaged > 0)


def test_a_hole_that_does_not_go_through_takes_a_screw():
    blind = dataclasses.replace(SEATS, through=False)
    assert bolt(seats=blind).bolt.engaged == pytest.approx(11.25)
    with pytest.raises(InvalidValue, match=r"bolt_nut_mm.*does not go through"):
        bolt("bolt_nut_mm = 13.0", blind)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('bolt_thread = "M10x1"', "must not be thicker than its hole, 9 mm"),
        ("bolt_grip_mm = 18.0", "must reach beyond the joint, 20 mm"),
        ("bolt_grip_mm = 38.0", r"2 mm of engaged thread, less than 0\.8 d"),
        ("bolt_grip_mm = 50.0", "must be the distance of the seats, 40 mm"),
        ("bolt_grip_mm = 30.0\nbolt_engaged_mm = 12.0", "must be at most 10 mm"),
        ("bolt_head_mm = 9.5", r"must be 9\.9 to 16 mm"),
        ("bolt_head_mm = 17.0", r"must be 9\.9 to 16 mm"),
        ("bolt_shank_mm = 4.0", r"must be at least 5\.4 mm"),
        ("bolt_free_thread_mm = 41.0", "must be at most the grip, 40 mm"),
    ],
)
def test_bolts_that_do_not_fit_are_refused(text, said):
    with pytest.raises(InvalidValue, match=said):
        bolt(text)


def test_a_rod_without_room_for_a_seat_is_refused_with_what_to_do():
    with pytest.raises(InvalidValue, match=r"bolt_head_mm needs at least 9\.9 mm.*cap_bolt_spacing_mm"):
        bolt(seats=dataclasses.replace(SEATS, room=4.0))


def test_the_seats_of_a_rod_given_by_dimensions_are_ones_that_can_be_drawn():
    from geometry.assembly import check

    for spacing in (70.5, 72.0, 78.0):
        study = read("[assembly]\n", ROD.replace("72.0", f"{spacing}"))
        seats = seats_of(study.rod.dimensions)
        assert (seats.hole, seats.length, seats.cap) == (9.0, 40.0, 20.0)
        check(study.rod.dimensions, AssemblySetup.of(study).geometry)


def test_fits_and_temperature_are_judged_and_said():
    fits = "bushing_interference_mm = 0.04\nshell_thickness_mm = 1.5\nshell_interference_mm = 0.03\n"
    cold, warm = assembling("[assembly]\n" + fits), assembling("[assembly]\ntemperature_C = 120.0\n" + fits)
    # Bronze in steel, 27 mm, 100 K: 6.5e-6 · 27 · 100; the shells are steel, as the rod.
    assert warm.expansions.interference("bushing", 0.04, 27.0) == pytest.approx(0.04 + 0.01755)
    assert warm.expansions.interference("shell", 0.03, 51.0) == 0.03
    said = " ".join(map(str, warm.notes(read("[assembly]\n"), ("rod", "bushing"))))
    assert "+100 K from 20 °C" in said
    assert "copper alloy for the bushing" in said
    assert "0.0576 mm" in said
    assert "K from" not in " ".join(map(str, cold.notes(read("[assembly]\n"), ("rod", "bushing"))))
    with pytest.raises(InvalidValue, match="makes the bushing yield through its wall"):
        assembling("[assembly]\nbushing_interference_mm = 0.2\n")


@pytest.mark.parametrize("key", [field.name for field in dataclasses.fields(AssemblyTable)])
def test_the_examples_of_the_template_are_ones_that_work(key):
    from geometry.assembly import check

    needed = {
        "shell_interference_mm": "shell_thickness_mm",
        "bushing_interference_mm": "bushing_mm",
        "bolt_angle_deg": "bolt_torque_Nm",
    }
    holes = ("cap_bolt_mm", "cap_bolt_spacing_mm", "cap_boss_length_mm", "cap_boss_fillet_mm")
    text = template().replace("\n# [assembly]", "\n[assembly]").replace('pressure = "cosine-180"', "")
    for shown in {key, needed.get(key, key), *holes}:
        text, found = re.subn(rf"(?m)^# ({shown} = )", r"\1", text)
        assert found == 1, shown
    study = parse_study(text, "template", Path.cwd())
    check(study.rod.dimensions, AssemblySetup.of(study).geometry)
    Draft202012Validator(study_schema()).validate(tomllib.loads(text))


@pytest.mark.parametrize("hole", [7.2, 8.2, 9.2])
def test_usual_proportions_leave_room_for_the_heads_of_bolts(hole):
    """Heads of standard bolts bear on 1.4 to 1.5 of their diameter (ISO 4014: 16 mm across flats of M10)."""
    seats = seats_of(proportioned(139.0, 48.0, 22.0, cap_bolt=hole))
    assert 2 * seats.room >= 1.4 * hole
