import numpy as np
import pytest
from tet_blocks import block

from fea.solid.supports import components
from geometry.surfaces import Surface
from mesh.tetmesh import FACET_TURN, TetMesh, separated

SIDES = {(0, 1): (Surface.JOINT, Surface.JOINT_CAP)}


def two_blocks(order):
    """Two cubes side by side along x, with the facets at their ends."""
    file = block(order=order)
    part = (file.points[file.tets[:, :4], 0].mean(axis=1) > 1).astype(int)
    whole = TetMesh(file.points, file.tets, part=part)
    ends = {}
    for surface, x in ((Surface.FREE, 0.0), (Surface.OUTER, 2.0)):
        nodes = np.flatnonzero(whole.points[:, 0] == x)
        inside = np.isin(whole.tets, nodes)
        pairs = zip(whole.tets, inside, strict=True)
        count = 3 if order == 1 else 6
        ends[surface] = np.array([row[on] for row, on in pairs if on.sum() == count])
    return TetMesh(file.points, file.tets, ends, part)


@pytest.mark.parametrize("order", [1, 2])
def test_parts_lose_their_common_nodes(order):
    mesh = two_blocks(order)
    apart, origin = separated(mesh, SIDES)
    assert components(mesh).max() == 0
    assert components(apart).max() == 1
    np.testing.assert_array_equal(apart.points, mesh.points[origin])
    np.testing.assert_array_equal(apart.points[apart.tets], mesh.points[mesh.tets])
    for surface, facets in mesh.facets.items():
        np.testing.assert_array_equal(origin[apart.facets[surface]], facets)


@pytest.mark.parametrize("order", [1, 2])
def test_sides_match_facet_by_facet_and_face_each_other(order):
    apart, _ = separated(two_blocks(order), SIDES)
    one, other = apart.facets[Surface.JOINT], apart.facets[Surface.JOINT_CAP]
    turned = other[:, FACET_TURN[other.shape[1]]]
    np.testing.assert_array_equal(apart.points[one], apart.points[turned])
    assert not np.intersect1d(one, other).size
    a, b, c = apart.points[one[:, :3]].transpose(1, 0, 2)
    areas = np.cross(b - a, c - a)
    assert (areas[:, 0] > 0).all()  # away from the first block, which lies at smaller x
    assert areas.sum(axis=0) / 2 == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)


def test_parts_that_are_not_named_stay_joined():
    mesh = two_blocks(2)
    same, origin = separated(mesh, {})
    assert len(same.points) == len(mesh.points)
    np.testing.assert_array_equal(same.points[same.tets], mesh.points[mesh.tets])
    assert set(same.facets) == set(mesh.facets)
    assert len(np.unique(origin)) == len(mesh.points)


def test_a_mesh_of_one_part_is_refused():
    mesh = two_blocks(1)
    with pytest.raises(ValueError, match="only one part"):
        separated(TetMesh(mesh.points, mesh.tets), SIDES)
