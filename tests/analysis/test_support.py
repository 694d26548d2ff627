"""Support of the surface by gradients of stress, on a rod: where it is, and what it changes."""

from dataclasses import replace

import numpy as np
import pytest

from fea.analysis.cycle.figures import envelope_figures
from fea.analysis.pipeline import prepare, solve_speed, with_cycle
from fea.analysis.refinement import usage
from fea.base.choices import Region
from fea.judge.verdict import peak
from fea.study.material_table import MaterialTable
from fea.study.option_tables import MeshTable
from fea.study.study import load_study
from geometry.surfaces import Surface

RPM = 5000.0
FORGED = MaterialTable(preset="forged-steel-2005")


def run(*, support):
    base, material = load_study("leon-2001"), replace(FORGED, support=support)
    analysis = replace(base.analysis, cycle=True, pressure="cosine-180")
    rod = prepare(replace(base, material=material, mesh=MeshTable(size_mm=14.0), analysis=analysis))
    result = with_cycle(rod, solve_speed(rod, RPM))
    cases = tuple(result.cases.values())
    return rod, result.cycle, envelope_figures(result.cycle, rod, cases, RPM), cases


@pytest.fixture(scope="module")
def supported():
    return run(support=None)


def test_it_is_at_the_free_surface_and_not_in_the_bores(supported):
    rod, cycle, *_ = supported
    factor, mesh = cycle.regions.support(rod.materials[0]), rod.mesh.whole
    surface = np.unique(mesh.facets[Surface.FREE])
    raised = np.flatnonzero(factor > 1)
    assert np.isin(raised, surface).all()
    assert raised.size > 0.2 * surface.size
    assert not cycle.regions.touched[raised, list(Region).index(Region.BORES)].any()
    assert cycle.counts[raised].all()
    assert factor.max() < 1.25


def test_factors_with_and_without_it_are_those_of_two_runs(supported):
    rod, cycle, figures, _ = supported
    _, plain, without, _ = run(support=False)
    assert without.min_fatigue_safety_factor_without_support is None
    assert without.fatigue.support_factor is None
    least = figures.min_fatigue_safety_factor_without_support
    assert least == pytest.approx(without.min_fatigue_safety_factor, rel=1e-9)
    gain = cycle.envelope.fatigue_factor / plain.envelope.fatigue_factor
    support = cycle.regions.support(rod.materials[0])
    # A mean stress has its share of the factor, which support does not change: n is the most that is gained.
    assert (gain >= 1 - 1e-9).all()
    assert (gain <= support * (1 + 1e-9)).all()
    assert np.isclose(gain, support, rtol=1e-9)[cycle.envelope.mean <= 0].all()
    assert figures.fatigue.endurance_MPa == pytest.approx(
        figures.fatigue.support_factor
        * rod.materials[0].endurance_limit
        * cycle.regions.without_support().factors(rod.materials[0])[cycle.weakest.node]
    )


def test_a_tapered_shank_has_the_gradient_of_its_bending_and_little_under_tension(supported):
    """The flat middle of the shank: hardly any gradient, so that nothing is gained there."""
    rod, cycle, *_ = supported
    x, y, _ = rod.mesh.whole.points.T
    flat = np.unique(rod.mesh.whole.facets[Surface.FREE])
    flank = flat[
        (np.abs(x[flat] - 70.0) < 6) & (np.abs(y[flat]) > 0.98 * np.abs(y[np.abs(x - 70) < 6]).max())
    ]
    assert flank.size > 3
    assert cycle.regions.support(rod.materials[0])[flank].max() < 1.05


def test_the_bound_from_the_load_cases_has_it_as_well(supported):
    """Without it, a factor that is said to be *at most* 2.19 was 2.30 over the cycle."""
    rod, cycle, figures, cases = supported
    least, cases = {}, [case for case in cases if case.load.in_cycle]
    for with_support in (False, True):
        used, error = usage(rod, cases, with_support=with_support)
        least[with_support] = 1 / peak(used, error, ~cycle.counts).value
    judged = figures.min_fatigue_safety_factor
    assert least[False] < 0.99 * judged
    assert judged <= least[True] * (1 + 1e-3)  # every tenth degree tells the gradients over the cycle
    assert least[True] == pytest.approx(judged, rel=0.01)
