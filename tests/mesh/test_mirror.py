import numpy as np
import pytest
from strap import strap

from geometry.surfaces import Surface
from mesh.quality import scaled_jacobian
from mesh.tetmesh import EDGES, reflect, unmirrored


@pytest.fixture(scope="module")
def whole():
    return reflect(reflect(unmirrored(strap()), Surface.SYMMETRY_Y), Surface.SYMMETRY_Z)


def test_reflected_elements_keep_their_orientation_and_quality(whole):
    cell = scaled_jacobian(strap())
    assert scaled_jacobian(whole.mesh) == pytest.approx(cell[whole.element_source], rel=1e-9)


def test_mid_edge_nodes_stay_between_their_vertices(whole):
    mesh, cell = whole.mesh, strap()
    for middle, (a, b) in enumerate(EDGES, start=4):
        away = np.linalg.norm(
            mesh.points[mesh.tets[:, middle]] - mesh.points[mesh.tets[:, [a, b]]].mean(axis=1), axis=1
        )
        edge = np.linalg.norm(mesh.points[mesh.tets[:, a]] - mesh.points[mesh.tets[:, b]], axis=1)
        assert (away / edge).max() < 0.2  # curved edges bulge, wrong ones are a whole edge off
    assert len(mesh.tets) == 4 * len(cell.tets)


def test_no_node_is_doubled_and_the_cut_planes_are_gone(whole):
    assert len(np.unique(np.round(whole.mesh.points, 9), axis=0)) == len(whole.mesh.points)
    assert Surface.SYMMETRY_Y not in whole.mesh.facets
    assert Surface.SYMMETRY_Z not in whole.mesh.facets
    assert len(whole.mesh.facets[Surface.BIG_END_BORE]) == 4 * len(strap().facets[Surface.BIG_END_BORE])


def test_fields_are_carried_as_their_mirror_images(whole):
    x, y, z = strap().points.T
    even = np.stack([x * y**2, y, x * z], axis=1)  # mirrored about y and z: u_y odd in y, u_z odd in z
    odd = np.stack([y, x, y * z], axis=1)
    carried = whole.vector(even, odd)
    x, y, z = whole.mesh.points.T
    exact = np.stack([x * y**2 + y, y + x, x * z + y * z], axis=1)
    assert carried == pytest.approx(exact, rel=1e-12, abs=1e-9)


def test_a_tensor_is_carried_like_the_product_of_two_vectors(whole):
    x, y, z = strap().points.T
    tensor = np.stack([x, y**2, z**2, x * y, y * z, x * z], axis=1)
    x, y, z = whole.mesh.points.T
    exact = np.stack([x, y**2, z**2, x * y, y * z, x * z], axis=1)
    assert whole.tensor(tensor) == pytest.approx(exact, rel=1e-12, abs=1e-9)
