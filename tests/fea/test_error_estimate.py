"""Estimated errors against true ones: Zienkiewicz & Zhu's effectivity, and bars that must hold the truth."""

import dataclasses
from functools import cache

import numpy as np
import pytest
from exact_bodies import HEIGHT, MATERIAL, PROBLEMS, solved

from fea.assess.verdict import peak
from fea.choices import Symmetry
from fea.machine.clock import Clock
from fea.material import Material
from fea.pipeline import Analysis
from fea.solid.element import tabulate
from fea.solid.error_estimate import ErrorEstimator, sagitta
from fea.solid.integration import gauss_block
from fea.solid.recovery import ElementStress, Recovery, reference_nodes
from fea.solid.stress import von_mises
from fea.study.study import MeshTable, load_study
from fea.verify.body import STEEL
from fea.verify.cases import manufactured
from geometry.bodies.shape import block
from geometry.surfaces import Surface
from mesh.body import mesh_body
from mesh.refined import refined
from mesh.tetmesh import TetMesh


def energy(stress, volumes, material: Material) -> float:
    """∫ σ : C⁻¹ σ of stress (n_elements, n_places, 6)."""
    trace = stress[..., :3].sum(axis=-1)
    square = (stress[..., :3] ** 2).sum(axis=-1) + 2 * (stress[..., 3:] ** 2).sum(axis=-1)
    E, nu = material.youngs_modulus, material.poissons_ratio
    return float((volumes * ((1 + nu) * square - nu * trace**2) / E).sum())


def effectivity(mesh: TetMesh, u, stress, exact, material: Material) -> float:
    """Estimated over true error in the energy norm."""
    table = tabulate(mesh.tets.shape[1], 4)
    places = (table.values @ mesh.points[mesh.tets]).reshape(-1, 3)
    raw = ElementStress(mesh, table.values @ reference_nodes(mesh.tets.shape[1]))(u, material)[..., 0]
    volumes = gauss_block(mesh.points[mesh.tets], table).volumes
    true = energy(raw - exact(places).reshape(raw.shape), volumes, material)
    return np.sqrt(ErrorEstimator(mesh, (material,))(u, [stress]).energy.sum() / true)


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize(("order", "size"), [(2, 0.5), (2, 0.3), (2, 0.2), (1, 0.3), (1, 0.2)])
def test_the_energy_estimate_is_near_the_true_error_and_rather_above(name, order, size):
    found = solved(name, size, order=order)
    stress = found.stress[:, :, None]
    assert 0.9 < effectivity(found.mesh, found.displacement, stress, found.problem.stress, MATERIAL) < 2


@pytest.mark.parametrize("order", [1, 2])
def test_the_energy_estimate_holds_on_a_manufactured_solution(order):
    mesh = refined(mesh_body(block(1.0, 1.0, 1.0), 0.25, order=order))
    u = manufactured._solved(mesh)[:, :, None]
    stress = Recovery(mesh).nodal_stress(u, STEEL)

    def exact(places):
        slope = manufactured.exact_gradient(places)
        strain = (slope + slope.transpose(0, 2, 1)) / 2
        lam, mu = STEEL.lame_lambda, STEEL.shear_modulus
        tensor = 2 * mu * strain + lam * np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        return tensor.reshape(-1, 9)[:, [0, 4, 8, 1, 5, 2]]

    assert 0.9 < effectivity(mesh, u, stress, exact, STEEL) < 2


@cache
def rod(size: float):
    """Mesh, material and tension of the rod."""
    study = load_study()
    analysis = Analysis(dataclasses.replace(study, mesh=MeshTable(size_mm=size)), Clock())
    (case,) = (case for case in analysis.at(6000.0).cases if case.case.name == "tension")
    return analysis.mesh.whole.mesh, analysis.materials[0], case


def strain_energy(size: float) -> float:
    """∫ σ : C⁻¹ σ of the finite-element stress of the whole rod."""
    mesh, material, case = rod(size)
    table = tabulate(10, 2)
    volumes = gauss_block(mesh.points[mesh.tets], table).volumes
    return energy(ElementStress(mesh)(case.displacement[:, :, None], material)[..., 0], volumes, material)


def test_the_energy_estimate_holds_on_the_rod():
    # Galerkin: the error's energy is what the solution's lacks, here of a finer mesh's with its own error.
    coarse, fine = strain_energy(9.0), strain_energy(4.2)
    missing = (rod(4.2)[2].error.energy_percent / 100) ** 2
    estimated = rod(9.0)[2].error.energy_percent / 100
    least, most = np.sqrt(1 - coarse / fine), np.sqrt(1 - coarse / fine + missing)
    assert 0.9 * most < estimated < 2 * least


def test_a_rods_bar_holds_the_peak_of_a_finer_mesh():
    coarse, fine = rod(9.0)[2].peak, rod(4.2)[2].peak
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
    study = dataclasses.replace(load_study(), mesh=MeshTable(size_mm=12.0))
    whole = dataclasses.replace(study, analysis=dataclasses.replace(study.analysis, symmetry=Symmetry.NONE))
    analysis = Analysis(study, Clock())
    mesh = analysis.mesh.whole.mesh
    cases = zip(analysis.at(6000.0).cases, Analysis(whole, Clock()).at(6000.0).cases, strict=True)
    for quarter, full in cases:
        assert quarter.error_percent == pytest.approx(full.error_percent, rel=1e-3)
        assert quarter.error.energy_percent == pytest.approx(full.error.energy_percent, rel=1e-3)
        # Amid the plane y = 0 the quarter takes the larger of its sides, the whole their mean.
        aside = np.abs(mesh.points[:, 1]) > 1e-9
        assert quarter.von_mises_error[aside] == pytest.approx(full.von_mises_error[aside], rel=1e-3)
