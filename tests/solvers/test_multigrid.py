"""Conjugate gradients on two levels against the direct solver, which first-order meshes have in any case."""

import numpy as np
import pytest
from strap import strap

from fea.base.choices import SolverName
from fea.base.material import Material
from fea.solid.assembly import linear_stiffness, pattern, stiffness
from fea.solid.parity import Parity
from fea.solid.supports import clamped, plane_conditions
from fea.solvers import iterative
from fea.solvers.choice import linear_solver
from fea.solvers.direct import direct
from geometry.surfaces import Surface
from mesh.tetmesh import EDGES

STEEL = Material(207e3, 0.28, 7.7e-9, 620.4)


def held_stiffness(mesh):
    K = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points)))
    held = plane_conditions(mesh, Parity.SYMMETRIC) | clamped(mesh, Surface.BIG_END_BORE)
    return K.constrained(held.ravel())


def test_the_coarse_matrix_is_the_restriction_of_the_fine_one():
    mesh = strap(size=8.0)
    K = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points)))
    vertices = np.unique(mesh.tets[:, :4])
    coarse = np.random.default_rng(1).standard_normal((len(vertices), 3, 2))
    fine = np.zeros((len(mesh.points), 3, 2))
    fine[vertices] = coarse
    for middle, (a, b) in zip(mesh.tets[:, 4:].T, EDGES, strict=True):
        fine[middle] = (fine[mesh.tets[:, a]] + fine[mesh.tets[:, b]]) / 2
    u, v = fine.reshape(-1, 2).T
    x, y = coarse.reshape(-1, 2).T
    restricted = linear_stiffness(mesh, STEEL)
    assert x @ (restricted @ y) == pytest.approx(u @ (K @ v), rel=1e-12)
    assert x @ (restricted @ x) == pytest.approx(u @ (K @ u), rel=1e-12)


def test_iterations_do_not_grow_with_the_mesh(monkeypatch):
    counts = []
    smooth = iterative._TwoLevels.precondition

    def counted(levels, residual):
        counts[-1] += 1
        return smooth(levels, residual)

    monkeypatch.setattr(iterative._TwoLevels, "precondition", counted)
    for size in (10.0, 5.0, 3.0):
        mesh = strap(size=size)
        matrix = held_stiffness(mesh)
        solver = linear_solver(SolverName.AMG, mesh, STEEL, slots=1)
        solver.factorise(0, matrix)
        counts.append(0)
        solver.solve(0, np.where(matrix.row_sums == matrix.diagonal(), 0.0, 1.0)[:, None])
    # plain conjugate gradients double their iterations when the elements are halved
    assert max(counts) < 30
    assert counts[-1] < 1.5 * counts[0]


def test_first_order_meshes_are_solved_directly():
    mesh = strap(size=10.0, order=1)
    assert linear_solver(SolverName.AMG, mesh, STEEL, slots=1).name == direct()


def test_agrees_with_the_direct_solver():
    mesh = strap(size=5.0)
    matrix = held_stiffness(mesh)
    f = np.random.default_rng(0).standard_normal((matrix.size, 3))
    f[:, 1] = 0.0
    answers = []
    for name in (SolverName.PARDISO, SolverName.AMG):
        solver = linear_solver(name, mesh, STEEL, slots=1)
        solver.factorise(0, matrix)
        answers.append(solver.solve(0, f))
    # a residual of 1e-8 in a matrix of condition 1e6, damped by the smoothness of the error
    assert answers[1] == pytest.approx(answers[0], abs=1e-6 * np.abs(answers[0]).max())
    assert not answers[1][:, 1].any()
