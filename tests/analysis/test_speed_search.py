"""The worst place of many speeds, found without looking at every place, is that of looking at all."""

from dataclasses import replace

import numpy as np
import pytest
from cycles import analysis
from rod_studies import random_study

from fea.analysis.cycle.rows import PartRows
from fea.analysis.cycle.search import EstimatedCycle, SpeedSearch, judged
from fea.analysis.many_speeds import SpeedSweep
from fea.analysis.pipeline import prepare, solve_speed, with_cycle
from fea.base.choices import CONTACT, Fatigue, Region, Symmetry
from fea.base.material import Marin, SurfaceFinish
from fea.judge.fatigue import fatigue_factor
from fea.judge.history import deviatoric, extremes
from fea.judge.verdict import CAP
from fea.pins.contact import PressurePatterns
from fea.pins.model import UnitLoads
from fea.study.flags import Flags
from geometry.surfaces import Surface
from loads.gas import NoGas
from loads.slider_crank import cycle_angles

pytestmark = pytest.mark.usefixtures("coarse_bores")

SPEEDS = np.linspace(800, 9000, 21)


@pytest.fixture(scope="module")
def rod():
    return analysis(Symmetry.QUARTER, 20.0)


@pytest.fixture(scope="module")
def search(rod):
    return SpeedSearch(rod.cycle, rod.crank_cycle, SPEEDS)


def _everywhere(rod, rpm):
    """Extremes of every node and image over the same instants, and the largest stress of each case."""
    cycle = rod.cycle
    cases = rod.crank_cycle(rpm).peaks.cases
    degrees, of_cases = (
        cycle.weights(rod.crank_cycle(rpm), cycle_angles()),
        cycle.basis.weights(cases),
    )
    moving = cases.in_cycle
    (own,) = cycle.units.parts
    even, odd = deviatoric(own.even), deviatoric(own.odd)
    weights = [np.append(w, c[:, moving], axis=1) for w, c in zip(degrees, of_cases, strict=True)]
    sides = [extremes(even @ weights[0] + side * (odd @ weights[1])) for side in cycle.units.sides]
    return [
        np.concatenate([getattr(side, name) for side in sides]) for name in ("von_mises", "mean", "amplitude")
    ]


@pytest.mark.parametrize("rpm", [800.0, 2440.0, 9000.0])
def test_worst_places_are_those_of_looking_everywhere(rod, search, rpm):
    largest, mean, amplitude = _everywhere(rod, rpm)
    material, found = rod.materials[0], search.at(rpm)
    surface = np.tile(rod.cycle.regions.factors(material), 2)
    fatigue = fatigue_factor(rod.options.fatigue, mean, amplitude, material, surface)
    assert found.yielding.factor == pytest.approx(material.yield_strength / largest.max(), rel=1e-9)
    assert found.fatigue.factor == pytest.approx(fatigue.min(), rel=1e-9)
    assert found.fatigue.figures.amplitude_MPa == pytest.approx(amplitude[fatigue.argmin()], rel=1e-9)


def test_the_worst_place_depends_on_the_finish_of_each(rod):
    """A shank so rough that it fails before the bores, and bores so rough that they fail first."""
    cycle, places = rod.cycle, []
    _, mean, amplitude = _everywhere(rod, 6000.0)
    for bores, rest in ((1.0, 0.3), (0.2, 1.0)):
        marin = Marin(bores=SurfaceFinish(bores), faces=SurfaceFinish(1.0), rest=SurfaceFinish(rest))
        material = replace(rod.materials[0], marin=marin)
        analysis = replace(cycle, materials=(material,))
        found = SpeedSearch(analysis, rod.crank_cycle, [5000.0, 7000.0]).at(6000.0).fatigue
        surface = np.tile(cycle.regions.factors(material), 2)
        assert set(surface) == {bores, rest, 1.0}
        factors = fatigue_factor(rod.options.fatigue, mean, amplitude, material, surface)
        assert found.factor == pytest.approx(factors.min(), rel=1e-9)
        assert found.figures.endurance_MPa == pytest.approx(
            surface[factors.argmin()] * material.endurance_limit
        )
        places.append(found.figures.surface_region)
    assert places == [Region.REST, Region.BORES]


@pytest.fixture(scope="module")
def in_contact():
    """A random rod under contact, on a coarse mesh."""
    study = random_study(16)
    return prepare(Flags(size=study.rod.length / 7, pressure=CONTACT, cycle=True).applied(study))


def test_estimated_contact_leads_to_the_places_of_every_degree_solved(in_contact, monkeypatch):
    rod, cell = in_contact, in_contact.mesh.cell
    # Where estimates err most: the bores alone.
    ends = [cell.facets[end].ravel() for end in (Surface.BIG_END_BORE, Surface.SMALL_END_BORE)]
    cycle = replace(rod.full_cycle, masked=~np.isin(np.arange(len(cell.points)), np.concatenate(ends)))
    monkeypatch.setattr("fea.pins.contact.KNOTS", 15)  # estimates err more, and more must be solved
    speeds = list(rod.study.speed.rpm * np.array([0.4, 1.0]))
    estimated = SpeedSearch(cycle, rod.crank_cycle, speeds)
    found = {rpm: estimated.at(rpm) for rpm in (*speeds, np.mean(speeds))}
    monkeypatch.setattr(PressurePatterns, "sampled", UnitLoads.sampled)
    every = SpeedSearch(cycle, rod.crank_cycle, speeds)
    for rpm, own in found.items():
        direct = every.at(rpm)
        for place, exact in ((own.yielding, direct.yielding), (own.fatigue, direct.fatigue)):
            assert place.factor == pytest.approx(exact.factor, rel=1e-4)
            factors = place.figures.crossland_safety_factor, exact.figures.crossland_safety_factor
            assert factors[0] == pytest.approx(factors[1], rel=1e-4)


@pytest.mark.parametrize("apart", [0.0, 0.03])
def test_the_error_of_estimated_pressures_is_within_its_bound(in_contact, apart):
    """Between instants of the cycle, or between those of cycles at speeds that lie `apart`."""
    loads, rpm = in_contact.full_cycle.loads, in_contact.study.speed.rpm
    cycle, *beside = (
        in_contact.crank_cycle(rpm * part) for part in (1.0, 1 - apart, (2 - (1 - apart) ** 2) ** 0.5)
    )
    like = [(0.5, loads.sampled(one.degrees, one)) for one in beside] if apart else []
    exact, estimated = loads.weights(cycle.degrees, cycle), loads.sampled(cycle.degrees, cycle, like)
    apart = np.concatenate(exact) - np.concatenate(estimated.weights)
    length, largest = np.linalg.norm(apart, axis=0), np.linalg.norm(np.concatenate(exact), axis=0).max()
    assert (length <= estimated.error * (1 + 1e-6) + 1e-9 * largest).all()
    between = estimated.error > 0
    assert between.mean() > 0.7
    assert np.median(estimated.error[between]) < 0.01 * largest
    patterns = [one[:-2] - other[:-2] for one, other in zip(exact, estimated.weights, strict=True)]
    resultants = np.concatenate(loads.balanced()).T @ np.concatenate(patterns)
    assert np.abs(resultants).max() < 1e-9 * largest


@pytest.mark.parametrize("rpm", [1000.0, 8777.0])
def test_bounds_are_never_below_what_they_bound(rod, search, rpm):
    weights = rod.cycle.weights(rod.crank_cycle(rpm), cycle_angles())
    sampled, none = search._sample(rpm), np.zeros(0)
    cycle = EstimatedCycle(rpm, cycle_angles(), sampled, none, weights.at(slice(0)))
    (bound,) = (own.max(axis=1) for own in search._in_sectors(cycle))
    (part,) = search._parts
    some = np.arange(0, len(bound), 7)
    at_degrees = np.linalg.norm(part.stress(weights, some)[:, :5], axis=1).max(axis=1)
    assert (bound[some] >= at_degrees * (1 - 1e-9)).all()
    assert np.median(bound[some] / at_degrees) < 1.3  # and yet of use


@pytest.mark.parametrize("criterion", list(Fatigue))
def test_no_history_of_that_size_is_nearer_to_fatigue(rod, criterion):
    rng = np.random.default_rng(5)
    highest, lowest = np.sort(rng.uniform(-400, 400, (2, 5000)), axis=0)[::-1]
    part = object.__new__(PartRows)
    part.material, part._criterion = rod.materials[0], criterion
    part._surface = rng.uniform(0.2, 1.1, 5000)  # of each place another finish
    factors = part.fatigue_factor(highest, lowest, np.arange(5000))
    assert (part.fatigue_bound(np.maximum(np.abs(highest), np.abs(lowest))) <= factors * (1 + 1e-12)).all()


def test_few_places_are_looked_at_where_inertia_rules(search, monkeypatch):
    looked = []

    def counted(part, rows, *others):
        looked.append(len(rows))
        return judged(part, rows, *others)

    monkeypatch.setattr("fea.analysis.cycle.search.judged", counted)
    search.at(7000.0)
    assert 0 < sum(looked) < 0.1 * sum(len(part.points) for part in search._parts)


def test_superposed_peaks_are_those_solved_directly(rod, search):
    direct, found = with_cycle(rod, solve_speed(rod, 5000.0)), search.at(5000.0)
    for one, other in zip(direct.cases.values(), found.peaks, strict=True):
        assert other.max_von_mises_MPa == pytest.approx(one.von_mises.max(), rel=5e-3)
        assert other.min_safety_factor == pytest.approx(one.safety_factor.min(), rel=5e-3)
        assert other.max_principal_MPa == pytest.approx(one.principal[:, 0].max(), rel=5e-3)
        assert other.min_principal_MPa == pytest.approx(one.principal[:, 2].min(), rel=5e-3)


def test_a_critical_speed_does_not_depend_on_the_speeds_asked_for(rod):
    # Straight lines between 0 and 20 000 rpm would make it 2.2 times what it is.
    few, near = SpeedSweep(rod, [20_000.0, 0.0]).critical, SpeedSweep(rod, [3000.0, 6500.0]).critical
    for mode in ("yield", "fatigue", "crossland"):
        assert 3000 < near[mode] < 6500
        assert few[mode] == pytest.approx(near[mode], abs=0.3)


def test_the_worst_place_is_known_where_every_factor_is_capped(rod):
    # At 9000 rpm without gas stress is that of 3 rpm times 9e6, at the same place.
    one, other = (
        SpeedSearch(rod.cycle, lambda rpm: replace(rod.crank_cycle(rpm), gas=NoGas()), [rpm]).at(rpm).yielding
        for rpm in (9000.0, 3.0)
    )
    assert other.factor == CAP
    np.testing.assert_array_equal(other.figures.at_mm, one.figures.at_mm)
    assert other.figures.amplitude_MPa == pytest.approx(one.figures.amplitude_MPa / 9e6, rel=1e-6)
