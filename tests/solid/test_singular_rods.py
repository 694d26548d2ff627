"""Which rods have singular places: clamped ones, and no others."""

import dataclasses

import pytest
from rod_studies import random_rod

from fea.analysis.meshing import mesh_study
from fea.analysis.pipeline import prepare, solve_speed
from fea.analysis.summary import case_figures
from fea.judge.verdict import peak
from fea.solid.error_estimate import ErrorEstimator
from fea.solid.recovery import Recovery
from fea.solid.singular import BoundaryEdges, masked_nodes
from fea.solid.stress import von_mises
from fea.solid.traction import traction_forces
from fea.solvers.static import displacement
from fea.study.option_tables import MeshTable
from fea.study.rod_table import RodTable
from fea.study.study import Study, load_study
from fea.verify.body import STEEL, held
from geometry.bodies import Prism, polygon
from geometry.errors import InvalidValue
from geometry.surfaces import Surface
from mesh.generate import mesh_body

pytestmark = pytest.mark.slow


RODS = 3


def drawn_rods():
    """The first `RODS` seeds whose rod is allowed."""
    allowed = (seed for seed in range(1000) if not isinstance(random_rod(seed), InvalidValue))
    return [next(allowed) for _ in range(RODS)]


@pytest.mark.parametrize("name", ["leon-2001", "columba-2022", "molina-2024"])
def test_no_shipped_rod_can_diverge_at_its_default_size(name):
    cell = mesh_study(load_study(name)).cell
    assert not masked_nodes(cell, BoundaryEdges(cell).singular_nodes()).any()
    assert masked_nodes(cell, BoundaryEdges(cell).singular_nodes((Surface.BIG_END_BORE,))).any()


@pytest.mark.parametrize("seed", drawn_rods())
def test_no_rod_drawn_at_random_can(seed):
    rod = random_rod(seed)
    cell = mesh_study(Study("drawn", RodTable(rod, None, None, rod.length))).cell
    assert not masked_nodes(cell, BoundaryEdges(cell).singular_nodes()).any()


def test_the_clamped_rods_edge_is_told_as_diverging_while_the_peak_elsewhere_is_judged():
    study = dataclasses.replace(load_study("leon-2001-as-published"), mesh=MeshTable(size_mm=9.0))
    rod = prepare(study)
    case = solve_speed(rod, None).cases["given"]
    told = case_figures(rod, case)
    assert told.singular_where == "big-end bore's edge"
    assert told.singular_verdict == told.unmasked_verdict == "diverging"
    assert told.verdict in ("converged", "not converged")
    assert told.singular_max_von_mises_MPa == case.peak.singular > 100
    assert case.peak.singular < case.peak.value == case.peak.unmasked


@pytest.mark.parametrize("order", [1, 2])
def test_a_clamped_bar_diverges(order):
    sides = (
        ((0.0, 0.0), Surface.FREE),
        ((40.0, 0.0), Surface.LOADED),
        ((40.0, 10.0), Surface.FREE),
        ((0.0, 10.0), Surface.CLAMPED),
    )
    mesh = mesh_body(Prism(polygon(*sides), (0.0, 10.0)), 2.0, order=order)
    forces = traction_forces(mesh, Surface.LOADED, lambda _, normals: 100.0 * normals)
    u = displacement(mesh, STEEL, forces, held(mesh, {Surface.CLAMPED: (0, 1, 2)}))
    stress = Recovery(mesh, (), (Surface.FREE,)).nodal_stress(u, STEEL)
    error = ErrorEstimator(mesh, (STEEL,))(u, [stress]).stress[0][:, 0]
    found = peak(
        von_mises(stress[..., 0]),
        error,
        masked_nodes(mesh, BoundaryEdges(mesh).singular_nodes((Surface.CLAMPED,))),
    )
    assert found.diverges
    assert found.value == pytest.approx(100.0, rel=0.1)
    assert found.singular == found.unmasked


def test_a_coarse_smooth_rod_does_not():
    study = dataclasses.replace(load_study(), mesh=MeshTable(size_mm=14.0))
    cases = solve_speed(prepare(study), 6000.0).cases.values()
    assert not any(case.peak.diverges or case.worst.diverges for case in cases)
