import numpy as np
import pytest
from strap import strap

from mesh.quality import measure, scaled_jacobian, shape, with_straight_edges
from mesh.tetmesh import EDGES, TetMesh

REGULAR = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])


def single(vertices):
    middles = [(vertices[a] + vertices[b]) / 2 for a, b in EDGES]
    return TetMesh(np.vstack([vertices, middles]), np.arange(10)[None, :])


def oriented(vertices):
    turned = vertices[[0, 2, 1, 3]]
    return vertices if np.linalg.det(vertices[1:] - vertices[0]) > 0 else turned


def test_a_regular_element_is_perfect():
    mesh = single(oriented(REGULAR))
    assert shape(mesh)[0] == pytest.approx(1, rel=1e-12)
    assert scaled_jacobian(mesh)[0] == pytest.approx(1, rel=1e-12)


def test_the_jacobian_bound_holds_inside_and_is_reached_by_bending_an_edge():
    mesh = single(oriented(REGULAR))
    bent = mesh.points.copy()
    bent[4] += 0.3 * (bent[3] - bent[4])
    bound = scaled_jacobian(TetMesh(bent, mesh.tets))[0]
    assert bound < 0.7
    # sampled: never below the bound
    from fea.solid.assembly import jacobians, shape_functions

    places = np.random.default_rng(1).dirichlet(np.ones(4), 500)[:, 1:].T
    _, gradients = shape_functions(10, places)
    determinant = np.linalg.det(jacobians(bent[None], gradients))[0]
    mean = np.linalg.det(jacobians(bent[None], shape_functions(10, np.full((3, 1), 0.25))[1])).item()
    assert determinant.min() / mean > bound * 0.9


@pytest.mark.parametrize(("others", "keep"), [(1.0, True), (20.0, True), (1.0, False)])
def test_an_inverted_element_is_straightened_and_told(others, keep):
    mesh = single(oriented(REGULAR))
    bent = mesh.points.copy()
    bent[4] += 1.5 * (bent[3] - bent[4])
    points = np.concatenate([bent, 5.0 + others * mesh.points])
    broken = TetMesh(points, np.concatenate([mesh.tets, 10 + mesh.tets]))
    assert scaled_jacobian(broken)[0] < 0
    whole, numbers = with_straight_edges(broken, keep_bow=keep)
    assert numbers == (0,)
    if (
        keep and others == 1.0
    ):  # a straight edge would miss much of the volume of both: it stays bent, but less
        assert 0.05 < scaled_jacobian(whole)[0] < 0.9
    else:
        assert scaled_jacobian(whole)[0] == pytest.approx(1, rel=1e-12)


def test_an_element_inside_out_cannot_be_mended():
    whole, _ = with_straight_edges(single(oriented(REGULAR)[[0, 2, 1, 3]]))
    assert scaled_jacobian(whole)[0] < 0


def test_a_real_mesh_is_measured():
    quality = measure(strap())
    assert 0.05 < quality.least_scaled_jacobian <= 1
    assert 0.1 < quality.least_shape < quality.median_shape < 1
