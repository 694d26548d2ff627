"""The worst place of many speeds, found without looking at every place, is that of looking at all."""

from dataclasses import replace

import numpy as np
import pytest
from cycles import analysis
from rod_studies import random_study

from fea.analysis.cycle import candidates
from fea.analysis.many_speeds import SpeedSearch, SpeedSweep
from fea.analysis.pipeline import prepare, solve_speed, with_cycle
from fea.base.choices import CONTACT, Region, Symmetry
from fea.base.material import Marin, SurfaceFinish
from fea.judge.fatigue import fatigue_factor
from fea.judge.history import deviatoric, extremes
from fea.judge.verdict import CAP
from fea.study.flags import Flags
from geometry.surfaces import Surface
from loads.gas import NoGas

pytestmark = [pytest.mark.usefixtures("coarse_bores"), pytest.mark.slow]

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
        cycle.weights(rod.crank_cycle(rpm), rod.engine.engine.cycle_angles),
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
    # The gradients of the highest speed support the surface at every speed.
    regions = rod.cycle.supported(rod.crank_cycle(9000.0)).regions
    surface = np.tile(regions.factors(material), 2)
    assert (surface > np.tile(rod.cycle.regions.factors(material), 2)).any()
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
        material = replace(rod.materials[0], marin=marin, support=False)
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


@pytest.fixture(scope="module")
def searched(in_contact):
    cell, top = in_contact.mesh.cell, in_contact.study.speed.rpm
    ends = [cell.facets[end].ravel() for end in (Surface.BIG_END_BORE, Surface.SMALL_END_BORE)]
    masked = ~np.isin(np.arange(len(cell.points)), np.concatenate(ends))
    cycle = replace(in_contact.full_cycle, masked=masked)
    return in_contact, cycle, SpeedSearch(cycle, in_contact.crank_cycle, [0.4 * top, top])


@pytest.mark.parametrize("share", [0.4, 0.73, 1.0])
def test_instants_and_places_under_contact_are_those_of_looking_at_all(in_contact, searched, share):
    """The bores alone count, where contact changes the stress most from instant to instant."""
    rpm, (rod, cycle, search) = share * in_contact.study.speed.rpm, searched
    exact = cycle.at(rod.crank_cycle(rpm), ()).envelope
    counts = cycle.counts[rod.mesh.mirrored.source]
    found = search.at(rpm)
    assert found.yielding.factor == pytest.approx(1 / exact.usage[counts].max(), rel=1e-4)
    assert found.fatigue.factor == pytest.approx(exact.fatigue_factor[counts].min(), rel=1e-4)
    at = found.fatigue.figures
    node = np.linalg.norm(rod.mesh.whole.points - at.at_mm, axis=1).argmin()
    assert at.crossland_safety_factor >= exact.crossland_factor[node] * (1 - 1e-4)
    assert at.crossland_safety_factor == pytest.approx(exact.crossland_factor[node], rel=0.05)


def test_a_worse_place_that_was_no_candidate_is_found_by_looking_again(rod, search, monkeypatch):
    """One candidate, the worst at a speed at which the gas decides, is not the worst where inertia does."""
    monkeypatch.setattr(candidates, "_MOST", 1)
    one = SpeedSearch(rod.cycle, rod.crank_cycle, [100.0])
    wrong = one.at(9000.0)
    assert wrong.yielding.factor > 1.01 * search.at(9000.0).yielding.factor
    while not one.confirmed(9000.0, one.at(9000.0)):
        pass
    assert one.at(9000.0).yielding.factor == pytest.approx(search.at(9000.0).yielding.factor, rel=1e-9)


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
