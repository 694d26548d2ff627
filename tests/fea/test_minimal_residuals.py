"""Minimal residuals of matrices of either sign."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fea.solid.errors import StagnationError
from fea.solvers import minimal_residuals as module
from fea.solvers.minimal_residuals import minimal_residuals

SIZE = 40


def system(seed, negative, contrast):
    """A symmetric matrix with that many negative eigenvalues, and a positive definite preconditioner."""
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.standard_normal((SIZE, SIZE)))[0]
    values = np.geomspace(1.0, contrast, SIZE) * np.where(np.arange(SIZE) < negative, -1.0, 1.0)
    return (axes * values) @ axes.T, np.geomspace(1.0, 3.0, SIZE)[:, None], rng


@given(seed=st.integers(0, 2**32 - 1), negative=st.integers(0, SIZE), contrast=st.floats(1.0, 50.0))
def test_every_column_is_solved(seed, negative, contrast):
    matrix, scale, rng = system(seed, negative, contrast)
    # Of any size, one that vanishes and one that is there at once.
    b = rng.standard_normal((SIZE, 5)) * [1.0, 1e9, 0.0, 1e-9, 1.0]
    b[:, 4] = matrix @ scale[:, 0]
    x = minimal_residuals(matrix.__matmul__, lambda r: r / scale, b, tolerance=1e-10, remedy="")
    left = np.linalg.norm(matrix @ x - b, axis=0)
    # Norms of the preconditioner and of Euclid differ by the root of its condition, 3.
    assert (left <= 2e-10 * np.linalg.norm(b, axis=0)).all()


def test_no_more_steps_than_distinct_eigenvalues(monkeypatch):
    """Paige & Saunders (1975): the residual is least over the Krylov space, so two eigenvalues take two."""
    monkeypatch.setattr(module, "MOST_ITERATIONS", 2)
    axes = np.linalg.qr(np.random.default_rng(0).standard_normal((SIZE, SIZE)))[0]
    matrix = (axes * np.where(np.arange(SIZE) < 10, -3.0, 1.0)) @ axes.T
    b = np.ones((SIZE, 1))
    x = minimal_residuals(matrix.__matmul__, np.copy, b, tolerance=1e-12, remedy="")
    assert matrix @ x == pytest.approx(b, rel=1e-11)


def test_what_does_not_converge_is_not_returned(monkeypatch):
    monkeypatch.setattr(module, "MOST_ITERATIONS", 3)
    matrix, scale, rng = system(1, 20, 50.0)
    with pytest.raises(StagnationError, match=r"after 3 steps\. Mesh it finer"):
        minimal_residuals(
            matrix.__matmul__,
            lambda r: r / scale,
            rng.standard_normal((SIZE, 2)),
            tolerance=1e-10,
            remedy="Mesh it finer",
        )
