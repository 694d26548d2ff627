"""The numbering of scikit-fem, held to scikit-fem's own tables."""

from dataclasses import replace

import numpy as np
import pytest
from skfem import MeshTet
from strap import strap

from geometry.surfaces import Surface
from mesh.tetmesh import numbered, refined, reflect, unmirrored

CELL = strap()
WHOLE = reflect(reflect(unmirrored(CELL), Surface.SYMMETRY_Y), Surface.SYMMETRY_Z)
MESHES = {
    "drawn": CELL,
    "whole": WHOLE.mesh,
    "half": reflect(unmirrored(CELL), Surface.SYMMETRY_Z).mesh,
    "refined": refined(strap(size=8.0)),
}


def elements_of_scikit_fem(mesh):
    """Nodes of the elements as scikit-fem numbers them: vertices, then the edges of its own table."""
    n_vertices = int(mesh.tets[:, :4].max()) + 1
    theirs = MeshTet(mesh.points[:n_vertices].T.copy(), mesh.tets[:, :4].T.copy())
    return np.vstack([theirs.t, n_vertices + theirs.t2e]).T


@pytest.fixture(scope="module")
def shuffled():
    """The cell with its nodes in any order, and the node of the cell behind each."""
    order = np.random.default_rng(0).permutation(len(CELL.points))
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    facets = {surface: number[nodes] for surface, nodes in CELL.facets.items()}
    return replace(CELL, points=CELL.points[order], tets=number[CELL.tets], facets=facets)


@pytest.mark.parametrize("name", MESHES)
def test_meshes_come_in_the_order_of_scikit_fem(name):
    mesh = MESHES[name]
    np.testing.assert_array_equal(mesh.tets, elements_of_scikit_fem(mesh))
    again, order = numbered(mesh)
    np.testing.assert_array_equal(order, np.arange(len(mesh.points)))
    np.testing.assert_array_equal(again.tets, mesh.tets)


def test_any_mesh_can_be_brought_to_that_order(shuffled):
    mesh, order = numbered(shuffled)
    np.testing.assert_array_equal(mesh.tets, elements_of_scikit_fem(mesh))
    np.testing.assert_array_equal(mesh.points, shuffled.points[order])
    np.testing.assert_array_equal(mesh.points[mesh.tets], CELL.points[CELL.tets])
    for surface, facets in CELL.facets.items():
        np.testing.assert_array_equal(mesh.points[mesh.facets[surface]], CELL.points[facets])


def test_nodes_without_an_element_come_last():
    lone = np.array([[1e3, 0.0, 0.0]])
    mesh = replace(CELL, points=np.vstack([lone, CELL.points]), tets=CELL.tets + 1, facets={})
    found, order = numbered(mesh)
    np.testing.assert_array_equal(found.tets, CELL.tets)
    assert order[-1] == 0


def test_nodes_of_first_order_stay():
    mesh = strap(order=1)
    np.testing.assert_array_equal(numbered(mesh)[1], np.arange(len(mesh.points)))


def test_a_node_of_the_cell_comes_before_its_images():
    _, first = np.unique(WHOLE.source, return_index=True)
    assert (WHOLE.sign[first] == 1).all()
    np.testing.assert_array_equal(WHOLE.mesh.points[first], CELL.points)
