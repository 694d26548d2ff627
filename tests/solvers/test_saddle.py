"""Displacement and pressure from a solver of the stiffness."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse

from fea.solid.errors import StagnationError
from fea.solvers import iterative, mixed
from fea.solvers.mixed import Constraint, solve_saddle

N_U, N_P = 40, 12


def solved(seed, compliance, sizes):
    """Relative errors of both equations, a row a column of the load."""
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.standard_normal((N_U, N_U)))[0]
    stiff = np.geomspace(1.0, 20.0, N_U)
    A = (axes * stiff) @ axes.T
    D = rng.standard_normal((N_P, N_U))
    M = sparse.csr_array(sparse.diags_array(rng.uniform(1.0, 2.0, N_P)))
    tied = Constraint(sparse.csr_array(D), M, np.full(N_P, compliance), np.full(N_P, 10.0 + compliance))
    f, g = rng.standard_normal((N_U, len(sizes))) * sizes, rng.standard_normal((N_P, len(sizes))) * sizes
    u, p = solve_saddle(lambda r: (axes / stiff) @ (axes.T @ r), tied, f, g)
    left = np.concatenate([A @ u + D.T @ p - f, D @ u - compliance * (M @ p) - g])
    return np.linalg.norm(left, axis=0), np.linalg.norm(np.concatenate([f, g]), axis=0)


@given(seed=st.integers(0, 2**32 - 1), compliance=st.sampled_from([0.0, 1e-6, 0.1]))
def test_every_load_is_solved_for_whatever_its_size(seed, compliance):
    left, size = solved(seed, compliance, np.array([1.0, 1e9, 0.0, 1e-9]))
    # The tolerance is that of the reduced right-hand side D A⁻¹ f − g, which some ten rows of D scale up.
    assert (left <= 50 * 2 * mixed.TOLERANCE * size).all()


def test_nothing_is_asked_of_no_load():
    left, _ = solved(0, 0.1, np.zeros(2))
    assert not left.any()


def test_what_does_not_converge_is_not_returned(monkeypatch):
    monkeypatch.setattr(iterative, "MOST_ITERATIONS", 3)
    with pytest.raises(StagnationError, match=r"after 3 steps\. Use .*--size"):
        solved(1, 0.1, np.ones(2))
