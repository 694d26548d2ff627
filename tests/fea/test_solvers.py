import numpy as np
import pytest
from strap import strap

from fea.choices import SolverName
from fea.material import Material
from fea.solid.assembly import SymmetricMatrix, pattern, stiffness
from fea.solid.cholmod import node_order
from fea.solid.errors import SingularMatrixError
from fea.solid.parity import Parity
from fea.solid.solvers import direct_solver
from fea.solid.supports import clamped, plane_conditions
from geometry.surfaces import Surface

STEEL = Material(207e3, 0.28, 7.7e-9, 620.4)
DIRECT = [SolverName.PARDISO, SolverName.CHOLMOD]


@pytest.fixture(scope="module")
def matrices():
    mesh = strap()
    K = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points)))
    held = clamped(mesh, Surface.BIG_END_BORE)
    return [K.constrained((plane_conditions(mesh, parity) | held).ravel()) for parity in Parity]


@pytest.mark.parametrize("name", DIRECT)
def test_both_slots_solve_to_backward_stability(name, matrices):
    solver = direct_solver(name, slots=2)
    f = np.random.default_rng(0).standard_normal((matrices[0].size, 3))
    for slot, matrix in enumerate(matrices):
        solver.factorise(slot, matrix)
    for slot, matrix in reversed(list(enumerate(matrices))):
        u = solver.solve(slot, f)
        residual = np.abs(matrix @ u - f).max()
        assert residual < 1e-14 * (matrix.norm() * np.abs(u).max() + np.abs(f).max())


@pytest.mark.parametrize("name", DIRECT)
def test_an_indefinite_matrix_is_refused(name, matrices):
    upper = matrices[0].upper.copy()
    upper.setdiag(-matrices[0].diagonal())
    with pytest.raises(SingularMatrixError, match="not positive definite"):
        direct_solver(name, slots=1).factorise(0, SymmetricMatrix(upper))


def test_the_node_order_is_a_permutation_that_keeps_nodes_together(matrices):
    order = node_order(matrices[0].upper)
    assert np.array_equal(np.sort(order), np.arange(matrices[0].size))
    assert np.array_equal(order.reshape(-1, 3) % 3, np.tile([0, 1, 2], (len(order) // 3, 1)))
