import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strap import LENGTH, SMALL_BORE, WIDTH, strap

from fea.solid.bore import bore_facets, bore_load, parts_within
from geometry.surfaces import Surface
from loads.bearing import BorePressure
from mesh.tetmesh import reflect, unmirrored

CELLS = {
    "quarter": unmirrored(strap()).mesh,
    "half": reflect(unmirrored(strap()), Surface.SYMMETRY_Y).mesh,
    "whole": reflect(reflect(unmirrored(strap()), Surface.SYMMETRY_Y), Surface.SYMMETRY_Z).mesh,
}
ARCS = ["cosine-180", "uniform-120", "cosine-90", "uniform-60"]


def loaded(facets, mesh, force, shape, peak):
    return bore_load(
        facets, len(mesh.points), force, lambda psi: peak * shape.unbounded(psi), shape.angle / 2
    )


@settings(max_examples=40, deadline=None)
@given(
    cell=st.sampled_from(sorted(CELLS)),
    arc=st.sampled_from(ARCS),
    direction=st.floats(-np.pi, np.pi),
    magnitude=st.floats(1e-3, 1e6),
)
def test_the_resultant_is_the_force_and_passes_through_the_axis(cell, arc, direction, magnitude):
    mesh, shape = CELLS[cell], BorePressure.parse(arc).tension
    force = magnitude * np.array([np.cos(direction), np.sin(direction)])
    peak = shape.peak(magnitude, SMALL_BORE, WIDTH)
    facets = bore_facets(mesh, Surface.SMALL_END_BORE, LENGTH)
    load = bore_load(
        facets, len(mesh.points), tuple(force), lambda psi: peak * shape.unbounded(psi), shape.angle / 2
    )
    images = (2 if facets.cut_y else 1) * (2 if facets.cut_z else 1)
    even = load.forces.symmetric
    odd = even if load.forces.antisymmetric is None else load.forces.antisymmetric
    resultant = images * np.array([even[:, 0].sum(), odd[:, 1].sum()])
    assert resultant == pytest.approx(force, abs=1e-10 * magnitude)
    x, y = mesh.points[:, 0] - LENGTH, mesh.points[:, 1]
    moment = images * (x @ odd[:, 1] - y @ odd[:, 0])
    # the traction is radial at each point, and isoparametric nodal forces keep its moment
    assert abs(moment) < 1e-10 * magnitude * LENGTH
    # arcs end in the right place on a mesh this coarse too
    assert load.scale == pytest.approx(1, abs=0.01)


def test_half_cosine_meets_the_closed_form():
    # p0 = 2P/(pi R b) (Webster et al. 1983) needs no correction on a fine bore
    mesh, shape = strap(size=1.5), BorePressure.parse("cosine-180").tension
    facets = bore_facets(mesh, Surface.SMALL_END_BORE, LENGTH)
    peak = 2 * 5000 / (np.pi * SMALL_BORE * WIDTH)
    load = bore_load(
        facets, len(mesh.points), (5000.0, 0.0), lambda psi: peak * shape.unbounded(psi), shape.angle / 2
    )
    assert load.scale == pytest.approx(1, abs=1e-4)


@pytest.mark.parametrize("cell", sorted(CELLS))
def test_an_arc_ending_at_a_quadrature_point_leaves_no_doubt(cell):
    mesh, shape = CELLS[cell], BorePressure.parse("uniform-60").tension
    facets = bore_facets(mesh, Surface.SMALL_END_BORE, LENGTH)
    forces = []
    for turn in (-1e-12, 1e-12):
        direction = facets.angle[3, 3] - shape.angle / 2 + turn
        force = (1000 * np.cos(direction), 1000 * np.sin(direction))
        forces.append(loaded(facets, mesh, force, shape, 1.0).forces.symmetric)
    assert forces[0] == pytest.approx(forces[1], abs=1e-7)


def test_parts_of_triangles_between_two_values_have_their_area():
    # x + y within 0.4…0.8 of the unit triangle: (0.8² − 0.4²)/2; the strip off its third corner likewise
    owner, parts = parts_within(np.array([[-0.6, 0.4, 0.4], [5.0, 6.0, 7.0], [-0.1, 0.1, 0.0]]), 0.2)
    area = np.abs(np.linalg.det(parts[:, 1:] - parts[:, :1])) / 2
    assert area[owner == 0].sum() == pytest.approx((0.8**2 - 0.4**2) / 2, rel=1e-12)
    assert not (owner == 1).any()
    assert area[owner == 2].sum() == pytest.approx(0.5, rel=1e-12)


def test_no_force_no_load():
    mesh = CELLS["quarter"]
    facets = bore_facets(mesh, Surface.SMALL_END_BORE, LENGTH)
    load = bore_load(facets, len(mesh.points), (0.0, 0.0), lambda psi: psi, np.pi / 2)
    assert not load.forces.symmetric.any()
    assert not load.forces.antisymmetric.any()
