import numpy as np
import pytest

from geometry.bodies import block, draw
from geometry.session import session
from mesh.generate import mesh_body, tetrahedralise
from mesh.sizing import SizeField, Sizing
from mesh.tetmesh import EDGES

BODY = block(10.0, 10.0, 10.0)


def lengths_near(mesh, place, radius):
    """Edge lengths of the elements whose centres are near a place."""
    near = np.linalg.norm(mesh.points[mesh.tets[:, :4]].mean(axis=1) - place, axis=1) < radius
    tets = mesh.tets[near]
    return np.concatenate(
        [np.linalg.norm(mesh.points[tets[:, a]] - mesh.points[tets[:, b]], axis=1) for a, b in EDGES]
    )


@pytest.fixture(scope="module")
def coarse():
    return mesh_body(BODY, 3.0)


def remeshed(field, size=3.0):
    with session():
        mesh, _ = tetrahedralise(draw(BODY), (), Sizing(size), wanted=[field])
    return mesh


def test_elements_follow_the_wanted_sizes(coarse):
    corner = np.linalg.norm(coarse.points, axis=1) < 3.5
    field = SizeField(coarse.points, coarse.tets[:, :4], np.where(corner, 0.7, 1e6))
    fine = remeshed(field)
    assert np.median(lengths_near(fine, [0, 0, 0], 2.0)) == pytest.approx(0.8, rel=0.25)
    assert np.median(lengths_near(fine, [10, 10, 10], 3.0)) > 2
    assert len(fine.tets) > 1.7 * len(coarse.tets)


def test_sizes_that_are_larger_bind_nobody(coarse):
    field = SizeField(coarse.points, coarse.tets[:, :4], np.full(len(coarse.points), 50.0))
    assert len(remeshed(field).tets) == pytest.approx(len(coarse.tets), rel=0.1)


def test_graded_sizes_grow_no_faster_than_asked(coarse):
    size = np.full(len(coarse.points), 1e6)
    small, large = coarse.tets[0, 0], coarse.tets[-1, 0]
    size[[small, large]] = 0.5, 1.0
    graded = SizeField(coarse.points, coarse.tets[:, :4], size).graded(0.4)
    vertices = np.unique(coarse.tets[:, :4])
    from_small, from_large = (
        np.linalg.norm(coarse.points[vertices] - coarse.points[seed], axis=1) for seed in (small, large)
    )
    expected = np.minimum(0.5 + 0.4 * from_small, 1.0 + 0.4 * from_large)
    assert graded.size[vertices] == pytest.approx(expected)
