"""The batched assembly against scikit-fem's general one, entry for entry in effect."""

import meshio
import numpy as np
import pytest
from skfem import CellBasis, ElementTetP1, ElementTetP2, ElementVector
from skfem.io.meshio import from_meshio
from skfem.models.elasticity import linear_elasticity
from strap import strap

from fea.material import Material
from fea.solid.assembly import pattern, stiffness
from fea.solid.mechanism import rigid_modes

STEEL = Material(207e3, 0.28, 7.7e-9, 620.4)


@pytest.mark.parametrize("order", [1, 2])
def test_equals_scikit_fem(order):
    mesh = strap(order=order)
    K = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points)))
    kind, element = ("tetra", ElementTetP1()) if order == 1 else ("tetra10", ElementTetP2())
    theirs = from_meshio(meshio.Mesh(mesh.points, [(kind, mesh.tets)]))
    basis = CellBasis(theirs, ElementVector(element), intorder=2 * (order - 1))
    K_theirs = linear_elasticity(STEEL.lame_lambda, STEEL.shear_modulus).assemble(basis)
    # their degrees of freedom in our order: by place and component
    places = np.round(basis.doflocs.T, 9)
    ours = {tuple(place): node for node, place in enumerate(np.round(mesh.points, 9))}
    component = np.empty(basis.N, dtype=int)
    for dofs in (basis.nodal_dofs, basis.edge_dofs):
        for axis in range(len(dofs)):
            component[dofs[axis]] = axis
    order_of = np.array([3 * ours[tuple(place)] for place in places]) + component
    u = np.random.default_rng(0).standard_normal((K.size, 3))
    expected = K_theirs @ u[order_of]
    assert (K @ u)[order_of] == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


def test_rigid_motion_costs_nothing():
    mesh = strap()
    K = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points)))
    modes = rigid_modes(mesh.points).reshape(-1, 6)
    assert np.abs(K @ modes).max() < 1e-10 * K.norm()


def test_the_norm_is_the_largest_row_sum():
    mesh = strap(size=8.0, order=1)
    K = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points)))
    full = K @ np.eye(K.size)
    assert K.norm() == pytest.approx(np.abs(full).sum(axis=1).max(), rel=1e-12)
    assert full == pytest.approx(full.T, abs=1e-9 * K.norm())


def test_constrained_rows_keep_only_their_diagonal():
    mesh = strap(size=8.0, order=1)
    K = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points)))
    fixed = np.zeros(K.size, dtype=bool)
    fixed[[3, 7]] = True
    held = K.constrained(fixed) @ np.eye(K.size)
    expected = K @ np.eye(K.size)
    expected[fixed] = expected[:, fixed] = 0
    expected[fixed, fixed] = K.diagonal()[fixed]
    assert held == pytest.approx(expected, abs=1e-9 * K.norm())


def test_triangles_and_products_are_of_one_matrix():
    mesh = strap(size=8.0, order=1)
    K = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points)))
    full = K.full().toarray()
    close = 1e-13 * K.norm()
    assert full == pytest.approx(full.T, abs=close)
    assert K.scalar_upper().toarray() == pytest.approx(np.triu(full), abs=close)
    assert K @ np.eye(K.size) == pytest.approx(full, abs=close)
    assert K @ np.ones(K.size) == pytest.approx(full.sum(axis=1), abs=close)
    assert K.row_sums == pytest.approx(np.abs(full).sum(axis=1), rel=1e-12)
    assert K.diagonal() == pytest.approx(np.diag(full), rel=1e-15)
