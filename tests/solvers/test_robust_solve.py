"""Models that can move are refused in words; conditioning is told; solvers that stagnate hand over."""

from dataclasses import replace

import numpy as np
import pytest

from fea.base.choices import SolverName, Support
from fea.base.material import Material, Materials
from fea.solid.assembly import pattern, stiffness
from fea.solid.errors import StagnationError, UnderconstrainedError
from fea.solid.parity import Parity, ParityPair
from fea.solid.supports import require_restrained
from fea.solvers import static as solve
from fea.solvers.direct import factorise
from fea.solvers.residuals import REFINE_ABOVE, condition_estimate, condition_of, probe
from geometry.bodies import block
from geometry.surfaces import Surface
from mesh.generate import mesh_body
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
        UnderconstrainedError,
        match=r"2 disconnected pieces.*, 10\d, .*\) mm.*translation along x.*rotation about z",
    ):
        require_restrained(both, fixed)
    require_restrained(both, np.ones_like(fixed))


def test_pieces_that_nothing_joins_are_not_held_one_by_one(bar):
    both = twice(bar)
    model = solve.Model(both, STEEL, Support.INERTIA_RELIEF)
    with pytest.raises(UnderconstrainedError, match="2 disconnected pieces"):
        model.solve([ParityPair(np.ones_like(both.points), None)])


def test_the_motion_left_is_named(bar):
    fixed = np.zeros_like(bar.points, dtype=bool)
    axis = np.flatnonzero(np.hypot(bar.points[:, 1], bar.points[:, 2]) < 1e-9)
    fixed[axis] = True
    with pytest.raises(UnderconstrainedError, match="rotation about x") as refused:
        require_restrained(bar, fixed)
    assert "translation along x" not in str(refused.value)


def hinged(mesh, axis):
    """The mesh and its half turn about the x axis, which share the nodes that `axis` tells."""
    count = len(mesh.points)
    shared = np.flatnonzero(axis(mesh.points))
    number = np.arange(count) + count
    number[shared] = shared
    points = np.vstack([mesh.points, mesh.points * [1, -1, -1]])
    tets = np.vstack([mesh.tets, number[mesh.tets]])
    used, tets = np.unique(tets, return_inverse=True)
    return TetMesh(points[used], tets.reshape(-1, 10))


@pytest.mark.parametrize("ends", [1, 2])
def test_a_hinge_is_found(bar, ends):
    """Joined along an edge the other piece turns about it; joined at a point as well about the others."""
    along = lambda p: np.hypot(p[:, 1], p[:, 2]) < 1e-9  # noqa: E731
    both = hinged(bar, along if ends == 1 else lambda p: along(p) & (p[:, 0] < 1e-9))
    fixed = np.zeros_like(both.points, dtype=bool)
    fixed[both.points[:, 1] > 2 - 1e-9] = True  # away from the joint
    with pytest.raises(UnderconstrainedError, match=r"only along an edge or at a point.*about x") as refused:
        require_restrained(both, fixed)
    assert ("rotation about y" in str(refused.value)) is (ends == 2)
    held = both.points[:, 1] < -2 + 1e-9  # a face of the other piece
    fixed[held] = True
    require_restrained(both, fixed)


def test_the_condition_is_estimated_to_its_order(bar):
    fixed = (np.abs(bar.points) < 1e-9)[:, :1].repeat(3, axis=1).ravel()
    K = stiffness(bar, STEEL, pattern(bar.tets, len(bar.points))).constrained(fixed)
    dense = K.full().toarray()
    root = np.sqrt(np.diag(dense))
    exact = np.linalg.cond(dense / np.outer(root, root))
    assert 0.3 * exact < condition_estimate(K, factorise(K)) < 5 * exact


def test_every_run_estimates_its_condition_beside_the_loads(bar):
    model = solve.Model(bar, STEEL, Support.INERTIA_RELIEF)
    K = model._K.constrained(model._restraints[Parity.SYMMETRIC]).full().toarray()
    root = np.sqrt(np.diag(K))
    exact = np.linalg.cond(K / np.outer(root, root))
    # A mere stretch says nothing of bending.
    stretch = np.where(np.arange(3) == 0, bar.points, 0.0).reshape(-1, 1)
    load = model._K @ stretch
    assert condition_of(model._K, stretch, load) < 0.3 * exact
    (found,) = model.solve([ParityPair(load.reshape(-1, 3), None)]).condition.values()
    assert 0.3 * exact < found < 5 * exact


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
    return [ParityPair(forces, None)]


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
    assert max(item.backward_error for item in solution.residuals.values()) < REFINE_ABOVE


def test_forces_left_over_in_a_soft_part_are_refined_away_though_a_stiff_one_hides_them(bar):
    part = (bar.points[bar.tets[:, 0], 0] > bar.points[:, 0].mean()).astype(np.int64)
    stiff = replace(STEEL, youngs_modulus=1e4 * STEEL.youngs_modulus)
    model = solve.Model(replace(bar, part=part), Materials((STEEL, stiff), part), Support.INERTIA_RELIEF)
    model._solver = Sloppy(model._solver)
    (residuals,) = model.solve(pulled(bar)).residuals.values()
    assert residuals.imbalance < 1e-8
