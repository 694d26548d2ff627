import numpy as np
import pytest

from geometry.bodies import block
from geometry.surfaces import Surface
from mesh.generate import LocalSize, mesh_body
from mesh.quality import scaled_jacobian, shape
from mesh.tetmesh import raised, refined


def area(mesh):
    a, b, c = mesh.points[mesh.facets[Surface.FREE][:, :3]].transpose(1, 0, 2)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


@pytest.mark.parametrize("order", [1, 2])
def test_eight_conforming_elements_of_each(order):
    coarse = mesh_body(block(1.0, 2.0, 3.0), 0.8, order=order)
    fine = refined(coarse)
    assert fine.order == order
    assert len(fine.tets) == 8 * len(coarse.tets)
    assert scaled_jacobian(fine).min() > 0
    assert area(fine) == pytest.approx(22.0)
    # Every face belongs to two elements or to the boundary: nothing hangs.
    faces = np.sort(fine.tets[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3), axis=1)
    _, count = np.unique(faces, axis=0, return_counts=True)
    assert set(count) == {1, 2}
    assert (count == 1).sum() == len(fine.facets[Surface.FREE])
    assert len(np.unique(fine.points.round(9), axis=0)) == len(fine.points)


def test_shapes_stay_however_often():
    mesh = mesh_body(block(1.0, 1.0, 1.0), 0.6, order=1)
    worst = []
    for _ in range(4):
        worst.append(shape(mesh).min())
        mesh = refined(mesh)
    # Cut along a fixed diagonal, the worst shape would lose a third at every step.
    assert worst[-1] > 0.8 * worst[1]


def test_raising_agrees_with_gmsh():
    first, second = (mesh_body(block(1.0, 1.0, 1.0), 0.5, order=order) for order in (1, 2))
    ours = raised(first)
    assert len(ours.points) == len(second.points)
    np.testing.assert_allclose(
        ours.points[ours.tets].sum(axis=(0, 1)), second.points[second.tets].sum(axis=(0, 1))
    )
    facets = ours.facets[Surface.FREE]
    middles = ours.points[facets[:, [0, 1, 2]]] + ours.points[facets[:, [1, 2, 0]]]
    np.testing.assert_allclose(ours.points[facets[:, 3:]], middles / 2, atol=1e-15)


def test_fine_surfaces_have_smaller_elements():
    corners = block(10.0, 10.0, 10.0)
    plain, fine = mesh_body(corners, 4.0), mesh_body(corners, 4.0, fine={Surface.FREE: LocalSize(1.0)})
    assert len(fine.tets) > 3 * len(plain.tets)
