"""Bolts after VDI 2230: published tables, closed forms, and what must hold for any bolt."""

import math

import numpy as np
import pytest
from bolts import bolt
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from fea.base.choices import BoltGrade, ThreadRolled
from fea.judge.bolt import HEAD_TURN, USUAL_EMBEDDING, BoltResult, ClampedParts, TightenedBolt, Tightening
from fea.study.assembly_table import BoltStrength, Thread, bolt_strength, parse_thread, thread_in_hole
from geometry.errors import InvalidValue

# Seat of a hexagon bolt (ISO 4014) and medium hole (ISO 273) by nominal diameter, mm.
SEATS = {8: (11.63, 9.0), 10: (14.63, 11.0), 12: (16.63, 13.5), 16: (22.49, 17.5), 24: (33.61, 26.0)}
# Fine threads of VDI 2230, tables A3 and A4, reprinted in a fastener catalogue: preload in kN, torque in N·m,
# by friction, for classes 8.8, 10.9 and 12.9 at 90 % of the yield strength.
TABLE = {
    ("M8x1", 0.10): ((20.7, 30.4, 35.6), (22.8, 33.5, 39.2)),
    ("M8x1", 0.14): ((19.7, 28.9, 33.9), (29.2, 42.8, 50.1)),
    ("M10x1.25", 0.12): ((31.6, 46.4, 54.3), (51, 75, 87)),
    ("M12x1.25", 0.12): ((48.0, 70.5, 82.5), (90, 133, 155)),
    ("M16x1.5", 0.14): ((85.5, 125.5, 146.9), (244, 359, 420)),
    ("M24x2", 0.12): ((209, 297, 348), (769, 1095, 1282)),
}
GRADES = (BoltGrade.G8_8, BoltGrade.G10_9, BoltGrade.G12_9)
THREADS = st.builds(lambda d, share: Thread(d, share * d), st.floats(3, 64), st.floats(0.04, 0.18))
FRICTIONS = st.floats(0.02, 0.4)
FORCES = st.floats(10.0, 1e6)


def tightened(own, *, turned=True):
    return TightenedBolt(own, Tightening(35e3, "", turned=turned), embedding_loss=0.0, parts_compliance=1e-6)


def judged(own, forces, bending=0.0, shear=0.0, *, turned=True):
    """The bolt under forces (k,) and bending stress (k,) of its thread in one plane."""
    bent = np.stack([np.broadcast_to(bending, forces.shape), np.zeros_like(forces)], axis=1)
    fibre = forces / own.least_area + np.abs(bent[:, 0])
    return BoltResult.of(tightened(own, turned=turned), forces, fibre, bent, shear)


@pytest.mark.parametrize(
    ("name", "pitch", "root", "area"),
    # d2, d3 and A_S of ISO 724 and ISO 898-1, tables 4 and 6.
    [
        ("M8", 7.188, 6.466, 36.6),
        ("M12x1.25", 11.188, 10.466, 92.1),
        ("M10x1", 9.350, 8.773, 64.5),
        ("M 24 X 2", 22.701, 21.546, 384.0),
    ],
)
def test_basic_dimensions_are_those_of_the_standard(name, pitch, root, area):
    thread = parse_thread("key", name)
    assert thread.pitch_diameter == pytest.approx(pitch, abs=6e-4)
    assert thread.root_diameter == pytest.approx(root, abs=6e-4)
    assert thread.stress_area == pytest.approx(area, rel=1.5e-3)


@pytest.mark.parametrize(
    ("name", "minor", "area"),
    # ASME B1.1, inches: minor diameter of UNR (boltport.com, which has none for UNC), and tensile stress area
    # (Shigley's table 8-2; Fastenal's reference, which rounds that of 5/16-24, 0.05807, correctly).
    [
        ("1/4-28", 0.2074, 0.0364),
        ("5/16-24", 0.2629, 0.0581),
        ("3/8 UNF", 0.3254, 0.0878),
        ("3/8 UNC", None, 0.0775),
        ("7/16-20 UNF", 0.3780, 0.1187),
        ('1/2"-20', 0.4405, 0.1599),
        (".625-18", 0.5589, 0.256),
        ("#10-32", 0.1528, 0.0200),
        ("1/2 unc", None, 0.1419),
    ],
)
def test_dimensions_of_inch_threads_are_those_of_the_standard(name, minor, area):
    thread = parse_thread("key", name)
    assert thread.stress_area / 25.4**2 == pytest.approx(area, rel=1e-3)
    if minor is not None:
        assert thread.root_diameter / 25.4 == pytest.approx(minor, abs=1e-4)  # four digits, some cut off


def test_the_larger_root_of_unj_stiffens_the_thread_and_the_name_is_read_again():
    round_root, larger = parse_thread("key", "3/8-24"), parse_thread("key", "3/8-24 UNJF")
    assert larger.root_diameter > round_root.root_diameter
    assert larger.stress_area == round_root.stress_area
    for thread in (round_root, larger, parse_thread("key", ".3-24")):
        assert parse_thread("key", thread.name) == thread


@pytest.mark.parametrize("name", ["3/8", "3/8-20 UNF", "3/8-2", "3/0-24", "8/1-24", ".3 UNF", "3/8 UNJ"])
def test_what_is_no_inch_thread_is_refused(name):
    with pytest.raises(InvalidValue, match=r"assembly\.bolt_thread"):
        parse_thread("assembly.bolt_thread", name)


@pytest.mark.parametrize("name", ["M8.5", "8x1", "M8x", "M8x5", "M800x6", "M0x1", "", "M8x1x40"])
def test_what_is_no_thread_is_refused(name):
    with pytest.raises(InvalidValue, match=r"assembly\.bolt_thread"):
        parse_thread("assembly.bolt_thread", name)


def test_the_thread_of_a_hole_is_the_largest_that_goes_through():
    assert [thread_in_hole(hole).name for hole in (3.0, 8.9, 9.0, 13.0)] == [
        "M3x0.35",
        "M8x1",
        "M9x1",
        "M12x1.25",
    ]
    assert thread_in_hole(2.9) is None


@pytest.mark.parametrize(("case", "published"), TABLE.items())
def test_preload_and_torque_are_those_of_the_guideline(case, published):
    (name, friction), thread = case, parse_thread("key", case[0])
    head, hole = SEATS[int(thread.diameter)]
    for grade, force, torque in zip(GRADES, *published, strict=True):
        own = of_thread(thread, friction, bolt_strength(grade, thread.diameter), head, hole)
        # Printed to two or three digits; seats and areas of the tables are rounded, too.
        assert own.allowed_preload == pytest.approx(force * 1e3, rel=4e-3), name
        assert own.allowed_preload * own.lever == pytest.approx(torque * 1e3, rel=7e-3), name


def of_thread(thread, friction, strength, head=None, hole=None):
    d = thread.diameter
    return bolt(
        thread=thread,
        shank_diameter=d,
        head_diameter=head or 1.6 * d,
        hole=hole or 1.2 * d,
        strength=strength,
        thread_friction=friction,
        head_friction=friction,
    )


@given(THREADS, FRICTIONS, st.floats(300, 1500))
def test_the_allowed_preload_uses_its_share_of_the_yield_strength(thread, friction, strength):
    limits = BoltStrength(0.8 * strength, strength, 1.1 * strength)
    own, rougher = of_thread(thread, friction, limits), of_thread(thread, 1.01 * friction, limits)
    assert own.tightening_stress(own.allowed_preload) == pytest.approx(0.9 * strength, rel=1e-12)
    assert rougher.allowed_preload < own.allowed_preload
    assert rougher.lever > own.lever


def test_a_shank_of_the_core_only_is_a_chain_of_cylinders():
    thread, E = parse_thread("key", "M10"), 205e3
    shank = {"grip": 50.0, "free_thread": 20.0, "shank_diameter": math.sqrt(160.0 / math.pi)}
    own = bolt(thread=thread, **shank, engaged=15.0, modulus=E, counter_modulus=70e3)
    area, root = math.pi / 4 * 10.0**2, thread.root_area
    parts = (5 / area, 30 / 40.0, 20 / root, 5 / root, 3.3 / area * E / 70e3)
    assert own.compliance * E == pytest.approx(sum(parts), rel=1e-12)
    assert own.stretch_compliance * E == pytest.approx(sum(parts[:4]), rel=1e-12)


@pytest.mark.parametrize("nut", [True, False])
@given(
    grip=st.floats(5, 200), seat=st.floats(10.5, 20), outer=st.floats(9.5, 200), modulus=st.floats(5e4, 2e5)
)
def test_clamped_parts_are_the_integral_over_cones_and_sleeve(nut, grip, seat, outer, modulus):
    parts = ClampedParts(grip, seat, 9.0, outer, modulus, nut)
    slope = parts.slope

    def over_area(z):  # z from the seat of the head; from both seats with a nut
        reach = min(seat + 2 * slope * z, max(outer, seat)) if outer > seat else outer
        return 4 / (math.pi * (reach**2 - 81.0))

    length = grip / 2 if nut else grip
    kink = (outer - seat) / (2 * slope)
    expected = quad(over_area, 0, length, points=[kink] if 0 < kink < length else None, epsrel=1e-10)[0]
    assert parts.compliance * modulus == pytest.approx(expected * (2 if nut else 1), rel=1e-7)


def test_the_cone_of_a_worked_proportion():
    # l_K = d_W = D_A/2: tan φ = 0.362 + 0.032 ln(1/2) + 0.153 ln 2, or 0.348 + 0.193 ln 2 for a screw.
    assert ClampedParts(15, 15, 9, 30, 2e5).slope == pytest.approx(0.44587, abs=1e-5)
    assert ClampedParts(15, 15, 9, 30, 2e5, nut=False).slope == pytest.approx(0.48178, abs=1e-5)


def test_embedding_costs_preload():
    # Thread, two seats, one joint at R_z up to 40 µm: 3 + 2·3 + 2 µm (VDI 2230, table 5).
    assert pytest.approx(11e-3) == USUAL_EMBEDDING
    own = TightenedBolt(bolt(), Tightening(35e3, ""), embedding_loss=2200.0, parts_compliance=1e-6)
    assert own.preload == pytest.approx(32.8e3)


def test_endurance_of_threads():
    # VDI 2230: 48.9 MPa for M12 and 54.2 for M8, printed to a tenth.
    small, large = (parse_thread("key", name) for name in ("M8", "M12"))
    assert bolt(thread=large).endurance(0.0) == pytest.approx(48.9, abs=0.05)
    before = bolt(thread=small).endurance(0.0)
    assert before == pytest.approx(54.2, abs=0.05)
    after = bolt(thread=small, rolled=ThreadRolled.AFTER)
    at_yield = after.strength.yield_strength * small.stress_area
    for share, factor in ((0.7, 1.3), (0.1, 1.7), (2.0, 1.0)):
        assert after.endurance(share * at_yield) == pytest.approx(factor * before)


def test_a_bolt_over_a_cycle():
    forces = 35e3 + 4e3 * np.sin(np.linspace(0, 2 * np.pi, 721))
    found = judged(bolt(), forces)
    area = bolt().thread.stress_area
    assert found.largest_at == 180
    assert found.force_amplitude == pytest.approx(4e3)
    assert found.amplitude == pytest.approx(4e3 / area)
    assert found.fatigue_safety == pytest.approx(0.85 * (150 / 9 + 45) / (4e3 / area))
    assert found.proof_use == pytest.approx(39e3 / (830 * area))
    assert found.seat_pressure == pytest.approx(39e3 / (math.pi / 4 * (12.5**2 - 81)))
    # Half of the elastic torsion stays in service: τ/σ = 2 d2/d_S (P/(π d2) + 1.155 μ).
    d2, ds = bolt().thread.pitch_diameter, bolt().thread.stress_diameter
    shear = 35e3 / area * 2 * d2 / ds * (1 / (math.pi * d2) + 1.155 * 0.12)
    assert found.working_safety == pytest.approx(940 / math.hypot(39e3 / area, math.sqrt(3) / 2 * shear))
    stretched = judged(bolt(), forces, turned=False)
    assert stretched.tightening_use == pytest.approx(35e3 / area / 940)
    assert stretched.working_safety > found.working_safety
    assert judged(bolt(), forces[:1]).fatigue_safety == math.inf
    waisted = judged(bolt(shank_diameter=7.0), forces)
    assert waisted.working_safety < found.working_safety
    assert waisted.amplitude == found.amplitude  # the thread is where bolts break
    rolled_after = judged(bolt(rolled=ThreadRolled.AFTER), forces)
    assert rolled_after.fatigue_safety > found.fatigue_safety


def test_bending_adds_to_tension_where_it_pulls():
    phase = np.linspace(0, 2 * np.pi, 721)
    forces, area = 35e3 + 4e3 * np.sin(phase), bolt().thread.stress_area
    straight, with_it, against = (judged(bolt(), forces, sign * 20.0 * np.sin(phase)) for sign in (0, 1, -1))
    assert straight.bending_amplitude == pytest.approx(straight.amplitude, rel=1e-12)
    assert straight.bending_safety == pytest.approx(straight.working_safety)
    # The fibre on the other side of the bolt sees the same.
    for bent in (with_it, against):
        assert bent.bending_amplitude == pytest.approx(4e3 / area + 20.0)
        assert bent.amplitude == straight.amplitude
        assert bent.bending_fatigue_safety == pytest.approx(bent.endurance / (4e3 / area + 20.0))
    assert with_it.bending_safety < straight.bending_safety
    assert judged(bolt(), forces[:1]).bending_fatigue_safety == math.inf


@given(st.floats(1e3, 1e5), st.floats(1.2, 2.0), st.floats(1.0, 1.1), st.floats(0.1, 3.0))
def test_a_seat_lifts_where_linear_pressure_vanishes_at_its_edge(force, wide, hole, moment):
    shape = bolt(head_diameter=wide * 8, hole=hole * 8, nut_diameter=0.0)
    outer, inner = wide * 8, hole * 8
    area, inertia = math.pi / 4 * (outer**2 - inner**2), math.pi / 64 * (outer**4 - inner**4)
    lifting = force / area * inertia / (outer / 2)
    assert shape.lift(force, (moment * lifting, 9 * lifting)) == pytest.approx(moment)
    assert bolt(hole=9.0, shank_diameter=7.0, free_thread=0.0).play == pytest.approx(1.0)
    assert bolt(hole=9.6, shank_diameter=7.0, free_thread=5.0).play == pytest.approx(0.3)
    assert bolt(hole=0.375 * 25.4, shank_diameter=3 * (25.4 / 8) - 2e-15, free_thread=0.0).play == 0


@settings(deadline=None)
@given(THREADS, st.floats(0.0, 1.0), st.floats(0.6, 1.0), st.booleans())
def test_a_bolt_bends_as_its_sections_in_series(thread, threaded, waist, nut):
    d, grip, modulus = thread.diameter, 5 * thread.diameter, 2e5
    free, shank = threaded * grip, waist * d
    beam = bolt(
        thread=thread,
        grip=grip,
        free_thread=free,
        shank_diameter=shank,
        engaged=0.0 if nut else d,
        modulus=modulus,
        counter_modulus=1e5,
    ).beam

    def section(diameter):
        return modulus * math.pi / 64 * diameter**4, 0.886 / 2.6 * modulus * math.pi / 4 * diameter**2

    moments = (
        lambda x: x / grip,
        lambda x: x / grip - 1,
    )  # of unit moments on the ends
    expected = np.zeros((2, 2))
    for start, end, diameter in ((0.0, free, thread.root_diameter), (free, grip, shank)):
        bent, sheared = section(diameter)
        for i, j in np.ndindex(2, 2):
            work = quad(lambda x: moments[i](x) * moments[j](x), start, end)[0]  # noqa: B023
            expected[i, j] += work / bent + (end - start) / grip**2 / sheared
    expected[0, 0] += HEAD_TURN * d / section(d)[0]
    expected[1, 1] += 0.5 * d / section(thread.root_diameter)[0]
    expected[1, 1] += (0.4 if nut else 0.33) * d / (section(d)[0] / 2)
    assert beam.flexibility == pytest.approx(expected, rel=1e-9)
    in_thread = beam.bending(np.array([[0.0, 1e3], [0.0, 0.0]]))[0]
    assert in_thread == pytest.approx([-1e3 / (math.pi / 32 * thread.stress_diameter**3), 0.0])


@given(FORCES, FORCES)
def test_working_stress_grows_with_the_force(force, more):
    turned, stretched = tightened(bolt()), tightened(bolt(), turned=False)
    assert turned.working_stress(force) < turned.working_stress(force + more)
    assert stretched.working_stress(force) < turned.working_stress(force)
    assert stretched.working_stress(force, 30.0) == pytest.approx(math.hypot(force, 3**0.5 * 30))


def test_what_a_bolt_bears_in_its_hole_counts_against_yielding():
    own, forces = bolt(), np.array([35e3, 37e3])
    free, borne = judged(own, forces), judged(own, forces, shear=5e3)
    assert borne.shear_stress == pytest.approx(5e3 / own.least_area)
    for before, after in (
        (free.working_safety, borne.working_safety),
        (free.bending_safety, borne.bending_safety),
    ):
        assert after < before
    assert borne.fatigue_safety == free.fatigue_safety
