"""B-lives of a rod: its places, their stress at other gas loads, and what is stated of known lines alone."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from studies import PLAIN

from fea.analysis import reliability
from fea.analysis.cycle.figures import envelope_figures, life_figures
from fea.analysis.cycle.operation import CountedCycles, JudgedNodes
from fea.analysis.cycle.unit_solutions import spots
from fea.analysis.pipeline import prepare, solve_speed, with_cycle
from fea.analysis.reliability import (
    _cycles,
    _places,
    duty_reliability,
    reliability_figures,
    speed_operation,
)
from fea.analysis.responses import causes, responses, usual_scatter
from fea.analysis.scatter import scatter_of
from fea.base.choices import Fatigue, ThreadRolled
from fea.judge.cycle_life import cycle_life, life_line
from fea.judge.fatigue import reversed_amplitude
from fea.judge.history import rainflow
from fea.judge.reliability import AWAY, STATIC, FirstFailure, Scatter, deviation, responded
from fea.output.life_statements import b_lives, lasts
from fea.output.life_tables import reliability_tables
from fea.output.statements import life as life_lines
from fea.rod.loading import DutyLoads, EngineLoading
from fea.study.assembly_table import SCATTER
from fea.study.scatter_table import ScatterTable
from fea.study.speed_tables import DutyTable
from fea.study.study import parse_study
from geometry.errors import InvalidValue
from loads.gas import scaled

pytestmark = [pytest.mark.usefixtures("coarse_bores"), pytest.mark.slow]
RPM = 6000.0
TEXT = PLAIN + '[material]\npreset = "forged-steel-2005"\n[mesh]\nsize_mm = 16.0\n[analysis]\ncycle = true\n'
NONE = ScatterTable(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def study(more="", text=TEXT):
    return parse_study(text + more, "plain", Path.cwd())


@pytest.fixture(scope="module")
def rod():
    return prepare(study())


@pytest.fixture(scope="module")
def solved(rod):
    return with_cycle(rod, solve_speed(rod, RPM))


def varied(rod, **more):
    """The rod with something else, but the unit solutions that it has."""
    own = replace(rod, **more)
    own.__dict__["certified_cycle"] = rod.certified_cycle
    return own


def lives(rod, solved, table=None):
    return at_speed(solved, varied(rod, study=replace(rod.study, scatter=table)))


def at_speed(solved, rod):
    return reliability_figures(solved.cycle, rod, speed_operation(solved.cycle, rod, RPM))


def places_of(rod, solved):
    found = solved.cycle
    nodes = JudgedNodes(
        found.envelope.fatigue_factor, found.envelope.fatigue_part, found.counts, found.regions
    )
    scatter = scatter_of(None, rod.loading, rod.options.fatigue)
    return list(_places(speed_operation(found, rod, RPM), nodes, rod, scatter))


@pytest.mark.parametrize("factor", [0.85, 0.97, 1.03, 1.15])
def test_superposed_amplitudes_are_those_of_contact_solved_at_another_gas_load(rod, solved, factor):
    """2 %; three standard deviations of a cylinder among others and of single cycles."""
    places = places_of(rod, solved)
    assert len(places) >= 2
    loading = rod.loading
    other = EngineLoading(loading.engine, scaled(loading.gas, factor), loading.table).crank_cycle(
        rod.mass, RPM
    )
    weights = rod.cycle.basis.projected(rod.cycle.basis.full(other.degrees, other))
    for place in places:
        (spot,) = spots([(place.node, 0)], rod.cycle.units, weights, rod.mesh.mirrored)
        exact = reversed_amplitude(Fatigue.GOODMAN, *rainflow(spot.signed), rod.materials[0]).max()
        found = np.interp(factor, place.gas, place.amplitude[:, 0])
        assert found == pytest.approx(exact, rel=0.02)


def test_responses_are_those_of_whole_runs_with_other_clearances(rod, solved):
    """2 %, at 1.5 deviations, which lies between solved ones; at the big end, where clearances count."""
    own = varied(rod, study=replace(rod.study, scatter=ScatterTable(clearance_um=7.0)))
    every = list(causes(own))
    assert [cause.name for cause in every] == ["small-end clearance", "big-end clearance"]
    found = solved.cycle
    big_end = found.counts & (rod.mesh.whole.points[:, 0] < 20.0)
    node = int(np.where(big_end, found.envelope.fatigue_factor, np.inf).argmin())
    (response,) = responses(own, speed_operation(found, own, RPM), [(node, 0)], every)
    fits, away = rod.pins.fits, (1.5, -1.5)
    contact = {
        "small_end_clearance_mm": 2 * fits.small_clearance + away[0] * 7e-3,
        "big_end_clearance_mm": 2 * fits.big_clearance + away[1] * 7e-3,
    }
    other = prepare(study().with_(contact=contact), mesh=rod.mesh)
    whole = with_cycle(other, solve_speed(other, RPM)).cycle

    def largest(analysis, weights):
        (spot,) = spots([(node, 0)], analysis.units, weights, rod.mesh.mirrored)
        return reversed_amplitude(Fatigue.GOODMAN, *rainflow(spot.signed), rod.materials[0]).max()

    exact = largest(other.cycle, whole.weights) / largest(rod.cycle, found.weights)
    predicted = np.exp(sum(responded(np.array(z), one) for z, one in zip(away, response, strict=True)))
    assert abs(exact - 1) > 0.01
    assert predicted == pytest.approx(exact, rel=0.02)


def test_a_response_shortens_lives_and_is_stated(rod, solved, monkeypatch):
    response = 0.1 * np.array(AWAY)
    alike = lambda _rod, _operation, where, _causes: np.tile(response, (len(where), 2, 1))  # noqa: E731
    monkeypatch.setattr(reliability, "responses", alike)
    plain, found = (lives(rod, solved, ScatterTable(clearance_um=um)) for um in (None, 3.0))
    assert plain.responses is None
    assert found.b10_hours < plain.b10_hours
    assert [each.cause for each in found.responses] == ["small-end clearance", "big-end clearance"]
    assert found.responses[0].change_percent == pytest.approx((-18.13, 22.14), abs=0.01)
    life = SimpleNamespace(reliability=found)
    summary = SimpleNamespace(rpm=RPM, life=None, cycle=SimpleNamespace(life=life))
    (table,) = reliability_tables(summary)
    assert "big-end clearance 3 µm (amplitude -18.1 % at −2, +22.1 % at +2 of these)" in table.caption


@pytest.mark.parametrize(
    ("keys", "analysis", "message"),
    [
        ("preload_percent = 10", "", r"scatter.preload_percent = 10: needs separate parts"),
        ("friction_percent = 10", "", r"scatter.friction_percent = 10: needs separate parts"),
        ("tightening = true", "", r"scatter.tightening = True: needs separate parts"),
        (
            "clearance_um = 8",
            "",
            r"clearance_um = 8: must be less than half of the small end's .* 14.4 µm",
        ),
        ("clearance_um = 2", 'pressure = "cosine-180"\n', r"scatter.clearance_um = 2: needs pins in contact"),
    ],
)
def test_what_the_rod_has_not_cannot_scatter(rod, keys, analysis, message):
    with pytest.raises(InvalidValue, match=message):
        prepare(study(f"{analysis}[scatter]\n{keys}\n"), mesh=rod.mesh)


def test_the_preload_scatters_by_the_way_of_tightening():
    """VDI 2230, table A8 (as TR Fastenings prints it): ±9 to 23 % by elongation, ±5 to 12 % by angle."""
    of = lambda scatter, factor=None: usual_scatter(  # noqa: E731
        SimpleNamespace(
            table=SimpleNamespace(bolt_tightening_factor=factor),
            bolt=SimpleNamespace(tightening=SimpleNamespace(scatter=scatter)),
        )
    )
    assert [of(SCATTER[way]) for way in ("stretch", "angle", "torque")] == [8.0, 4.25, 14.0]
    assert of(None) == of(SCATTER["torque"])
    assert of(SCATTER["angle"], 1.5) == pytest.approx(10.0)  # (1 + 0.2)/(1 − 0.2) = 1.5


def test_without_scatter_every_share_has_the_life_of_the_median(rod, solved):
    found = lives(rod, solved, NONE)
    spot = solved.cycle.weakest
    surface = float(solved.cycle.regions.at(np.array([spot.node])).factors(rod.materials[0])[0])
    median = cycle_life(spot.signed, rod.materials[0], surface).cycles / (30 * RPM)
    assert (found.b1_hours, found.b50_hours) == pytest.approx((median, median), rel=0.01)


def test_places_are_regions_and_bound_the_rod(rod, solved):
    found = lives(rod, solved)
    names = [place.where for place in found.places]
    assert found.first == min(found.places, key=lambda place: place.b10_hours or np.inf).where
    assert len(names) < 12
    for share in ("b1_hours", "b10_hours", "b50_hours"):
        alone = [getattr(place, share) or np.inf for place in found.places]
        assert getattr(found, share) <= min(alone) * (1 + 1e-3)
    assert found.b1_hours < found.b10_hours < found.b50_hours
    assert not found.conditional


def test_a_duty_of_one_speed_has_the_lives_of_that_speed(rod, solved):
    """1 %: the duty has the peaks between the degrees, too."""
    duty = DutyLoads.of(DutyTable((RPM, RPM), hours=(1.0, 3.0)), rod.engine)
    steady = envelope_figures(solved.cycle, rod, list(solved.cases.values()), RPM).life.hours
    rod = varied(rod, study=replace(rod.study, scatter=ScatterTable(cycle_pressure_percent=25.0)))
    own = varied(rod, duty=duty)
    found, alone = duty_reliability(own), at_speed(solved, rod)
    for share in ("b1_hours", "b10_hours", "b50_hours", "engine_b10_hours"):
        assert getattr(found, share) == pytest.approx(getattr(alone, share), rel=0.01)
    assert found.first == alone.first
    of_speed = envelope_figures(solved.cycle, rod, list(solved.cases.values()), RPM).life
    assert own.life.figures.hours == pytest.approx(of_speed.hours, rel=0.01)
    assert own.life.figures.hours < 0.95 * steady
    half = varied(rod, duty=DutyLoads.of(DutyTable((RPM, 1000.0), hours=(1.0, 1.0)), rod.engine))
    assert duty_reliability(half).b10_hours == pytest.approx(2 * alone.b10_hours, rel=0.01)
    figures = replace(own.life.figures, reliability=found)
    summary = SimpleNamespace(rpm=RPM, life=figures, cycle=None)
    *_, line = life_lines(summary)
    assert line.startswith(f"{b_lives(found)} over the duty: a tenth and half")
    (table,) = reliability_tables(summary)
    assert table.caption.startswith("Hours over the duty by which")


def test_an_engine_of_four_loses_its_first_rod_earlier(rod, solved):
    four = replace(rod.study.engine, cylinders=4)
    loading = EngineLoading.of(four, rod.mesh.bores.rod_length)
    found = at_speed(solved, varied(rod, loading=loading))
    assert found.rods == 4
    assert found.b1_hours < found.engine_b10_hours < found.b10_hours


def test_an_assumed_line_has_b_lives_only_where_scatter_is_given(rod, solved):
    materials = tuple(replace(material, basquin=None) for material in rod.materials)
    own = varied(rod, structure=replace(rod.structure, materials=materials))
    assert at_speed(solved, own) is None
    given = varied(own, study=replace(rod.study, scatter=ScatterTable(hours=10.0)))
    found = at_speed(solved, given)
    assert found.conditional
    assert all(place.assumed for place in found.places)
    assert 0 <= found.failed_percent[0] <= found.failed_percent[1] <= 100


def test_the_answer_names_percentiles_of_a_known_line_alone(rod, solved):
    life = envelope_figures(solved.cycle, rod, list(solved.cases.values()), RPM).life

    def shown(known):
        summary = SimpleNamespace(rpm=RPM, life=None, cycle=SimpleNamespace(life=known))
        (line,), (table,) = life_lines(summary), reliability_tables(summary)
        return line, table

    line, table = shown(life)
    assert line.startswith(f"{b_lives(life.reliability)} at 6000 rpm")
    assert "strength 8 %" in table.caption
    assert [row[0] for row in table.rows][-1].startswith("rod")
    line, table = shown(replace(life, reliability=replace(life.reliability, conditional=True)))
    assert line.startswith(("Lasts", "Life"))
    assert "if the assumed strength or peak pressure is right" in table.caption


def test_an_answer_says_that_only_stronger_cycles_do_damage(rod, solved):
    """An endurance limit 1 % above what the mean cycle needs: a cycle of 3 × 5 % more gas load exceeds it."""
    (material,), spot = rod.materials, solved.cycle.weakest
    surface = solved.cycle.regions.factor(spot.node, material)
    amplitude = reversed_amplitude(Fatigue.GOODMAN, *rainflow(spot.signed), material).max()
    just = replace(material, endurance_limit=float(1.01 * amplitude / surface))
    own = varied(rod, structure=replace(rod.structure, materials=(just,)))
    found = life_figures(solved.cycle, own, RPM)
    assert found.hours is not None
    assert found.steady_is_undamaged is True  # of JSON
    assert "Cycles of mean pressure alone would do no damage" in lasts(found, "at 6000 rpm")
    even = varied(own, study=replace(rod.study, scatter=ScatterTable(cycle_pressure_percent=0.0)))
    steady = life_figures(solved.cycle, even, RPM)
    assert (steady.hours, steady.steady_is_undamaged) == (None, None)


def test_static_strength_acts_through_mean_stress(rod):
    """Goodman: σ_a/(1 − σ_m/S_u), with S_u of the rod in place of the median."""
    (material,) = rod.materials
    one = np.ones(1)
    counted = [CountedCycles(300.0 * one, 200.0 * one, one, 0 * one, one < 0, one > 0)]
    amplitude, _, followed = _cycles(Fatigue.GOODMAN, material, counted, life_line(material, one), 0.05)
    assert amplitude[0, 0] == pytest.approx(200 / (1 - 300 / 938))
    other = 938 * np.exp(STATIC * deviation(0.05))
    assert np.exp(followed[0]) * amplitude[0, 0] == pytest.approx(200 / (1 - 300 / other))


@pytest.mark.parametrize(("rolled", "slope"), [(ThreadRolled.BEFORE, 3), (ThreadRolled.AFTER, 6)])
def test_bolts_last_by_the_line_of_vdi_2230(monkeypatch, rolled, slope):
    """σ_AS at 2·10⁶ cycles, and from there up with the slope; every one of a pair counts."""
    judged = SimpleNamespace(endurance=50.0, bending_amplitude=100.0)
    monkeypatch.setattr(reliability, "judged_bolts", lambda *_: [judged])
    bolt = SimpleNamespace(bolt=SimpleNamespace(rolled=rolled))
    entry = SimpleNamespace(states=[SimpleNamespace(bolts=[SimpleNamespace(count=2)])])
    operation = SimpleNamespace(entries=[entry], rates=[3e5])
    assembling = SimpleNamespace(bolt=bolt)
    (place,) = reliability._bolts(operation, SimpleNamespace(assembling=assembling))
    found = FirstFailure([place], Scatter(strength=0.08))
    assert found.of_place(0, 0.5).cycles == pytest.approx(2e6 / 2**slope, rel=0.01)
    assert found.of_rod(0.75).cycles == pytest.approx(2e6 / 2**slope, rel=0.01)
    assert place.assumed


def test_defaults_follow_the_gas(rod):
    of = lambda loading: scatter_of(ScatterTable(), loading, Fatigue.GOODMAN)  # noqa: E731
    petrol = of(rod.loading)
    assert (petrol.cylinder_pressure, petrol.cycle_pressure, petrol.static_strength) == (0.03, 0.05, 0.04)
    unfired = of(rod.loading.with_gas("none"))
    assert (unfired.cylinder_pressure, unfired.cycle_pressure) == (0.0, 0.0)
    assert scatter_of(ScatterTable(), rod.loading, Fatigue.SODERBERG).static_strength == 0.07


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (
            "strength_percent = -1",
            r"scatter.strength_percent = -1: must lie between 0 and 50 %.*0 switches it off",
        ),
        ("peak_pressure_percent = 120", r"scatter.peak_pressure_percent = 120: must lie between 0 and 50 %"),
        ("batch_percent = 101", r"scatter.batch_percent = 101: must lie between 0 and 100 %"),
        ("hours = 0", r"scatter.hours = 0: must be positive"),
        ('tightening = "by feel"', r"scatter.tightening = 'by feel': must be true or false"),
        ("preload_percent = 45", r"scatter.preload_percent = 45: must lie between 0 and 40 %"),
        ("friction_percent = -1", r"scatter.friction_percent = -1: must lie between 0 and 40 %"),
        ("clearance_um = -1", r"scatter.clearance_um = -1: must not be negative"),
        ('strength_percent = "much"', r"scatter.strength_percent"),
    ],
)
def test_a_study_may_not_say(keys, message):
    with pytest.raises(InvalidValue, match=message):
        study(f"[scatter]\n{keys}\n")


def test_scatter_needs_the_cycle_and_switches_it_on():
    text = TEXT.replace("[analysis]\ncycle = true\n", "")
    assert study("[scatter]\n", text).analysis.cycle
    given = text[: text.index("[engine]")] + "[forces]\npin_N = [1000.0, 0.0]\n"
    with pytest.raises(InvalidValue, match=r"forces.pin_N = .*: cannot be combined with \[scatter\]"):
        study("[scatter]\n", given)
    again = study("[scatter]\nhours = 5\nstrength_percent = 6\nclearance_um = 2\ntightening = true")
    assert parse_study(again.text(), "plain", again.folder).scatter == again.scatter
