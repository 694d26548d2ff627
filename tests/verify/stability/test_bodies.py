"""Ingredients of the extreme cases: slivers, graded meshes and exact solutions."""

import numpy as np
import pytest

from fea.verify.stability import bodies
from fea.verify.stability.bodies import (
    BALL,
    BALL_SIZE,
    RING_BORE,
    RING_PRESSURE,
    beam,
    graded_sphere,
    ring_peak,
    with_sliver,
)
from mesh.quality import measure, shape
from mesh.tetmesh import EDGES


@pytest.mark.parametrize("least", [1e-2, 1e-6])
def test_a_sliver_has_the_shape_asked_for(least):
    whole = beam(1.0, order=2)
    mesh = with_sliver(whole, least)
    assert shape(mesh).min() == pytest.approx(least, rel=1e-3)
    assert measure(mesh).least_scaled_jacobian == pytest.approx(1, rel=1e-4)
    assert np.count_nonzero((mesh.points[:, :] != whole.points).any(axis=1)) > 4


def test_the_graded_mesh_grows_a_thousandfold():
    mesh = graded_sphere(1000.0)
    edges = EDGES
    lengths = np.linalg.norm(np.diff(mesh.points[mesh.tets[:, edges]], axis=2)[:, :, 0], axis=2)
    assert lengths.max() / lengths.min() > 1000
    assert np.linalg.norm(mesh.points, axis=1).max() == pytest.approx(BALL)
    assert lengths.max() < 2 * BALL_SIZE


def test_a_liner_of_the_same_material_is_none():
    """Then the two rings are one: Lame's cylinder in plane strain."""
    E, nu = 210e3, 0.3
    a, b, p = bodies.BORE, bodies.EYE, bodies.LINER_PRESSURE
    places = (a, bodies.INTERFACE)
    exact = [(1 + nu) / E * p * a**2 / (b**2 - a**2) * ((1 - 2 * nu) * r + b**2 / r) for r in places]
    assert bodies.liner_displacement(1.0) == pytest.approx(exact, rel=1e-12)


def test_a_thin_ring_bends_as_a_beam():
    """Moment q R^2/3 at the ends of the axes; the hoop force, a share t/R of that, is left out."""
    wall = 0.01
    radius = RING_BORE + wall / 2
    bending = 6 * RING_PRESSURE * radius**2 / 3 / wall**2
    plane_strain = np.sqrt(1 - 0.3 + 0.3**2)
    assert ring_peak(wall) == pytest.approx(plane_strain * bending, rel=1e-2)
