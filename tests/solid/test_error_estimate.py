"""Estimated errors against true ones: Zienkiewicz & Zhu's effectivity, and bars that must hold the truth."""

import dataclasses

import numpy as np
import pytest
from energy_errors import effectivity, manufactured_effectivity, nest, nested, rod, rod_effectivity
from exact_bodies import HEIGHT, MATERIAL, PROBLEMS, solved

from fea.analysis.pipeline import prepare, solve_speed
from fea.base.choices import Symmetry
from fea.judge.verdict import peak
from fea.solid.assembly import gauss_block, tabulate
from fea.solid.error_estimate import ErrorEstimator, sagitta
from fea.solid.recovery import Recovery
from fea.solid.stress import von_mises
from fea.study.flags import Flags
from fea.study.study import load_study
from fea.verify.cases import dynamics, nafems
from geometry.bodies import block
from geometry.surfaces import Surface
from mesh.generate import mesh_body

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize(("order", "size"), [(2, 0.5), (2, 0.3), (2, 0.2), (1, 0.3), (1, 0.2)])
def test_the_energy_estimate_is_near_the_true_error_and_rather_above(name, order, size):
    found = solved(name, size, order=order)
    stress = found.stress[:, :, None]
    assert 0.9 < effectivity(found.mesh, found.displacement, stress, found.problem.stress, MATERIAL) < 2


@pytest.mark.parametrize("order", [1, 2])
def test_the_energy_estimate_holds_on_a_manufactured_solution(order):
    assert 0.9 < manufactured_effectivity(0.25, order) < 2


def test_nested_meshes_have_one_geometry_and_ever_more_energy():
    coarse = nafems.plate_mesh(6.0)
    fine = nested(coarse)
    whole, parts = (gauss_block(mesh.points[mesh.tets], tabulate(10, 4)).volumes for mesh in (coarse, fine))
    assert parts.sum() == pytest.approx(whole.sum(), rel=1e-12)
    assert parts.reshape(len(whole), -1).sum(axis=1) == pytest.approx(whole.sum(axis=1), rel=1e-9)
    assert fine.facets.keys() == coarse.facets.keys()


def test_the_energy_estimate_holds_where_the_exact_energy_is_extrapolated():
    found = nest("plate with a hole", size=6.0)
    assert (np.diff(found.energy) > 0).all()
    assert 1.2 < found.rate < 2.5
    ratio = found.effectivity()[:2]
    assert (ratio > 0.9).all()
    assert (ratio < 2).all()


def test_the_energy_estimate_holds_on_the_rod():
    least, most = rod_effectivity(10.5, 4.8)
    assert least > 0.9
    assert most < 2


def test_a_rods_bar_holds_the_peak_of_a_finer_mesh():
    coarse, fine = rod(10.5)[2].peak, rod(4.8)[2].peak
    assert abs(fine.value - coarse.value) < coarse.bar
    assert coarse.error_percent < 25
    assert fine.bar < 0.7 * coarse.bar


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("size", [0.5, 0.3, 0.2])
def test_the_bar_holds_the_exact_peak(name, size):
    found = solved(name, size)
    inner = np.unique(found.mesh.facets[Surface.BIG_END_BORE])
    exact = von_mises(found.problem.stress(found.mesh.points[inner])).max()
    stress = found.stress[:, :, None]
    error = ErrorEstimator(found.mesh, (MATERIAL,))(found.displacement, [stress]).stress[0][:, 0]
    away = found.mesh.points[:, 2] > 0.6 * HEIGHT if found.problem.flat_end else None
    bar = peak(von_mises(found.stress), error, away)
    assert abs(exact - bar.value) < bar.bar < 0.4 * bar.value


def test_the_error_is_larger_by_the_pressure_on_a_bore():
    found = solved("lame", 0.3)
    stress, facets = found.stress[:, :, None], found.mesh.facets
    inner = facets[Surface.BIG_END_BORE]
    others = {surface: those for surface, those in facets.items() if surface is not Surface.BIG_END_BORE}
    outside = np.concatenate([inner, facets[Surface.FREE]])
    nameless = dataclasses.replace(found.mesh, facets={**others, Surface.FREE: outside})
    pressed, free = (
        ErrorEstimator(mesh, (MATERIAL,))(found.displacement, [stress]).stress[0][:, 0]
        for mesh in (found.mesh, nameless)
    )
    bore = np.setdiff1d(inner, others[Surface.SMALL_END_BORE])
    larger = 1 + found.problem.pressure / von_mises(found.stress)[bore]
    assert pressed[bore] / free[bore] == pytest.approx(larger, rel=0.01)
    away = np.setdiff1d(np.arange(len(free)), facets[Surface.BIG_END_BORE])
    away = np.setdiff1d(away, others[Surface.SMALL_END_BORE])
    assert (pressed[away] == free[away]).all()


def test_the_bar_holds_a_peak_inside_the_body():
    found = dynamics.spun_disc(dynamics.disc_mesh(20.0))
    stress = found.stress[:, :, None]
    error = ErrorEstimator(found.mesh, (found.material,))(found.displacement, [stress]).stress[0][:, 0]
    bar = peak(von_mises(found.stress), error)
    assert abs(dynamics.DISC_CENTRE - bar.value) < bar.bar < 0.03 * bar.value


def test_a_linear_displacement_has_no_error():
    found = solved("lame", 0.5)
    u = (found.mesh.points @ np.array([[1, 2, 0], [0, 1, 3], [2, 0, 1]]) * 1e-3)[:, :, None]
    recovery = Recovery(found.mesh)
    estimate = ErrorEstimator(found.mesh, (MATERIAL,))(u, [recovery.nodal_stress(u, MATERIAL)])
    assert estimate.energy.sum() < 1e-20 * estimate.solution.sum()
    assert np.nanmax(estimate.stress[0]) < 1e-9 * MATERIAL.youngs_modulus * 1e-3


def test_the_sagitta_is_what_a_quadratic_has_amid_an_edge():
    mesh = mesh_body(block(1.0, 1.0, 1.0), 0.6)
    stress = np.zeros((len(mesh.points), 6, 1))
    stress[:, 0, 0] = mesh.points[:, 0] ** 2
    spans = [np.ptp(mesh.points[mesh.tets[:, [a, b]], 0], axis=1) for a, b in ((0, 1), (1, 2), (0, 2))]
    longest = max(span.max() for span in spans)
    assert sagitta(mesh.tets, stress).max() >= longest**2 / 4 * (1 - 1e-9)


def test_mirror_planes_and_parities_do_not_change_the_bars():
    study = Flags(size=12.0, pressure="cosine-180").applied(load_study())
    whole = dataclasses.replace(study, analysis=dataclasses.replace(study.analysis, symmetry=Symmetry.NONE))
    analysis = prepare(study)
    mesh = analysis.mesh.whole
    on_plane = np.flatnonzero(np.abs(mesh.points[:, 1]) < 1e-9)
    touching = np.unique(mesh.tets[np.isin(mesh.tets, on_plane).any(axis=1)])
    found = (solve_speed(rod, 6000.0).cases.values() for rod in (analysis, prepare(whole)))
    cases = zip(*found, strict=True)
    for quarter, full in cases:
        assert quarter.error_percent == pytest.approx(full.error_percent, rel=2e-3)
        assert quarter.error.energy_percent == pytest.approx(full.error.energy_percent, rel=1e-3)
        # Amid the plane y = 0 the quarter takes the larger of its sides, the whole their mean.
        aside = np.setdiff1d(np.arange(len(mesh.points)), touching)
        assert quarter.von_mises_error[aside] == pytest.approx(full.von_mises_error[aside], rel=1e-3)
