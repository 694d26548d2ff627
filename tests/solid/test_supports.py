"""Restraints of inertia relief on meshes that have no nodes on the mid-planes."""

import numpy as np
import pytest
from tet_blocks import block

from fea.solid.supports import determinate_restraints, require_restrained
from mesh.tetmesh import TetMesh


@pytest.mark.parametrize("nearest", [0, 3, 8, 17])
def test_three_nodes_stop_every_motion_wherever_the_node_nearest_to_the_plane_is(nearest):
    file = block(4)
    points = file.points - np.array([2.0, 0.4, 0.4])
    points[nearest, 2] *= 0.9
    mesh = TetMesh(points, file.tets)
    held = determinate_restraints(mesh)
    assert held.sum() == 6
    require_restrained(mesh, held)


def test_the_ends_are_far_apart_where_few_nodes_lie_on_the_axis():
    file = block(4)
    points = file.points - np.array([2.0, 0.4, 0.4])
    points[8:, 1] -= 0.05  # the axis now passes nearest to the first nodes alone
    held = determinate_restraints(TetMesh(points, file.tets))
    ends = points[held.any(axis=1), 0]
    assert np.ptp(ends) == pytest.approx(np.ptp(points[:, 0]))
