"""Models that can move are refused in words; conditioning is told; solvers that stagnate hand over."""

import numpy as np
import pytest

from fea.choices import SolverName, Support
from fea.material import Material
from fea.solid import solve
from fea.solid.assembly import pattern, stiffness
from fea.solid.condition import condition_estimate, condition_of, probe
from fea.solid.errors import StagnationError, UnderconstrainedError
from fea.solid.parity import Split
from fea.solid.solvers import factorise
from fea.solid.supports import require_restrained
from geometry.bodies.shape import block
from geometry.surfaces import Surface
from mesh.body import mesh_body
from mesh.tetmesh import TetMesh

STEEL = Material(210e3, 0.3, 7.85e-9, 400.0)


@pytest.fixture(scope="module")
def bar():
    return mesh_body(block(10.0, 2.0, 2.0, Surface.BIG_END_BORE), 2.0)


def twice(mesh):
    """The mesh and, apart from it, its copy."""
    away = mesh.points + np.array([0, 100.0, 0])
    return TetMesh(np.vstack([mesh.points, away]), np.vstack([mesh.tets, mesh.tets + len(mesh.points)]))


def test_each_piece_must_be_held(bar):
    both = twice(bar)
    fixed = np.zeros_like(both.points, dtype=bool)
    fixed[: len(bar.points)] = True
    with pytest.raises(
        UnderconstrainedError, match=r"2 pieces.*\(5.*101, .*\) mm.*slide along x.*turn about z"
    ):
        require_restrained(both, fixed)
    require_restrained(both, np.ones_like(fixed))


def test_the_motion_left_is_named(bar):
    fixed = np.zeros_like(bar.points, dtype=bool)
    axis = np.flatnonzero(np.hypot(bar.points[:, 1], bar.points[:, 2]) < 1e-9)
    fixed[axis] = True
    with pytest.raises(UnderconstrainedError, match="turn about x") as refused:
        require_restrained(bar, fixed)
    assert "slide along x" not in str(refused.value)


def test_the_condition_is_estimated_to_its_order(bar):
    fixed = (np.abs(bar.points) < 1e-9)[:, :1].repeat(3, axis=1).ravel()
    K = stiffness(bar, STEEL, pattern(bar.tets, len(bar.points))).constrained(fixed)
    full = K.full().toarray()
    root = np.sqrt(np.diag(full))
    exact = np.linalg.cond(full / np.outer(root, root))
    assert 0.3 * exact < condition_estimate(K, factorise(K)) < 5 * exact


def test_every_run_estimates_its_condition_beside_the_loads(bar):
    model = solve.Model(bar, STEEL, Support.INERTIA_RELIEF)
    (found,) = model.solve(pulled(bar)).condition.values()
    K = model._K.constrained(model._held.ravel())
    full = K.full().toarray()
    root = np.sqrt(np.diag(full))
    exact = np.linalg.cond(full / np.outer(root, root))
    assert 0.3 * exact < found < 5 * exact
    # A mere stretch would say nothing of bending.
    stretch = np.where(np.arange(3) == 0, bar.points, 0.0).reshape(-1, 1)
    assert condition_of(model._K, stretch, model._K @ stretch) < 0.3 * exact


def test_a_solution_against_its_load_has_no_condition(bar):
    K = stiffness(bar, STEEL, pattern(bar.tets, len(bar.points)))
    f = probe(K)
    assert condition_of(K, -f, f) == np.inf
    assert condition_of(K, f * np.nan, f) == np.inf
    assert condition_of(K, 0 * f, 0 * f) == 1


class Stagnant:
    name = "amg"

    def factorise(self, slot, matrix):
        pass

    def solve(self, slot, right_hand_sides):
        raise StagnationError("stuck")


class Sloppy:
    """A solver whose answers are a little wrong."""

    name = "sloppy"

    def __init__(self, solver):
        self.solver = solver
        self.factorise = solver.factorise

    def solve(self, slot, right_hand_sides):
        return self.solver.solve(slot, right_hand_sides) * (1 + 1e-6)


def pulled(bar):
    forces = np.zeros_like(bar.points)
    forces[bar.points[:, 0].argmin(), 0], forces[bar.points[:, 0].argmax(), 0] = -1.0, 1.0
    return [Split(forces, None)]


def test_a_stagnating_solver_hands_over(bar, monkeypatch):
    model = solve.Model(bar, STEEL, Support.INERTIA_RELIEF, SolverName.AMG)
    model._solver = Stagnant()
    solution = model.solve(pulled(bar))
    assert model.solver in ("pardiso", "cholmod")
    assert max(item.backward_error for item in solution.residuals.values()) < 1e-14
    model._solver = Stagnant()
    monkeypatch.setattr(solve.memory, "available_bytes", lambda: 0.0)
    with pytest.raises(StagnationError):
        model.solve(pulled(bar))


def test_a_large_backward_error_is_refined_away(bar):
    model = solve.Model(bar, STEEL, Support.INERTIA_RELIEF)
    model._solver = Sloppy(model._solver)
    solution = model.solve(pulled(bar))
    assert max(item.backward_error for item in solution.residuals.values()) < solve.REFINE_ABOVE
