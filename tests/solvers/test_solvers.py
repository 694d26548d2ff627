import os
import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pytest
from scipy import sparse
from strap import strap

from fea.base.choices import SolverName
from fea.base.material import Material
from fea.solid.assembly import SymmetricMatrix, pattern, stiffness
from fea.solid.errors import SingularMatrixError, StagnationError
from fea.solid.parity import Parity
from fea.solid.supports import clamped, plane_conditions
from fea.solvers.choice import chosen, linear_solver
from fea.solvers.direct import direct, node_order
from geometry.surfaces import Surface

STEEL = Material(207e3, 0.28, 7.7e-9, 620.4)

# Each is a dependency on some systems only.
PARDISO = pytest.mark.skipif(find_spec("pypardiso") is None, reason="not on this system")
CHOLMOD = pytest.mark.skipif(None in map(find_spec, ("cvxopt", "pymetis")), reason="not on this system")
DIRECT = [
    pytest.param(SolverName.PARDISO, marks=PARDISO),
    pytest.param(SolverName.CHOLMOD, marks=CHOLMOD),
]
MESH = strap()


@pytest.fixture(scope="module")
def matrices():
    mesh = MESH
    K = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points)))
    held = clamped(mesh, Surface.BIG_END_BORE)
    return [K.constrained((plane_conditions(mesh, parity) | held).ravel()) for parity in Parity]


@pytest.mark.parametrize("name", DIRECT)
def test_both_slots_solve_to_backward_stability(name, matrices):
    solver = linear_solver(name, MESH, STEEL, slots=2)
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
    upper.data[upper.indptr[:-1]] *= -1
    with pytest.raises(SingularMatrixError, match="not positive definite"):
        linear_solver(name, MESH, STEEL, slots=1).factorise(0, SymmetricMatrix(upper))


@pytest.fixture(scope="module")
def forces(matrices):
    """Some sparse columns and one full one, of which the last is zero."""
    rows = np.random.default_rng(1).random((matrices[0].size, 7))
    rows[rows > np.r_[0.02 * np.ones(6), 1.0]] = 0.0
    return sparse.csc_array(np.hstack([rows, np.zeros((len(rows), 1))]))


@pytest.mark.parametrize("name", DIRECT)
def test_one_factor_condenses_forces_and_solves(name, matrices, forces):
    solver = linear_solver(name, MESH, STEEL, slots=2)
    plain = linear_solver(name, MESH, STEEL, slots=1)
    f = np.random.default_rng(0).standard_normal((matrices[0].size, 130))
    work = [solver.condense(slot, matrix, forces) for slot, matrix in enumerate(matrices)]
    for slot, matrix in enumerate(matrices):
        plain.factorise(0, matrix)
        exact = forces.T @ plain.solve(0, forces.toarray())
        assert work[slot] == pytest.approx(exact, rel=1e-10, abs=1e-12 * np.abs(exact).max())
        of_f = f.T @ plain.solve(0, f)
        assert solver.work(slot, f) == pytest.approx(of_f, rel=1e-10, abs=1e-12 * np.abs(of_f).max())
        columns = np.random.default_rng(2).standard_normal((forces.shape[1], 70))
        sums = (forces @ columns, solver.solve_sums(slot, forces, columns))
        for sides, u in ((f, solver.solve(slot, f)), sums):
            residual = np.abs(matrix @ u - sides).max()
            assert residual < 1e-14 * (matrix.norm() * np.abs(u).max() + np.abs(sides).max())


@pytest.mark.parametrize("name", DIRECT)
@pytest.mark.parametrize("sign", [-1.0, 0.0])
def test_forces_are_not_condensed_with_a_matrix_that_is_not_positive_definite(name, sign, matrices, forces):
    upper = matrices[0].upper.copy()
    upper.data[upper.indptr[len(upper.indptr) // 2]] *= sign
    with pytest.raises(SingularMatrixError, match="not positive definite"):
        linear_solver(name, MESH, STEEL, slots=1).condense(0, SymmetricMatrix(upper), forces)


def test_other_forces_may_follow_in_another_slot(matrices, forces):
    solver = linear_solver(direct(), MESH, STEEL, slots=2)
    first, second = solver.condense(0, matrices[0], forces), solver.condense(1, matrices[0], forces[:, :3])
    assert second == pytest.approx(first[:3, :3], rel=1e-10)
    f = np.ones((matrices[0].size, 1))
    assert solver.solve(0, f) == pytest.approx(solver.solve(1, f), rel=1e-9)


@CHOLMOD
def test_the_node_order_is_a_permutation_that_keeps_nodes_together(matrices):
    order = node_order(matrices[0])
    assert np.array_equal(np.sort(order), np.arange(matrices[0].size))
    assert np.array_equal(order.reshape(-1, 3) % 3, np.tile([0, 1, 2], (len(order) // 3, 1)))


def test_stagnation_is_never_returned(matrices, monkeypatch):
    monkeypatch.setattr("fea.solvers.iterative.MOST_ITERATIONS", 2)
    solver = linear_solver(SolverName.AMG, MESH, STEEL, slots=1)
    solver.factorise(0, matrices[0])
    with pytest.raises(StagnationError, match="stagnated at a relative residual"):
        solver.solve(0, np.ones((matrices[0].size, 1)))


@pytest.mark.parametrize(("free_gib", "solver"), [(24, SolverName.PARDISO), (4, SolverName.AMG), (0.5, None)])
def test_auto_chooses_by_predicted_memory(free_gib, solver, monkeypatch):
    monkeypatch.setattr("fea.solvers.choice.available_bytes", lambda: free_gib * 2**30)
    if solver is None:
        with pytest.raises(MemoryError, match=r"degrees of freedom need about .* MiB.*times as large"):
            chosen(SolverName.AUTO, 500_000, slots=2)
    else:
        assert chosen(SolverName.AUTO, 500_000, slots=2) is solver


@pytest.mark.skipif(sys.platform == "win32", reason="there is no such limit")
def test_memory_under_a_limit_is_seen():
    code = (
        "import resource; resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30)); "
        "from fea.solvers.choice import available_bytes; print(available_bytes())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert 0 < float(done.stdout) < 4 * 2**30


@pytest.mark.slow
def test_single_right_hand_sides_are_solved_with_more_threads_than_the_tests_have():
    """Buckling solves for one side at a time; elsewhere the tests keep all libraries in one thread."""
    environment = os.environ | dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS"), "2")
    command = [sys.executable, "-m", "fea", "verify", "euler-column"]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
