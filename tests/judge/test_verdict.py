import math
from dataclasses import replace

import numpy as np
import pytest

from fea.analysis.meshing import mesh_study
from fea.base.choices import CONVERGED_PERCENT
from fea.judge.case_error import CaseError
from fea.judge.case_result import CaseFields, case_result
from fea.judge.verdict import CAP, ConvergenceVerdict, peak, widened
from fea.solid.error_estimate import ErrorEstimator
from fea.solid.recovery import Recovery
from fea.solid.singular import BoundaryEdges, masked_nodes
from fea.solid.stress import von_mises
from fea.solid.traction import traction_forces
from fea.solvers.static import displacement
from fea.study.study import load_study
from fea.verify.body import STEEL, held
from geometry.bodies import Prism, Side, polygon
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from loads.instants import given
from mesh.generate import mesh_body
from mesh.tetmesh import TetMesh


def test_a_place_that_comes_second_counts_with_its_error():
    found = peak(np.array([100.0, 90.0, 10.0]), np.array([2.0, 20.0, 1.0]))
    assert (found.node, found.value, found.bar) == (0, 100.0, 10.0)
    assert found.error_percent == pytest.approx(10.0)
    assert found.verdict() is ConvergenceVerdict.NOT_CONVERGED
    assert found.verdict(12.0) is ConvergenceVerdict.CONVERGED


def test_the_bar_of_a_file_s_mesh_that_is_too_coarse_for_its_estimate_is_wider():
    wide = widened(np.array([340.0, 100.0]), np.array([0.173 * 340, 10.0]))
    assert wide[0] > 340 - 262  # AAYUS2004, first mesh and end
    assert wide[1] == 10.0  # less than 5 % of the peak
    assert widened(np.array([100.0]), np.array([10.0])) == pytest.approx(10.0 * 2**0.4)


def test_the_threshold_is_the_documented_one():
    def verdict(percent):
        return peak(np.array([100.0]), np.array([percent])).verdict()

    assert verdict(CONVERGED_PERCENT) is ConvergenceVerdict.CONVERGED
    assert verdict(CONVERGED_PERCENT + 0.1) is ConvergenceVerdict.NOT_CONVERGED


def test_a_masked_place_counts_in_the_unmasked_peak_only():
    value, error, masked = np.array([300.0, 100.0]), np.array([50.0, 1.0]), np.array([True, False])
    found = peak(value, error, masked)
    assert (found.node, found.value, found.unmasked) == (1, 100.0, 300.0)
    assert found.verdict() is ConvergenceVerdict.CONVERGED  # of the figure that is reported
    assert found.diverges
    assert peak(value, error, ~masked).verdict() is ConvergenceVerdict.NOT_CONVERGED


def test_no_stress_has_no_error():
    assert peak(np.zeros(3), np.zeros(3)).error_percent == 0


def test_where_hardly_any_stress_is_the_safety_factors_cap_hides_no_error_in_it():
    stress = np.zeros((3, 6))
    stress[:, 0] = [200.0, 1e-9, 0.0]
    error = CaseError((np.array([10.0, 300.0, 50.0]),), np.zeros(1), np.zeros(3, dtype=bool))
    mesh = TetMesh(np.zeros((3, 3)), np.zeros((0, 4), dtype=int))
    fields = CaseFields(displacement=np.zeros((3, 3)), error=error)
    found = case_result(given(1.0), mesh, fields, [stress], materials=[STEEL], rims=np.zeros(3, dtype=bool))
    assert found.worst.value == pytest.approx(200 / 400)
    assert found.worst.error_percent == pytest.approx(5.0)
    assert found.error_percent == pytest.approx(50.0)  # of the stress: 300 MPa may be hidden in the second


def test_a_lining_that_yields_does_not_end_a_rod():
    # Three nodes: of steel alone, of both parts, and of the bushing alone, which yields at 100 MPa.
    bushing = replace(STEEL, yield_strength=100.0, lining=True)
    stresses = [np.zeros((3, 6)), np.zeros((3, 6))]
    stresses[0][:, 0], stresses[1][:, 0] = (200.0, 50.0, np.nan), (np.nan, 90.0, 150.0)
    error = CaseError((np.full(3, 4.0), np.full(3, 4.0)), np.zeros(1), np.zeros(3, dtype=bool))
    fields = CaseFields(displacement=np.zeros((3, 3)), error=error)
    mesh = TetMesh(np.zeros((3, 3)), np.zeros((0, 4), dtype=int))
    rims = np.zeros(3, dtype=bool)
    found = case_result(given(1.0), mesh, fields, stresses, materials=[STEEL, bushing], rims=rims)
    np.testing.assert_allclose(found.safety_factor, [400 / 200, 100 / 90, 100 / 150])
    np.testing.assert_allclose(found.of_rod, [400 / 200, 400 / 50, CAP])
    assert found.min_safety_factor == 2.0
    assert found.worst.error_percent == pytest.approx(2.0)
    steel = case_result(
        given(1.0), mesh, fields, stresses, materials=[STEEL, replace(bushing, lining=False)], rims=rims
    )
    assert steel.min_safety_factor == pytest.approx(100 / 150)


def bracket(fillet: float) -> Prism:
    """An L whose inner corner is at (10, 10), sharp or rounded."""
    corners = (((0.0, 30.0), Surface.FREE), ((0.0, 0.0), Surface.FREE), ((30.0, 0.0), Surface.LOADED))
    if not fillet:
        inner = (((30.0, 10.0), Surface.FREE), ((10.0, 10.0), Surface.FREE), ((10.0, 30.0), Surface.CLAMPED))
        return Prism(polygon(*corners, *inner), (0.0, 4.0))
    r = 10 + fillet
    lines = [
        Side(Line((0.0, 30.0), (0.0, 0.0)), Surface.FREE),
        Side(Line((0.0, 0.0), (30.0, 0.0)), Surface.FREE),
        Side(Line((30.0, 0.0), (30.0, 10.0)), Surface.LOADED),
        Side(Line((30.0, 10.0), (r, 10.0)), Surface.FREE),
        Side(Arc((r, r), fillet, 1.5 * math.pi, -math.pi / 2), Surface.FREE),
        Side(Line((10.0, r), (10.0, 30.0)), Surface.FREE),
        Side(Line((10.0, 30.0), (0.0, 30.0)), Surface.CLAMPED),
    ]
    return Prism(tuple(lines), (0.0, 4.0))


def judged(fillet: float, order: int, size: float = 2.5):
    """Verdict on the bracket pulled sideways."""
    mesh = mesh_body(bracket(fillet), size, order=order)
    forces = traction_forces(
        mesh, Surface.LOADED, lambda places, _: np.tile([0.0, -1.0, 0.0], (len(places), 1))
    )
    u = displacement(mesh, STEEL, forces, held(mesh, {Surface.CLAMPED: (0, 1, 2)}))
    stress = Recovery(mesh, mesh.planes, (Surface.FREE,)).nodal_stress(u, STEEL)
    error = ErrorEstimator(mesh, (STEEL,))(u, [stress]).stress[0][:, 0]
    masked = masked_nodes(mesh, BoundaryEdges(mesh).singular_nodes((Surface.CLAMPED,)))
    return mesh, peak(von_mises(stress[..., 0]), error, masked)


@pytest.mark.parametrize("order", [1, 2])
def test_a_sharp_re_entrant_corner_diverges(order):
    _, found = judged(0.0, order, 1.5)
    assert found.diverges


@pytest.mark.parametrize("order", [1, 2])
def test_a_rounded_corner_does_not(order):
    mesh, found = judged(4.0, order)
    assert found.verdict(1e6) is ConvergenceVerdict.CONVERGED
    assert not found.diverges
    assert not BoundaryEdges(mesh).singular_nodes().size


def test_the_singular_places_are_the_corner_and_the_clamps_border():
    mesh, _ = judged(0.0, 2)
    x, y, _ = mesh.points[BoundaryEdges(mesh).singular_nodes()].T
    assert x.size
    assert (x, y) == (pytest.approx(10), pytest.approx(10))
    on_border = mesh.points[BoundaryEdges(mesh).singular_nodes((Surface.CLAMPED,))]
    clamped = on_border[on_border[:, 1] > 29]
    assert len(clamped)
    assert clamped[:, 1] == pytest.approx(30)
    outer = np.isclose(clamped[:, 0], 0) | np.isclose(clamped[:, 0], 10) | np.isclose(clamped[:, 2], 4)
    assert outer.all()


def test_the_rod_is_smooth_and_its_clamp_is_not():
    mesh = mesh_study(load_study()).cell
    assert not BoundaryEdges(mesh).singular_nodes().size
    border = mesh.points[BoundaryEdges(mesh).singular_nodes((Surface.BIG_END_BORE,))]
    assert len(border)
    assert border[:, 2] == pytest.approx(border[:, 2].max())
    assert not masked_nodes(mesh, BoundaryEdges(mesh).singular_nodes()).any()
    masked = mesh.points[masked_nodes(mesh, BoundaryEdges(mesh).singular_nodes((Surface.BIG_END_BORE,)))]
    assert np.linalg.norm(masked[:, :2], axis=1).max() < 1.5 * np.linalg.norm(border[:, :2], axis=1).max()
