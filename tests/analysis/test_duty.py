"""Life of a rod over a duty: damage node by node, the worst place, what the study may say."""

from dataclasses import replace

import numpy as np
import pytest
from studies import PLAIN

from fea.analysis import pipeline
from fea.analysis.cycle.operation import every_cycle
from fea.analysis.life import COUNTED
from fea.analysis.life import life_of as life_of_loads
from fea.analysis.pipeline import prepare, solve_speed, with_cycle
from fea.base.choices import CycleAccuracy, Fatigue, Finish
from fea.judge.fatigue import LifeLine, reversed_amplitude
from fea.judge.history import rainflow
from fea.machine.clock import Clock
from fea.rod.loading import DutyLoads
from fea.study.duty_log import parse_log
from fea.study.material_table import MaterialTable
from fea.study.option_tables import MeshTable
from fea.study.speed_tables import DutyTable
from fea.study.study import Study, load_study, parse_study
from geometry.errors import InvalidValue

pytestmark = [pytest.mark.usefixtures("coarse_bores"), pytest.mark.slow]

SPEEDS, HOURS = (4000.0, 6000.0, 6500.0), (600.0, 350.0, 50.0)
DUTY = DutyTable(SPEEDS, HOURS)
FORGED = MaterialTable(preset="forged-steel-2005", surface=Finish.MACHINED)


def study(name="leon-2001", **tables):
    base = replace(load_study(name), material=FORGED, mesh=MeshTable(size_mm=14.0))
    return replace(base, analysis=replace(base.analysis, cycle=True, pressure="cosine-180"), **tables)


def life_of(rod, duty):
    return life_of_loads(rod.cycle, rod.mass, DutyLoads.of(duty, rod.engine))


@pytest.fixture(scope="module")
def rod():
    return prepare(study(duty=DUTY))


@pytest.fixture(scope="module")
def cycles(rod):
    return {rpm: with_cycle(rod, solve_speed(rod, rpm)).cycle for rpm in SPEEDS}


def by_envelopes(rod, cycles, entries):
    """Damage per hour (k, n_nodes) of the largest range of every cycle, from what `envelope.vtu` holds."""
    (material,), whole = rod.materials, rod.mesh.mirrored
    found = [cycles[rpm].envelope for rpm, _ in entries]
    fastest = max(rpm for rpm, _ in entries)  # whose gradients support the surface
    line = LifeLine.of(material, cycles[fastest].regions.factors(material))
    amplitude = [reversed_amplitude(Fatigue.GOODMAN, one.mean, one.amplitude, material) for one in found]
    assert len(whole.source) == len(amplitude[0])
    return line.damage(np.stack(amplitude), np.array([30 * rpm * share for rpm, share in entries]))


def test_damage_is_summed_at_every_node(rod, cycles):
    expected = by_envelopes(rod, cycles, [(rpm, share) for rpm, share, *_ in DUTY.entries]).sum(axis=0)
    life = rod.life
    # Every range is counted at the worst nodes and their images: never less than the largest alone.
    more = ~np.isclose(life.damage, expected, rtol=1e-5, atol=0)
    assert (life.damage[more] > expected[more]).all()
    assert more.sum() <= 4 * COUNTED
    away = np.linalg.norm(rod.mesh.whole.points - life.figures.at_mm, axis=1)
    assert life.damage[away.argmin()] == life.damage.max() == life.figures.damage_per_hour
    assert life.figures.hours == pytest.approx(1 / np.nanmax(life.damage), rel=1e-12)
    assert life.figures.duties == pytest.approx(life.figures.hours / 1000)


def test_shares_are_those_of_the_worst_place(rod):
    figures = rod.life.figures
    assert [entry.time_percent for entry in figures.duty] == pytest.approx([60, 35, 5])
    assert sum(entry.damage_percent for entry in figures.duty) == pytest.approx(100)
    low, high = figures.band_hours
    assert low < figures.hours < (high or np.inf)


def test_one_speed_all_the_time_has_its_own_life(rod, cycles):
    alone = life_of(rod, DutyTable((6000.0,), share_percent=(100.0,)))
    expected = by_envelopes(rod, cycles, [(6000.0, 1.0)]).sum(axis=0)
    single = alone.figures.damage_per_hour * alone.figures.largest_range_percent / 100
    assert single == pytest.approx(expected[alone.damage.argmax()], rel=1e-5)
    halves = life_of(rod, DutyTable((6000.0, 6000.0), hours=(1.0, 1.0)))
    np.testing.assert_allclose(halves.damage, alone.damage, rtol=1e-12)
    assert halves.figures.hours == pytest.approx(alone.figures.hours, rel=1e-12)


def test_more_time_at_the_higher_speed_shortens_life(rod):
    lives = [
        life_of(rod, DutyTable((5500.0, 6500.0), share_percent=(100.0 - share, share))).figures.hours
        for share in (1.0, 10.0, 50.0)
    ]
    assert lives == sorted(lives, reverse=True)
    assert lives[0] > 5 * lives[2]


def test_idling_alone_damages_nothing(rod):
    idle = life_of(rod, DutyTable((1000.0,), hours=(1.0,))).figures
    assert idle.endless
    assert idle.hours is None
    assert idle.damage_per_hour == 0
    assert idle.duty[0].damage_percent is None
    # The place nearest to its limit, whose band may end.
    assert idle.band_hours == (None, None)
    just = life_of(rod, DutyTable((4000.0,), hours=(1.0,))).figures
    assert just.endless
    assert just.band_hours[0] is not None
    assert 0.84 < just.duty[0].reversed_amplitude_MPa / just.endurance_MPa < 1


def test_one_range_of_a_fired_cycle_does_nearly_all_the_damage(rod):
    # What the sum over nodes relies on: rainflow over 720° against the largest range alone.
    for rpm in (5000.0, 6000.0, 7000.0):
        figures = life_of(rod, DutyTable((rpm,), hours=(1.0,))).figures
        assert 90 < figures.largest_range_percent <= 100


def test_without_gas_both_revolutions_count(rod):
    none = life_of(rod, DutyTable((6500.0,), hours=(1.0,), gas=("none",))).figures
    assert none.largest_range_percent == pytest.approx(50, rel=1e-3)
    other = prepare(study(engine=rod.engine.table.with_gas("none")))
    assert life_of(other, DutyTable((6500.0,), hours=(1.0,))).figures.hours == pytest.approx(none.hours)


def test_a_two_stroke_engine_has_as_many_revolutions_but_twice_the_cycles(rod):
    # With no gas, a four-stroke cycle holds the range of a two-stroke one twice: equal hours, and per hour
    # twice the damage of the largest range.
    duty = DutyTable((6500.0,), hours=(1.0,))
    four = rod.engine.with_gas("none")
    two = replace(four, engine=replace(four.engine, strokes=2))
    lives = [life_of_loads(rod.cycle, rod.mass, DutyLoads(duty, (one,))).figures for one in (four, two)]
    assert lives[1].hours == pytest.approx(lives[0].hours, rel=1e-6)
    of_largest = [one.damage_per_hour * one.largest_range_percent for one in lives]
    assert of_largest[1] == pytest.approx(2 * of_largest[0], rel=1e-3)


def test_a_material_without_a_line_has_an_assumed_one_with_its_band_and_is_told():
    plain = replace(study(duty=DUTY), material=MaterialTable(preset="hard-steel-1945"))
    life = prepare(plain).life
    assert life.figures.assumed_line
    assert life.figures.band_percent == pytest.approx(13.8)
    assert life.figures.band_hours[0] < life.figures.hours
    assert any("0.75 of the ultimate strength" in str(note) for note in life.notes)


def test_a_material_without_strengths_gets_factors_only_and_is_told():
    plain = replace(study(duty=DUTY), material=MaterialTable(preset="cusn8p"))
    life = prepare(plain).life
    assert life.figures is None
    assert life.point_data() == {}
    assert "no S–N line" in str(life.notes[0])
    assert "safety factors" in str(life.notes[0])


def test_the_mesh_is_refined_for_the_speeds_of_the_duty(monkeypatch):
    solved = []
    monkeypatch.setattr(
        pipeline, "solve_speed", lambda _rod, rpm: solved.append(rpm) or solve_speed(_rod, rpm)
    )
    refined = study(duty=DUTY)
    refined = replace(refined, analysis=replace(refined.analysis, tolerance_percent=90.0))
    pipeline.refined_rod(refined, (1000.0, 6000.0), Clock())
    assert set(solved) == {1000.0, *SPEEDS}


def test_contact_spans_a_duty_by_few_sums_with_the_life_of_all_unit_loads():
    base, lives, counts = study("molina-2024", duty=DutyTable((12000.0, 13500.0), HOURS[:2])), [], []
    for accuracy in (CycleAccuracy.FAST, CycleAccuracy.EXACT):
        options = replace(base.analysis, pressure=None, cycle_accuracy=accuracy)
        rod = prepare(replace(base, analysis=options))
        lives.append(rod.life.figures)
        counts.append(rod.cycle.units.count)
    few, every = lives
    assert counts[0] < 0.9 * counts[1]
    # Places on either side of y = 0 are alike but for rounding.
    assert np.abs(few.at_mm) == pytest.approx(np.abs(every.at_mm))
    assert few.hours == pytest.approx(every.hours, rel=1e-5)
    amplitudes = [[entry.reversed_amplitude_MPa for entry in life.duty] for life in lives]
    assert amplitudes[0] == pytest.approx(amplitudes[1], rel=1e-6)


TEXT = f"""{PLAIN}[material]
preset = "c70-2005"
[duty]
rpm = [3000, 6000]
hours = [10, 1]
gas = ["none", "leon-2001"]
"""


def test_a_duty_says_the_speeds_and_switches_the_cycle_on(tmp_path):
    found = parse_study(TEXT, "duty", tmp_path)
    assert found.speeds() == (3000, 6000)
    assert found.analysis.cycle
    again = parse_study(found.text(), "duty", tmp_path)
    assert again.as_dict() == found.as_dict()
    assert again.speeds() == (3000, 6000)
    assert again.material.material() == found.material.material()
    assert "fatigue_strength_exponent" in replace(found, duty=None).as_dict()["material"]


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("hours = [10, 1]", "hours = [10]", "duty.hours"),
        ("hours = [10, 1]", "hours = [10, -1]", "duty.hours"),
        ("hours = [10, 1]", "", "duty.hours"),
        ("hours = [10, 1]", "share_percent = [90, 20]", "add up to 100, not to 110"),
        ("hours = [10, 1]", "hours = [10, 1]\nshare_percent = [90, 10]", "duty.hours"),
        ("rpm = [3000, 6000]", "rpm = []", "duty.rpm"),
        ("rpm = [3000, 6000]", "rpm = [0, 6000]", "duty.rpm"),
        ("rpm = [3000, 6000]", "rpm = [3000, 60000]", "50000"),
        ('gas = ["none", "leon-2001"]', 'gas = ["none"]', "duty.gas"),
        ('gas = ["none", "leon-2001"]', 'gas = ["none", "leno"]', "duty.gas"),
        ("[duty]", "[duty]\nspeeds = 3", "unknown key"),
        ("[duty]", "[analysis]\ncycle = false\n[duty]", "analysis.cycle"),
    ],
)
def test_duties_that_make_no_sense_are_refused(tmp_path, old, new, named):
    with pytest.raises(InvalidValue, match=named):
        parse_study(TEXT.replace(old, new), "duty", tmp_path)


def test_a_duty_needs_an_engine():
    forces = load_study("leon-2001-as-published")
    with pytest.raises(InvalidValue, match=r"duty.rpm.*\[forces\]"):
        Study(forces.name, forces.rod, forces=forces.forces, duty=DUTY)


def log_table(tmp_path, speeds):
    lines = "".join(f"{0.5 * k:g},{rpm}\n" for k, rpm in enumerate(speeds))
    (tmp_path / "lap.csv").write_text(f"time [s],rpm\n{lines}")
    return DutyTable(log=str(tmp_path / "lap.csv"))


def test_a_log_of_one_speed_has_the_life_of_that_speed(rod, tmp_path):
    alone = life_of(rod, DutyTable((6500.0,), hours=(1.0,))).figures
    logged = life_of(rod, log_table(tmp_path, [6500] * 20))
    # Of all its cycles one is counted as that of the only stay.
    assert logged.figures.hours == pytest.approx(alone.hours, rel=1e-9)
    assert logged.figures.at_mm == alone.at_mm
    assert logged.figures.log.between_percent == 0
    assert logged.figures.duties == pytest.approx(logged.figures.hours / (10 / 3600))
    assert logged.log["damage_percent"].sum() == pytest.approx(100)


def test_a_lower_speed_within_the_range_of_a_higher_one_adds_no_cycles(rod, tmp_path):
    logged = life_of(rod, log_table(tmp_path, ([3000] * 6 + [6500] * 4) * 5)).figures
    shares = life_of(rod, DutyTable((3000.0, 6500.0), share_percent=(60.0, 40.0))).figures
    assert logged.log.between_cycles == 0
    assert logged.hours == pytest.approx(shares.hours, rel=1e-6)
    assert logged.log.hours_at_critical_damage == pytest.approx(0.3 * logged.hours)


def test_stays_and_the_cycles_between_them_are_those_of_the_whole_history(tmp_path):
    # Every period of every stay one after the other, counted at once.
    random = np.random.default_rng(3)
    stays = random.integers(0, 4, 60)
    lines = "".join(f"{k},{2000 + 1000 * cell}\n" for k, cell in enumerate(np.repeat(stays, 2)))
    log = parse_log(f"time [s],rpm\n{lines}", "lap.csv")
    periods = 10  # of the histories in a second
    histories = [
        np.array([high, 0.1, low, 0.2]) for high, low in zip((3.0, 5, 8, 12), (-4.0, -3, -6, -2), strict=True)
    ]
    whole = np.concatenate([np.tile(histories[cell], periods) for cell in log.bin_of])
    rates = [3600 * periods * each.share for each in log.bins]
    mean, amplitude, rate, _, between, _ = every_cycle([(1.0, histories)], rates, log)
    assert between.any()
    expected = rainflow(whole)
    hours = len(whole) / 4 / periods / 3600
    for own in (0.0, 1.0, 8.0):
        assert (rate * amplitude**own).sum() * hours == pytest.approx((expected[1] ** own).sum(), rel=1e-9)
    assert (rate * mean * amplitude**5).sum() * hours == pytest.approx((expected[0] * expected[1] ** 5).sum())
