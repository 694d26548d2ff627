"""Rayleigh and Ritz's values against dense eigenvalues."""

import numpy as np
import pytest
from scipy.linalg import eigh

from fea.solvers.buckling import largest, orthonormal

SIZE, COUNT = 150, 3


@pytest.fixture
def pencil():
    rng = np.random.default_rng(5)
    K = rng.normal(size=(SIZE, SIZE))
    A = rng.normal(size=(SIZE, SIZE))
    return A + A.T, K @ K.T + SIZE * np.eye(SIZE)


def found(A, K, start, count=COUNT, **limits):
    inverse = np.linalg.inv(K)
    first = orthonormal(inverse @ start, start)
    options = {"least": 1e-3, "accuracy": 1e-6} | limits
    return largest(lambda f: inverse @ f, lambda v: A @ v, first, count, **options)


def test_largest_eigenvalues_of_an_indefinite_matrix_through_restarts(pencil):
    A, K = pencil
    values, vectors = eigh(A, K)
    pairs = found(A, K, np.eye(SIZE)[:, :2])  # a poor start: the space is cut down on the way
    assert pairs.values == pytest.approx(values[::-1][:COUNT], rel=1e-9)
    assert pairs.residuals.max() <= 1e-6
    alike = np.abs(np.einsum("nk,nk->k", pairs.vectors, K @ vectors[:, ::-1][:, :COUNT]))
    assert alike == pytest.approx(np.ones(COUNT), rel=1e-9)


def test_what_was_found_serves_a_similar_matrix(pencil):
    A, K = pencil
    near = A + 0.02 * np.diag(np.sin(np.arange(SIZE)))
    inverse, calls = np.linalg.inv(K), []

    def solve(forces):
        calls.append(forces.shape[1])
        return inverse @ forces

    begun = found(A, K, np.eye(SIZE)[:, :2]).space
    pairs = largest(solve, lambda v: near @ v, begun, COUNT, least=1e-3, accuracy=1e-4)
    assert pairs.values == pytest.approx(eigh(near, K, eigvals_only=True)[::-1][:COUNT], rel=1e-6)
    assert len(calls) <= 4


def test_only_positive_eigenvalues_count(pencil):
    A, K = pencil
    squares = A @ A
    assert not found(-squares - np.eye(SIZE), K, np.eye(SIZE)[:, :4]).values.size
    one = found(np.outer(A[0], A[0]) - 1e-2 * np.eye(SIZE), K, np.eye(SIZE)[:, :4])
    assert one.values.size == 1


def test_eigenvalues_too_low_to_be_of_use_are_left_out(pencil):
    A, K = pencil
    values = eigh(A, K, eigvals_only=True)[::-1]
    pairs = found(A, K, np.eye(SIZE)[:, :2], enough=(values[0] + values[1]) / 2)
    assert pairs.values == pytest.approx(values[:1], rel=1e-9)
