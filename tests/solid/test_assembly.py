"""The batched assembly against scikit-fem's general one, entry by entry."""

import numpy as np
import pytest
from skfem import CellBasis, ElementTetP1, ElementTetP2, ElementVector, MeshTet, MeshTet2
from skfem.models.elasticity import linear_elasticity
from strap import strap

from fea.base.material import Material
from fea.solid.assembly import SymmetricMatrix, pattern, stiffness
from fea.solid.supports import rigid_modes
from geometry.surfaces import Surface
from mesh.tetmesh import reflect, unmirrored

STEEL = Material(207e3, 0.28, 7.7e-9, 620.4)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("whole", [False, True])
def test_equals_scikit_fem(order, whole):
    mesh = strap(size=6.0, order=order)
    if whole:
        mesh = reflect(unmirrored(mesh), Surface.SYMMETRY_Y).mesh
    K = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points))).full()
    kind, element = (MeshTet, ElementTetP1()) if order == 1 else (MeshTet2, ElementTetP2())
    theirs = kind(mesh.points.T.copy(), mesh.tets[:, :4].T.copy())  # the nodes of the edges follow from these
    basis = CellBasis(theirs, ElementVector(element), intorder=2 * (order - 1))
    expected = linear_elasticity(STEEL.lame_lambda, STEEL.shear_modulus).assemble(basis)
    assert np.abs(K - expected).max() < 1e-13 * np.abs(expected).max()


@pytest.mark.parametrize("order", [1, 2])
def test_the_upper_triangle_of_a_full_matrix(order):
    mesh = strap(size=8.0, order=order)
    K = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points)))
    again = SymmetricMatrix.of_full(K.full())
    for name in ("indptr", "indices", "data"):
        np.testing.assert_array_equal(getattr(again.upper, name), getattr(K.upper, name))


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
    dense = K.full().toarray()
    close = 1e-13 * K.norm()
    assert dense == pytest.approx(dense.T, abs=close)
    assert K.scalar_upper().toarray() == pytest.approx(np.triu(dense), abs=close)
    assert K @ np.eye(K.size) == pytest.approx(dense, abs=close)
    assert K @ np.ones(K.size) == pytest.approx(dense.sum(axis=1), abs=close)
    assert K.row_sums == pytest.approx(np.abs(dense).sum(axis=1), rel=1e-12)
    assert K.diagonal() == pytest.approx(np.diag(dense), rel=1e-15)
